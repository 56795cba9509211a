"""A contact that rolls over the same half-space again and again."""

"""Answers of a solve, in the user's units and words: a contact, a lubricated contact, an evolution of either."""

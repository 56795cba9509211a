"""Lubricated contacts: the film, where it cavitates, and its friction. May import `scene` and below."""

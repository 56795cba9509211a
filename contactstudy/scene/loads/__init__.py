"""Loads, constant or changing in time. May import `domain`."""

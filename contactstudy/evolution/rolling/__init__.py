"""Contacts that roll: steadily, or repeatedly over a body that yields."""

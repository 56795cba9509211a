"""Contacts that change in time: memories, steps, their control, the result. May import `accuracy`, `scene` and below."""

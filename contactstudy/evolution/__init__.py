"""Contacts that change in time: state variables, steps, their control, results. May import `accuracy`, `scene`."""

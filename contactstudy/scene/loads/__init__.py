"""Loads of a scene: constant, changing in time, or found as a result."""

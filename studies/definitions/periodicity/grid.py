"""Accuracy against the number of cells."""

from studies.reference.line_contact import axes, measures, scene_at

__all__ = ["measures", "points", "scene_at"]

points = axes(grid=(16, 24, 32, 48, 64, 96, 128, 192, 256))

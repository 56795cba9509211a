"""Accuracy against the number n of superposed periods."""

from studies.reference.line_contact import axes, measures, scene_at

__all__ = ["measures", "points", "scene_at"]

points = axes(
    padding=("superposed", "circular", "duplicated", "exact"),
    images=(0, 1, 2, 3, 4, 6, 8, 10, 20, 50),
    period=(0.6, 2.4, 9.6),
)

"""Accuracy against the period length."""

from studies.reference.line_contact import axes, measures, scene_at

__all__ = ["measures", "points", "scene_at"]

points = axes(period=(0.15, 0.3, 0.6, 1.2, 2.4, 4.8, 9.6))

"""Padding strategies side by side: what each reaches, and at what cost."""

from studies.reference.line_contact import axes, measures, scene_at

__all__ = ["measures", "points", "scene_at"]

points = axes(images=(1, 6, 20), period=(0.6, 2.4), grid=(32, 64, 128, 256))

"""Stress and surface displacement by plastic strain in a half-space: operators on a box of cells below the surface."""

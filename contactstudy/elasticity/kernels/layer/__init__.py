"""Influence coefficients of a half-space with a bonded layer: displacement and stress under pressure and shear."""

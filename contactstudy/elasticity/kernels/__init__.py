"""Influence coefficients in closed form: one cell, a row of images, a lattice. May import `domain`."""

"""Influence coefficients of a cell, a row of images and a lattice: closed forms and sums. May import `domain`."""

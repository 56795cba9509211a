"""The base of the package: grids, paddings, precision, units, checks. Imports nothing of this package."""

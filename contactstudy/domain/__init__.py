"""What everything else stands on: grids, paddings, precision, units, checks. Imports nothing of this package."""

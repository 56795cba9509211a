"""Scene files, units in files, and solutions as labelled datasets. May import everything else of the core."""

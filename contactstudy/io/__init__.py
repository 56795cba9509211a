"""Scene files, units in files, and solutions as labelled datasets. May import `planning` and below."""

"""Storage of results: journal, case identity, netCDF, provenance. May import `model`."""

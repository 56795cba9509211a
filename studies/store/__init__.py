"""What is kept: journal, case identity, netCDF, provenance, locks. May import `model`."""

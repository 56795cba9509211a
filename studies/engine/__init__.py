"""Computation of cases: what is stored and missing, dask, supervised workers, timing. May import `store` and `model`."""

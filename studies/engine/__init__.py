"""Computation of cases: the run, executors, supervised workers, timing, forecasts. May import `store` and `model`."""

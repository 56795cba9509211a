"""How cases are computed: the run, executors, supervised workers, timing, forecasts. May import `store` and `model`."""

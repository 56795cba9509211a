"""The contact problem in SI units, and its dimensionless form: arrays, operator, constraint, load or approach.

May import `elasticity` and `domain`."""

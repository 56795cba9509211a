"""The dimensionless problem: arrays, operator, constraint, resultant. Knows no physical model.

May import `elasticity` and `domain`."""

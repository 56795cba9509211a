"""The dimensionless problem: arrays, operator, constraint, resultant. Independent of any physical model. May import `elasticity` and `domain`."""

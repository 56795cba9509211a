"""The waist: arrays, one operator, one constraint, one load. Knows no effect. May import `elasticity` and `domain`."""

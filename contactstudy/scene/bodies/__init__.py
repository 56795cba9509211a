"""The bodies: half-spaces, coated and viscoelastic ones. May import `elasticity` and `domain`."""

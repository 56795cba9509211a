"""References for solutions: the smooth line contact, the dense solver, hard cases. May import `model`."""

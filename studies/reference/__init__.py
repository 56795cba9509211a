"""What answers are compared with: the smooth line contact, the dense solver, hard cases. May import `model`."""

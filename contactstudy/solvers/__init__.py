"""Iterations for the dimensionless problem, and their solutions. May import `problem` and below."""

"""Iterations for the dimensionless problem, and what they return. May import `problem` and below."""

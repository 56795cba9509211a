"""Influence coefficients, and operators on a grid made from them. May import `domain`."""

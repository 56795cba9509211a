"""From influence coefficients to an operator on a grid. May import `domain`."""

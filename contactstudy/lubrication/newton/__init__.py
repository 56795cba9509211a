"""Newton's iteration for a film in pseudo-time, and the solvers of its linear systems."""

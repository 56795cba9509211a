"""Pictures of solutions, comparisons and evolutions, in one style. May import `io.dataset` and below."""

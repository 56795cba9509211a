"""Error estimates, by cause. May import `scene`, `solvers` and below."""

"""Films in time: their steps (``evolve_lubricated``), and the errors of these (``film_trajectory``)."""

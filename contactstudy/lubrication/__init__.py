"""Elastohydrodynamic line contacts: film thickness, pressure, cavitation, friction. May import `scene` and below.

In the order of the method: ``film_equation`` (Reynolds' equation on cells, and its linearisation), ``posed_film`` (a
scene as that equation in Hertz units), ``pseudo_time`` (Newton's iteration), ``plane_strain`` and ``along_length`` (its
linear systems), ``continuation`` (from higher speeds), ``mixed`` (asperities on a boundary film), ``steady_film`` (cold
starts and nested grids), ``film_heat`` (temperatures), ``solve_lubricated`` (grid and errors), ``evolve_lubricated`` (in
time) and ``film_trajectory`` (its errors); ``lubricated_contact`` is the result.
"""

"""Elastohydrodynamic line contacts: film thickness, pressure, cavitation, friction. May import `scene` and below.

In the order of the method: ``film_equation`` (Reynolds' equation on cells, and its linearisation), ``pseudo_time`` (Newton's
iteration in pseudo-time), ``linear_solvers`` (its linear systems), ``posed_film`` (a scene as that equation in Hertz units),
``steady_film`` (cold starts, nested grids, higher speeds, and asperities on a boundary film),
``film_heat`` (temperatures);
``lubricated_contact`` is the result. Films in time are in ``contactstudy.evolution.films``.
"""

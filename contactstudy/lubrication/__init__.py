"""Elastohydrodynamic line contacts: film thickness, pressure, cavitation, friction. May import `scene` and below.

In the order of the method: ``film_equation`` (Reynolds' equation on cells, and its linearisation), ``linear_solvers``
(the linear systems of Newton's iteration) and ``pseudo_time`` (that iteration), ``posed_film`` (a scene as that
equation in Hertz units), ``steady_film`` (cold starts, nested grids, higher speeds, and asperities on a boundary film),
``film_friction`` (shear stress and temperatures). ``lubricated_contact`` is the result. Films in time are in
``contactstudy.evolution.evolve_lubricated``, grids for an error in ``contactstudy.planning.film_plan``.
"""

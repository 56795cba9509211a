"""Lubricated contacts: the film, where it cavitates, and its friction. May import `scene` and below.

In the order of the method: ``posed_film`` (a scene in Hertz units), ``film_equation`` (balance of flow, and its
linearisation), ``pseudo_time`` (the iteration), ``plane_strain`` and ``along_length`` (its linear systems), ``mixed``
(asperities on a boundary film), ``steady_film`` (starts and nested grids), ``solve_lubricated`` (grid and errors),
``evolve_lubricated`` (in time) and ``film_trajectory`` (its errors); ``lubricated_contact`` is the result.
"""

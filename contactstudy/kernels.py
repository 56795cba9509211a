"""Influence coefficients of a uniformly loaded rectangular cell on an elastic half-space.

``pi E*`` times the displacement [m] under unit pressure: of one cell, of a row of images along y, of
a lattice of images along both axes.
"""

from contactstudy.elasticity.kernels.displacement_cell import boussinesq_cell
from contactstudy.elasticity.kernels.displacement_periodic import (
    boussinesq_cell_doubly_periodic,
    boussinesq_cell_periodic,
)

__all__ = ["boussinesq_cell", "boussinesq_cell_doubly_periodic", "boussinesq_cell_periodic"]

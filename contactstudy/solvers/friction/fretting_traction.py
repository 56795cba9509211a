"""Tangential traction of a contact that frets, with the loop, the slip and the energy that belong to it."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.solvers.solution import TangentialTraction


@dataclass(frozen=True, eq=False)
class FrettingTraction(TangentialTraction):
    """Tangential traction on the first body after the last of several forces, and the slip of the last cycle.

    The last cycle begins at the previous occurrence of the last force; the whole history counts if no cycle is complete.

    Parameters
    ----------
    forces
        Tangential forces (steps + 1,) [N] on the grid, starting from 0 N.
    rigid_displacement
        Rigid displacement along x (steps + 1,) [m] of the second body against the first, from 0 m on.
    shears
        Traction after each force (step, component, x, y) [Pa].
    slip_distance
        Distance slipped in the last cycle (x, y) [m].
    energy
        Energy lost to friction in the last cycle, per area (x, y) [J/m^2].
    cycle_start
        Index in `forces` of the force at which the last cycle begins, and in `shears` of its first step.
    """

    forces: Array
    rigid_displacement: Array
    shears: Array
    slip_distance: Array
    energy: Array
    cycle_start: int

    @property
    def largest_shear(self) -> float:
        """Largest tangential traction [Pa] of all steps."""
        return float(np.hypot(self.shears[:, 0], self.shears[:, 1]).max(initial=0.0))

"""Tangential traction of a contact that frets, and of one that rolls, with its slip, energy and power."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

import numpy as np

from contactstudy.domain.grid import Array, Grid
from contactstudy.problem.problem import Field
from contactstudy.solvers.solution import OF_SURFACE, TangentialTraction


@dataclass(frozen=True, eq=False)
class FrettingTraction(TangentialTraction):
    """Tangential traction on the first body after the last of several forces, and the slip of the last whole cycle.

    A whole cycle goes from a reversal of the force to the next but one, at the same force. Without one, slip and energy
    are those of the whole history.

    Parameters
    ----------
    forces
        Tangential forces (steps + 1,) [N] on the grid, starting from 0 N.
    rigid_displacement
        Rigid displacement along x (steps + 1,) [m] of the second body against the first, from 0 m on.
    shears
        Traction after each force (step, component, x, y) [Pa].
    slip_distance
        Distance slipped in the last whole cycle (x, y) [m].
    energy
        Energy lost to friction in the last whole cycle, per area (x, y) [J/m^2].
    cycle
        Indices in `forces` at which the last whole cycle starts and ends, the first also that of its first step in
        `shears`; None if no cycle is whole.
    """

    forces: Array
    rigid_displacement: Array
    shears: Array
    slip_distance: Array
    energy: Array
    cycle: tuple[int, int] | None

    def fields(self, pressure: Array) -> Mapping[str, Field]:
        """Return traction, area of stick, slip and energy, and the force from the start on, as fields by name."""
        counted = "so far" if self.cycle is None else "in the last whole cycle"
        slid = "rigid-body displacement of the second against the first body along x"
        return {
            **super().fields(pressure),
            "slip_distance": Field(OF_SURFACE, self.slip_distance, "m", f"distance slipped {counted}"),
            "friction_energy": Field(OF_SURFACE, self.energy, "J m-2", f"energy lost {counted} per area"),
            "tangential_force": Field(("step",), self.forces, "N", "tangential force at the start and after each step"),
            "rigid_displacement": Field(("step",), self.rigid_displacement, "m", slid),
        }  # fmt: skip


@dataclass(frozen=True)
class Creepage:
    """Creepage: relative rigid-body velocity of the second against the first body over the rolling speed.

    The slip of the first against the second body is the change of the elastic displacement per distance, less the
    creepage: a positive creepage makes a positive traction on the first body.

    Parameters
    ----------
    longitudinal, lateral
        Along x and along y.
    spin
        About z [1/m].
    """

    longitudinal: float
    lateral: float
    spin: float

    def on(self, grid: Grid) -> Array:
        """Return the creepage (component, x, y), spin included, in the cells of `grid`."""
        creepage = np.empty((2, *grid.cells))
        creepage[0] = self.longitudinal - self.spin * grid.y
        creepage[1] = self.lateral + self.spin * grid.x[:, None]
        return creepage


@dataclass(frozen=True)
class RollingErrors:
    """Errors by the size of the cells, estimated by coarser grids; infinite where there is none.

    Parameters
    ----------
    force
        Absolute error of the ratio of tangential force to load.
    creepage
        Absolute error of a longitudinal creepage that is found.
    power
        Absolute error of the frictional power on the grid [W].
    """

    force: float = inf
    creepage: float = inf
    power: float = inf


# Errors on one grid alone, which nothing estimates.
UNKNOWN = RollingErrors()


@dataclass(frozen=True, eq=False)
class RollingTraction(TangentialTraction):
    """Tangential traction of steady rolling on the first body, with its slip and its power.

    Parameters
    ----------
    slip
        Slip of the first against the second body per distance rolled (component, x, y).
    creepage
        Rigid slip of the second against the first body; found where the tangential force is given.
    power
        Frictional power per area (x, y) [W/m^2], of the slip in a step of one cell under the mean of the traction before
        and after it: the traction after it alone would leave out what the step dissipates.
    power_outside_contact
        Fraction of the power in cells just outside the contact, which have the mean of their traction and that of a
        neighbour: an error by the cells that one grid shows. `errors` has the one that
        coarser grids show; the bound of the power is their sum.
    errors
        Estimated errors of force, creepage and power.
    creepage_given
        Whether the creepage was given, and not the force.
    """

    slip: Array
    creepage: Creepage
    power: Array
    power_outside_contact: float
    errors: RollingErrors
    creepage_given: bool

    def fields(self, pressure: Array) -> Mapping[str, Field]:
        """Return traction, area of stick, slip and frictional power, as fields by name."""
        slip = "slip of the first body against the second over the distance rolled"
        return {
            **super().fields(pressure),
            "slip_x": Field(OF_SURFACE, self.slip[0], "1", f"{slip}, across"),
            "slip_y": Field(OF_SURFACE, self.slip[1], "1", f"{slip}, along"),
            "power_density": Field(OF_SURFACE, self.power, "W m-2", "frictional power per area"),
        }

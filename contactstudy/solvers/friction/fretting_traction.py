"""Tangential traction of a contact that frets, with the loop, the slip and the energy that belong to it."""

from collections.abc import Mapping
from dataclasses import dataclass

from contactstudy.domain.fields import Array
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
        """Return traction, area of stick, slip and energy, and the force after each step, as fields by name."""
        counted = "so far" if self.cycle is None else "in the last whole cycle"
        slid = "rigid-body displacement of the second against the first body along x"
        return {
            **super().fields(pressure),
            "slip_distance": Field(OF_SURFACE, self.slip_distance, "m", f"distance slipped {counted}"),
            "friction_energy": Field(OF_SURFACE, self.energy, "J m-2", f"energy lost {counted} per area"),
            "tangential_force": Field(("step",), self.forces, "N", "tangential force after each step"),
            "rigid_displacement": Field(("step",), self.rigid_displacement, "m", slid),
        }  # fmt: skip

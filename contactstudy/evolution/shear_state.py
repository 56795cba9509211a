"""Shear of a contact that frets as a state variable, and the wear by its slip."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.evolution.state_variables import Contribution, State, Step
from contactstudy.problem.problem import Field
from contactstudy.scene.load import ChangingLoad
from contactstudy.solvers.partial_slip import locked_shear, slip_step

# Largest size of a sum of arrays that counts as no shear.
NOTHING = 1e-300


@dataclass(frozen=True)
class ShearState:
    """Shear between bodies that stick in part, the distance slipped, and the depth worn by it.

    Each step is one of :func:`~contactstudy.solvers.partial_slip.slip_step`, from the shear before it and what a rising
    pressure locks in. The step loses ``mu (p0 + p1) / 2 |slip|`` per area, with the pressures at its start and its end,
    and wears ``k (p0 + p1) / 2 |slip|`` (Archard 1953), so that the worn volume is ``k / mu`` times the energy. What a
    step wears changes the gap of the next one: steps must be short, as in explicit wear.

    Attributes
    ----------
    coefficient
        Coefficient of friction mu.
    wear
        Wear coefficient k [1/Pa]; 0 wears nothing.
    response
        Displacement under shear.
    forces, displacements
        Tangential force [N/m] or rigid displacement [m] over time, along x; the other one is None.
    grid
        Grid of the contact.
    tolerance, max_applications
        Largest residual of a step, and its number of applications of the response at most.
    """

    coefficient: float
    wear: float
    response: ShearResponse
    forces: ChangingLoad | None
    displacements: ChangingLoad | None
    grid: Grid
    tolerance: float
    max_applications: int

    has_stages: ClassVar[bool] = False

    def start(self, shape: tuple[int, int]) -> State:
        """Return no shear, slip or wear on `shape` cells (x, y)."""
        names = ["shear_x", "shear_y", "stick", "slip_distance", "energy"]
        names += ["worn_depth"] * (self.wear > 0)
        return {name: np.zeros(shape) for name in names} | {"residual": np.zeros(1)}

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """Return the depth worn so far as a gap."""
        return Contribution(gap=state.get("worn_depth"))

    def update(self, state: State, before: Array, after: Array, step: Step) -> State:
        """Return shear, slip, energy and worn depth at the end of the step."""
        shear = np.stack([state["shear_x"], state["shear_y"]])
        slope, total, rigid = 0.0, None, None
        if self.forces is not None:
            # bodies are pressed before they are sheared
            first = self.forces.at(step.start) if before.any() else 0.0
            last = self.forces.at(step.end)
            rise = step.loads[1] - step.loads[0]
            if rise > 0 and step.duration > 0:
                slope = float(np.clip((last - first) / rise, -self.coefficient, self.coefficient))
            total = np.array([last * self.grid.period / self.grid.cell_area, 0.0])
        else:
            assert self.displacements is not None
            moved = self.displacements.at(step.end)
            moved -= self.displacements.at(step.start) if before.any() else 0.0
            rigid = np.array([moved, 0.0])
        found = slip_step(
            self.response,
            self.coefficient * after,
            locked_shear(shear, before, after, slope),
            self.tolerance,
            self.max_applications,
            total=total,
            rigid=rigid,
        )
        distance = np.where(found.stick, 0.0, np.hypot(*found.slip))
        work = (before + after) / 2 * distance
        state = dict(state) | {
            "shear_x": found.shear[0],
            "shear_y": found.shear[1],
            "stick": found.stick.astype(np.float64),
            "slip_distance": state["slip_distance"] + distance,
            "energy": state["energy"] + self.coefficient * work,
            "residual": np.array([found.residual]),
        }
        if self.wear:
            state["worn_depth"] = state["worn_depth"] + self.wear * work
        return state

    def fields(self, state: State) -> Mapping[str, Field]:
        """Return shear, stick, slip, energy and worn depth (x, y)."""
        plane = ("x", "y")
        fields = {
            "shear_x": Field(plane, state["shear_x"], "Pa", "shear across, on the first body"),
            "shear_y": Field(plane, state["shear_y"], "Pa", "shear along, on the first body"),
            "stick": Field(plane, state["stick"], "1", "1 where the bodies stick, 0 elsewhere"),
            "slip_distance": Field(plane, state["slip_distance"], "m", "distance slipped so far"),
            "friction_energy": Field(
                plane, state["energy"], "J m-2", "energy lost to friction so far per area"
            ),
        }
        if self.wear:
            fields["worn_depth"] = Field(plane, state["worn_depth"], "m", "worn depth")
        return fields

    def difference(self, state: State, other: State) -> float:
        """Return the L1 difference of the shear of two states, relative to the first."""
        size = float(np.abs(state["shear_x"]).sum())
        changed = float(np.abs(state["shear_x"] - other["shear_x"]).sum())
        return changed / size if size > NOTHING else 0.0

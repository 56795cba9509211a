"""What an accuracy case is: a contact on a grid, and the truth that its cells should have."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, nan
from typing import NamedTuple

import numpy as np

import contactstudy as cs
from contactstudy.accuracy.coarser import touching_fraction
from contactstudy.domain.grid import Array
from studies.reference.line_contact import SCENE

MODULUS = SCENE.contact_modulus
# At points (x, y) [m], in Pa.
Pressure = Callable[[Array, Array], Array]
EXACT, FREE = cs.ExactPeriodicity(), cs.ZeroPadding()
METRICS = ("l1", "peak_pressure", "contact_area", "mean_gap")


@dataclass(frozen=True, eq=False)
class Truth:
    """True ``pressure`` (x, y) [Pa] as cell means, its ``highest`` [Pa], and the fraction of the ``area`` in contact.

    ``highest`` is infinite at a sharp edge. ``gap`` is the mean gap [m], nan where it is not known.
    """

    pressure: Array
    highest: float
    area: float
    gap: float = nan


@dataclass(frozen=True, eq=False)
class AccuracyCase:
    """A ``scene`` on a ``grid`` with a ``padding``, and the function that finds its truth."""

    scene: cs.Scene
    grid: cs.Grid
    padding: cs.Padding | cs.Paddings
    find_truth: Callable[["AccuracyCase"], Truth]


@dataclass(frozen=True)
class Finer:
    """Reference solution of a case on a grid ``factor`` times finer along each axis, with the ``padding`` given."""

    factor: tuple[int, int]
    padding: cs.Padding | cs.Paddings

    def __call__(self, case: AccuracyCase) -> Truth:
        """Solve on the finer grid, and average over blocks of its cells."""
        (nx, ny), (kx, ky) = case.grid.cells, self.factor
        ky = ky if ny > 1 else 1
        grid = cs.Grid((kx * nx, ky * ny), case.grid.extent)
        solution = cs.solve(case.scene.problem(grid, self.padding), tolerance=1e-8)
        blocks = solution.pressure.reshape(nx, kx, ny, ky).mean(axis=(1, 3))
        return Truth(blocks, float(solution.pressure.max()), touching_fraction(solution), solution.mean_gap)


@dataclass(frozen=True)
class ClosedForm:
    """Closed form of the ``pressure``, its ``highest`` [Pa] and the fraction of the ``area`` in contact.

    Means over cells are by the midpoint rule at ``points`` per axis of a cell, scaled to the load.
    """

    pressure: Pressure
    highest: float
    area: float
    points: int = 64

    def __call__(self, case: AccuracyCase) -> Truth:
        """Return the truth on the cells of the case."""
        (nx, ny), grid = case.grid.cells, case.grid
        along = 1 if ny == 1 else max(self.points // 8, 4)
        across = self.points if ny == 1 else along
        fine = cs.Grid((nx * across, ny * along), grid.extent)
        values = np.broadcast_to(self.pressure(fine.x[:, None], fine.y), fine.cells)
        means = values.reshape(nx, across, ny, along).mean(axis=(1, 3))
        load = case.scene.largest_load * grid.length / grid.cell_area
        # a pole is lost between the points; the load is not
        return Truth(means * (load / means.sum()), self.highest, self.area)


class Judged(NamedTuple):
    """True relative error of a number, nan where it is not known, and its bound, or a reason where there is none."""

    metric: str
    error: float
    bound: float
    has_reason: bool


def judged(case: AccuracyCase) -> list[Judged]:
    """Return the true errors and the bounds of the numbers of a case."""
    solution = cs.solve(case.scene.problem(case.grid, case.padding))
    truth, estimate, numbers = case.find_truth(case), solution.error, solution.quantities
    bounds = {name: getattr(estimate, name).total for name in ("l1", "peak_pressure")}
    bounds |= {name: numbers[name].relative_bound for name in ("contact_area", "mean_gap")}
    errors = {
        "l1": float(np.abs(solution.pressure - truth.pressure).sum() / truth.pressure.sum()),
        "peak_pressure": inf if truth.highest == inf else float(abs(solution.pressure.max() / truth.highest - 1)),
        "contact_area": abs(touching_fraction(solution) / truth.area - 1),
        "mean_gap": abs(solution.mean_gap / truth.gap - 1),
    }
    return [Judged(metric, error, bounds[metric], bool(estimate.warnings)) for metric, error in errors.items()]


def scene(*shapes: cs.Shape, hardness: float = inf) -> cs.Scene:
    """Return the scene of the cylinder with further ``shapes``."""
    return cs.Scene(SCENE.load, SCENE.solids, (*SCENE.shapes, *shapes), hardness)

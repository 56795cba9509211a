"""What an accuracy case is: a contact on a grid, and the truth that its cells should have."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, nan

import numpy as np

import contactstudy as cs
from contactstudy.accuracy.coarser import touching_fraction
from contactstudy.domain.fields import Array
from studies.reference.line_contact import SCENE

MODULUS = SCENE.contact_modulus
# At points (x, y) [m], in Pa.
Pressure = Callable[[Array, Array], Array]
EXACT, FREE = cs.ExactPeriodicity(), cs.ZeroPadding()


@dataclass(frozen=True, eq=False)
class Truth:
    """True ``pressure`` (x, y) [Pa] as cell means, its ``highest`` [Pa], and the fraction of the ``area`` in contact.

    ``highest`` is infinite at a sharp edge. ``gap`` is the mean gap [m], nan where it is not known.
    """

    pressure: Array
    highest: float
    area: float
    gap: float = nan


@dataclass(frozen=True)
class Finer:
    """Reference solution of the same scene on a grid ``factor`` times finer along each axis, with a ``padding``."""

    factor: tuple[int, int]
    padding: cs.Padding | cs.Paddings
    tolerance: float = 1e-6

    def __call__(self, case: "AccuracyCase") -> Truth:
        """Solve on the finer grid, and average over blocks of its cells."""
        (nx, ny), (kx, ky) = case.grid.cells, self.factor
        ky = ky if ny > 1 else 1
        grid = cs.Grid((kx * nx, ky * ny), case.grid.extent)
        source = case.problem().source
        assert source is not None
        # heights given cell for cell are those of the case's own grid
        problem = source.problem(grid)
        if self.padding != case.padding:
            problem = case.scene.problem(grid, self.padding)
        solution = cs.solve(problem, tolerance=self.tolerance)
        blocks = solution.pressure.reshape(nx, kx, ny, ky).mean(axis=(1, 3))
        return Truth(blocks, float(solution.pressure.max()), touching_fraction(solution), solution.mean_gap)


@dataclass(frozen=True)
class ClosedForm:
    """Closed-form reference: cell means of the ``pressure`` at ``points`` per axis of a cell, ``highest`` and ``area``.

    Attributes are those of :class:`Truth`. The means are scaled to the load.
    """

    pressure: Pressure
    highest: float
    area: float
    points: int = 64

    def __call__(self, case: "AccuracyCase") -> Truth:
        """Return the truth on the cells of the case, with cell means by the midpoint rule."""
        (nx, ny), grid = case.grid.cells, case.grid
        along = 1 if ny == 1 else max(self.points // 8, 4)
        across = self.points if ny == 1 else along
        fine = cs.Grid((nx * across, ny * along), grid.extent)
        values = np.broadcast_to(self.pressure(fine.x[:, None], fine.y), fine.cells)
        means = values.reshape(nx, across, ny, along).mean(axis=(1, 3))
        load = case.scene.largest_load * grid.length / grid.cell_area
        # a pole is lost between the points; the load is not
        return Truth(means * (load / means.sum()), self.highest, self.area)


@dataclass(frozen=True, eq=False)
class AccuracyCase:
    """A ``scene`` on a ``grid`` with a ``padding``, of a ``kind`` of surface, and the function that finds its truth."""

    kind: str
    scene: cs.Scene
    grid: cs.Grid
    padding: cs.Padding | cs.Paddings
    find_truth: Callable[["AccuracyCase"], Truth]

    def problem(self) -> cs.Problem:
        """Return the problem of the scene on its grid."""
        return self.scene.problem(self.grid, self.padding)

    def truth(self) -> Truth:
        """Return the true answer on the cells of the case."""
        return self.find_truth(self)


@dataclass(frozen=True)
class Errors:
    """True relative errors of the pressure in L1, the peak pressure, the contact area and the mean gap."""

    l1: float
    peak_pressure: float
    contact_area: float
    mean_gap: float


def errors(solution: cs.Solution, truth: Truth) -> Errors:
    """Return the relative errors of ``solution`` against the ``truth``."""
    pressure = solution.pressure
    area = touching_fraction(solution)
    peak = inf if truth.highest == inf else abs(pressure.max() / truth.highest - 1)
    return Errors(
        float(np.abs(pressure - truth.pressure).sum() / truth.pressure.sum()),
        float(peak),
        abs(area / truth.area - 1),
        abs(solution.mean_gap / truth.gap - 1),
    )


def scene(*shapes: cs.Shape, hardness: float = inf) -> cs.Scene:
    """Return the scene of the cylinder with further ``shapes``."""
    return cs.Scene(SCENE.load, SCENE.solids, (*SCENE.shapes, *shapes), hardness)

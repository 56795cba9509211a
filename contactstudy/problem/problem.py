"""The bare contact problem: a gap, an operator, an admissible set. The waist between scene and solver."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Protocol, Self

import numpy as np

from contactstudy.domain.arrays import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Paddings
from contactstudy.domain.precision import Precision
from contactstudy.problem.compressive import AdmissiblePressures
from contactstudy.problem.derived import Derived
from contactstudy.problem.gap import Gap

# A gap is uncertain by so many roundings of the largest displacement: residuals stop falling at half of it.
ROUNDINGS = 2.0


class Operator(Protocol):
    """A symmetric linear map from pressure to displacement, both (width, length)."""

    @property
    def work(self) -> float:
        """Cells transformed in one application."""
        ...

    @property
    def own(self) -> float:
        """Displacement of a cell under its own unit pressure, above the mean of all cells.

        So that it does not depend on a rigid shift, which a balanced load cannot tell, and is above zero.
        """
        ...

    @property
    def blocks(self) -> tuple[int, int]:
        """How many cells across and along :meth:`coarsened` makes one of; (1, 1) if it cannot."""
        ...

    def __call__(self, pressure: Array) -> Array:
        """The displacement under ``pressure``."""
        ...

    def scaled(self, factor: float, precision: Precision) -> Self:
        """This operator times ``factor``, in ``precision``."""
        ...

    def coarsened(self) -> Self:
        """The operator on a grid of larger cells, each a block of these."""
        ...

    def approximate_inverse(self) -> tuple[Callable[[Array], Array], float]:
        """A map from displacement to pressure, good enough to precondition with, and its work."""
        ...


@dataclass(frozen=True)
class Scales:
    """What the solver divides by, so that no unit can change an answer: [m], [Pa], [m]."""

    length: float
    pressure: float
    gap: float


@dataclass(frozen=True, eq=False)
class BareProblem:
    """A problem without dimensions, in the precision of its gap: what a solver sees."""

    undeformed_gap: Array
    displacement: Operator
    pressures: AdmissiblePressures

    def uniform(self) -> Array:
        """The load spread evenly."""
        gap = self.undeformed_gap
        return np.full_like(gap, self.pressures.total / gap.size)

    def gap(self, pressure: Array, displacement: Array, into: Gap | None = None) -> Gap:
        """The gap under ``pressure`` and the ``displacement`` it makes, ``into`` the fields of another."""
        pressures = self.pressures
        free = pressures.free(pressure, into.free if into else None)
        whole = np.add(self.undeformed_gap, displacement, out=into.overlap if into else None)
        approach = pressures.approach(pressure, whole, free)
        whole -= approach
        held = np.multiply(whole, free, out=into.held if into else None)
        return Gap(free, held, np.subtract(held, whole, out=whole), approach)

    def rounding(self, displacement: Array) -> float:
        """What rounding leaves uncertain of a gap under ``displacement``: no residual means less."""
        largest = max(float(displacement.max()), -float(displacement.min()))
        return float(ROUNDINGS * np.finfo(displacement.dtype).eps * largest)

    def ends(self, residual: float, displacement: Array, tolerance: float) -> bool:
        """Whether there is no use in going on from ``residual``."""
        return not max(tolerance, self.rounding(displacement)) < residual < inf

    def coarsened(self) -> "BareProblem | None":
        """The same problem on blocks of cells, heights averaged; None where the grid does not halve."""
        across, along = self.displacement.blocks
        if across * along == 1:
            return None
        nx, ny = self.undeformed_gap.shape
        gap = self.undeformed_gap.reshape(nx // across, across, ny // along, along).mean(
            axis=(1, 3)
        )
        pressures = self.pressures.scaled(1.0, across * along)
        return BareProblem(gap, self.displacement.coarsened(), pressures)


@dataclass(frozen=True, eq=False)
class Problem:
    """Find p in ``pressures`` with ``gap = undeformed_gap + displacement(p) - approach >= 0``, ``p gap = 0``.

    ``undeformed_gap`` (width, length) [m]; ``displacement`` maps pressure [Pa] to displacement [m],
    both (width, length). ``open_edges`` are the rows, counted across, that contact should not reach,
    since the surface goes on beyond them. ``paddings`` (across, along) are those behind the operator,
    where it was made of any. ``outputs`` are found from the solution when it is labelled; ``attributes``
    describe where the problem came from. None of these is for the solver.
    """

    grid: Grid
    undeformed_gap: Array
    displacement: Operator
    pressures: AdmissiblePressures
    scales: Scales
    open_edges: tuple[int, ...] = ()
    paddings: Paddings | None = None
    outputs: tuple[Derived, ...] = ()
    attributes: Mapping[str, str | float] = field(default_factory=dict)

    @property
    def datum(self) -> float:
        """The undeformed gap at the highest point [m], from which a bare problem counts heights.

        Where these are large, so is their rounding: it should not be there where the bodies touch.
        """
        return float(self.undeformed_gap.min())

    def bare(self, precision: Precision = Precision.DOUBLE) -> BareProblem:
        """This problem in its own scales, its highest point at zero."""
        heights = (self.undeformed_gap - self.datum) / self.scales.gap
        return BareProblem(
            heights.astype(precision.real, copy=False),
            self.displacement.scaled(self.scales.pressure / self.scales.gap, precision),
            self.pressures.scaled(1 / self.scales.pressure),
        )

"""The contact problem in SI units: a gap, an operator, a constraint, a resultant, and what follows from its pressure."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from numpy.typing import NDArray

from contactstudy.domain.device import Device, Precision, device
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Paddings
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.constraint import Constraint, Resultant
from contactstudy.problem.operator import Operator


@dataclass(frozen=True, eq=False)
class Field:
    """Values with their dimensions, unit, long name and other CF attributes.

    A field named like its only dimension is a coordinate.
    """

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    units: str
    long_name: str
    attributes: Mapping[str, str] = field(default_factory=dict)


class Derived(Protocol):
    """What follows from the pressure on one grid, found when it is called for."""

    def fields(self, pressure: Array) -> Mapping[str, Field]:
        """Fields by name, under ``pressure`` (x, y) [Pa]."""
        ...


@runtime_checkable
class Sheared(Protocol):
    """What follows from shear on the surface as well."""

    def under(self, shear: Array) -> Derived:
        """The same under ``shear`` (component, x, y) [Pa] on the first body."""
        ...


@dataclass(frozen=True)
class Scales:
    """What the solver divides by, so that units do not change the answer: [m], [Pa], [m]."""

    length: float
    pressure: float
    gap: float


class Source(Protocol):
    """What a problem was made of, so that it can be made again on another grid of the same extent."""

    @property
    def finest(self) -> tuple[float, float]:
        """The shortest lengths (across, along) over which the heights change [m]; infinite if unknown."""
        ...

    @property
    def names_scales(self) -> bool:
        """Whether ``finest`` is known of every shape."""
        ...

    @property
    def ends_along(self) -> bool:
        """Whether a body ends along the length, so that contact may reach the ends of the grid."""
        ...

    def gap(self, grid: Grid) -> Array:
        """Undeformed gap [m], sampled anew on ``grid``; broadcasts to its cells."""
        ...

    def problem(self, grid: Grid) -> "Problem":
        """The same contact on ``grid``, with the same paddings."""
        ...


class FrictionLaw(Protocol):
    """What adds shear to the pressure of a problem."""

    def solved(self, problem: "Problem", options: Any, start: Array | None, on: Device) -> Any:
        """Return the Solution of a frictionless `problem` with its shear, by SolveOptions, from a pressure [Pa]."""
        ...


@dataclass(frozen=True, eq=False)
class Problem:
    """Find p with ``gap = undeformed_gap + operator(p) - approach >= 0`` and ``p gap = 0``.

    ``undeformed_gap`` (x, y) [m]; ``operator`` maps pressure [Pa] to displacement [m], both (x, y).
    ``constraint`` limits the pressure of each cell; ``resultant`` is what all carry together. ``scales`` are
    what the solver divides by. The rest is not for the solver: ``open_edges`` are the rows, counted
    across, that contact should not reach, because the surface goes on beyond them, and ``open_ends`` those
    counted along; ``source`` makes the problem again on another grid; ``paddings`` (across, along)
    are those of the operator, where it has any; ``outputs`` are found from the solution when
    it is labelled; ``description`` is what the problem was made from, such as a scene on a grid. ``friction``
    adds shear to a solution.
    """

    grid: Grid
    undeformed_gap: Array
    operator: Operator
    constraint: Constraint
    resultant: Resultant
    scales: Scales
    open_edges: tuple[int, ...] = ()
    open_ends: tuple[int, ...] = ()
    source: Source | None = None
    paddings: Paddings | None = None
    outputs: tuple[Derived, ...] = ()
    description: object = None
    friction: FrictionLaw | None = None

    @property
    def datum(self) -> float:
        """The undeformed gap at the highest point [m]; a bare problem counts heights from it.

        Large heights have large rounding errors, which should be far from where the bodies touch.
        """
        return float(self.undeformed_gap.min())

    def bare(self, precision: Precision = Precision.DOUBLE) -> BareProblem:
        """This problem in its own scales, its highest point at zero, on the device in use."""
        heights = (self.undeformed_gap - self.datum) / self.scales.gap
        return BareProblem(
            device().put(heights.astype(precision.real, copy=False)),
            self.operator.scaled(self.scales.pressure / self.scales.gap, precision),
            self.constraint.scaled(1 / self.scales.pressure),
            self.resultant.scaled(1 / self.scales.pressure),
        )

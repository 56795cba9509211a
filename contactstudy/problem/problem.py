"""The contact problem in SI units: a gap, an operator, a constraint, a control, and what follows from its pressure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from numpy.typing import NDArray

from contactstudy.domain.device import Device, Precision, arrays, device
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.problem.bare_problem import BareProblem, Operator
from contactstudy.problem.constraint import Constraint, Control


@dataclass(frozen=True, eq=False)
class Field:
    """Values with their dimensions, unit, long name and other CF attributes.

    A field named like its only dimension is a coordinate.
    """

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    units: str
    long_name: str
    attributes: Mapping[str, Any] = field(default_factory=dict)


class Derived(Protocol):
    """Quantities that follow from the pressure on one grid, computed on request."""

    def fields(self, pressure: Array) -> Mapping[str, Field]:
        """Return the fields by name, under `pressure` (x, y) [Pa]."""


@runtime_checkable
class DependsOnShear(Protocol):
    """Derived quantities that also depend on tangential traction on the surface."""

    def with_shear(self, shear: Array, bulk: tuple[float, float] = (0.0, 0.0)) -> Derived:
        """Return the quantities under `shear` (component, x, y) [Pa] on the first body, and a `bulk` stress of each."""


# From the depths (z,) [m] to the residual stress (6, z, x, y) [Pa] of one body there.
ResidualStress = Callable[[Array], Array]


@runtime_checkable
class DependsOnStrain(Protocol):
    """Derived quantities that also depend on plastic strain below the surface."""

    def with_residual_stress(self, residual: Callable[[int, float], ResidualStress | None]) -> Derived:
        """Return the quantities with the `residual` stress added, by the body's index and the deepest depth [m].

        There is none in a body that does not yield.
        """


@dataclass(frozen=True)
class Scales:
    """Units that make a problem dimensionless, so that the choice of units does not change the answer.

    They are a `length` [m] along the surface, a `pressure` [Pa] and a `gap` [m]. The solver divides pressures and gaps
    by them; the length places the datum of displacements.
    """

    length: float
    pressure: float
    gap: float


class Source(Protocol):
    """Origin of a problem, which can discretise it again on another grid of the same extent."""

    @property
    def shortest_wavelengths(self) -> tuple[float, float]:
        """Shortest wavelengths (across, along) of the heights [m]; infinite if unknown."""

    @property
    def has_length_scales(self) -> bool:
        """True if `shortest_wavelengths` is known for every shape."""

    @property
    def ends_along(self) -> bool:
        """True if a body ends along the length, so that contact may reach the ends of the grid."""

    def gap(self, grid: Grid) -> Array:
        """Return the undeformed gap [m], sampled on `grid`; it broadcasts to the cells."""

    def problem(self, grid: Grid) -> "Problem":
        """Return the problem of this contact on `grid`, with the same paddings."""


class FrictionSolver(Protocol):
    """Solver of a contact with friction: what it adds to the pressure of a frictionless one is the tangential
    traction."""

    def solve(self, problem: "Problem", options: Any, start: Array | None, device: Device) -> Any:
        """Return the Solution of a frictionless `problem` with its tangential traction.

        `options` are SolveOptions, `start` is a pressure (x, y) [Pa] to begin with.
        """


class AdhesionSolver(Protocol):
    """Solver of a contact with adhesion, which adds an attraction to its pressure."""

    def solve(self, problem: "Problem", options: Any, start: Array | None, device: Device) -> Any:
        """Return the Solution of a `problem` with its attraction.

        `options` are SolveOptions, `start` is a pressure (x, y) [Pa] to begin with.
        """

    def continued(self, attraction: Array) -> "AdhesionSolver":
        """Return the solver for a contact that comes from a state with this `attraction` (x, y) [Pa]."""


@dataclass(frozen=True, eq=False)
class Problem:
    """Contact problem in SI units: find the pressure p within a constraint, under a given load or approach.

    It has ``gap = undeformed_gap + operator(p) - approach``, with ``gap >= 0`` where p = 0, ``gap = 0`` between its
    limits, and ``gap <= 0`` where it is at an upper one. Fields are (x, y).

    Parameters
    ----------
    grid
        Cells and extent.
    undeformed_gap
        Gap between the unloaded bodies (x, y) [m].
    operator
        Map from pressure [Pa] to displacement [m].
    constraint
        Limits of the pressure of each cell.
    control
        The load over the area of a cell, which is the sum of the pressure, or the approach.
    scales
        Units that the solver works in.
    open_edges, open_ends
        Indices along x, and along y, of boundary cells that contact should not reach, because the surface goes on beyond
        them.
    source
        Discretises the problem on another grid.
    paddings
        Paddings (across, along) of the operator, where it has any.
    outputs
        Quantities that are found from the solution when it is labelled.
    description
        What the problem was made from, such as a scene on a grid.
    friction
        Solver that adds a tangential traction to a solution.
    adhesion
        Solver that adds an attraction to a solution.
    covered_fractions
        Weights (y,) of the cells along y: the length of both bodies that each represents, over that of a cell; None
        where the bodies are as long as the grid.
    """

    grid: Grid
    undeformed_gap: Array
    operator: Operator
    constraint: Constraint
    control: Control
    scales: Scales
    open_edges: tuple[int, ...] = ()
    open_ends: tuple[int, ...] = ()
    source: Source | None = None
    paddings: Paddings | None = None
    outputs: tuple[Derived, ...] = ()
    description: object = None
    friction: FrictionSolver | None = None
    adhesion: AdhesionSolver | None = None
    covered_fractions: Array | None = None

    @property
    def reference_height(self) -> float:
        """Height [m] subtracted in a bare problem, the prescribed approach or else the smallest undeformed gap.

        Large heights have large rounding errors, which should be far from where the bodies touch.
        """
        approach = self.control.approach
        return float(self.undeformed_gap.min()) if approach is None else approach

    def is_cut_off(self, pressure: Array) -> bool:
        """Return whether a `pressure` (x, y) acts in boundary cells that contact should not reach."""
        across = any(pressure[ix].any() for ix in self.open_edges)
        return across or any(pressure[:, iy].any() for iy in self.open_ends)

    def bare(self, precision: Precision = Precision.DOUBLE) -> BareProblem:
        """Return this problem in its own scales, heights counted from its reference height, on the device in use."""
        heights = device().to_device(self.undeformed_gap) - self.reference_height
        heights /= self.scales.gap
        return BareProblem(
            arrays().astype(heights, precision.on_device, copy=False),
            self.operator.scaled(self.scales.pressure / self.scales.gap, precision),
            self.constraint.scaled(1 / self.scales.pressure),
            self.control.scaled(1 / self.scales.pressure),
            aspect_ratio=self.grid.cell_size[1] / self.grid.cell_size[0] if self.grid.cells[1] > 1 else 1.0,
        )

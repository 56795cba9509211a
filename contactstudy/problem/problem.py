"""The contact problem in SI units, the dimensionless one that a solver sees, and the memory that its solve needs.

A :class:`Problem` is arrays, one operator, one constraint and one control; no effect is known here. Its :meth:`bare
<Problem.bare>` form has no units: a :class:`BareProblem`. Protocols say what a solver asks of an operator and of its
preconditioner, and what a problem carries along for others: its :class:`Source`, its outputs, and solvers around that
of the contact. Fields are (x, y), across and along.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, prod
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import DTypeLike, NDArray

from contactstudy.domain.device import ONE_THREAD, Cpu, Device, Precision, arrays, device
from contactstudy.domain.grid import Array, Grid, Paddings, inner, max_abs, total
from contactstudy.domain.validation import InvalidInput
from contactstudy.problem.constraint import Constraint, Control, Gap, largest_of
from contactstudy.problem.field_operations import ArrayOperations, operations_for


class Extension(Protocol):
    """Linear map from the displacement (x, y) of an active set, zero elsewhere, to that of all cells."""

    @property
    def active(self) -> Array:
        """The active set (x, y): 1 in its cells, 0 elsewhere."""

    def __call__(self, displacement: Array) -> Array:
        """Return the `displacement` extended to all cells, in an array that may go on beyond them along each axis."""

    def pressure(self, extended: Array) -> Array:
        """Return the pressure (x, y) on the active set that approximately makes the `extended` displacement.

        The given array may be overwritten.
        """


class ApproximateInverse(Protocol):
    """Self-adjoint preconditioner: from the displacement of an active set to an approximate pressure on it.

    For a set that is 1 in its cells and 0 elsewhere it is applied in two steps: ``extension =
    inverse.extension(active)``, then ``extension.pressure(extension(displacement))``.
    """

    @property
    def real(self) -> DTypeLike:
        """Type of the numbers in all fields that it takes and returns."""

    @property
    def cells_transformed(self) -> float:
        """Number of cells transformed so far."""

    def extension(self, active: Array) -> Extension:
        """Return the extension from the cells of an `active` set (x, y), which is 1 there and 0 elsewhere."""


class Operator(Protocol):
    """Self-adjoint linear map from pressure to displacement (x, y), positive definite for pressures of zero sum."""

    @property
    def transform_size(self) -> float:
        """Number of cells of the padded grid, transformed in one application."""

    @property
    def self_compliance(self) -> float:
        """Displacement of a cell under a unit pressure on it alone, less the mean displacement of all cells; above zero.

        A constant added to the operator, which has no effect under pressures of zero sum, does not change it.
        """

    @property
    def blocks(self) -> tuple[int, int]:
        """Number of cells (across, along) of which :meth:`coarsened` makes one; (1, 1) if it cannot."""

    def __call__(self, pressure: Array) -> Array:
        """Return the displacement under `pressure`."""

    def scaled(self, factor: float, precision: Precision) -> Self:
        """Return this operator times `factor`, in `precision`."""

    def coarsened(self) -> Self:
        """Return the operator on a grid of larger cells, each a block of these."""

    def approximate_inverse(self, precision: Precision | None = None) -> ApproximateInverse:
        """Return a preconditioner, in this `precision` if it can, else in the operator's own."""


# Rounding error of a gap, in units of machine epsilon times the largest displacement; residuals stop falling at half of
# it.
GAP_ROUNDINGS = 2.0


# Of the start on a Winkler foundation: the compliance of the first foundation over that of a cell, and the ratio of the
# sides of a cell above which the start is uniform. With compliances from 1 to 20, solves of 15 contacts take 0.9 to 1.4
# times as many convolutions. With a ratio of 3 a roller takes two convolutions more.
COMPLIANCE_RATIO, ASPECT_RATIO = 4.0, 30.0


@dataclass(frozen=True, eq=False)
class BareProblem:
    """Dimensionless contact problem: find the pressure p within a constraint, under a given load or approach.

    It has ``gap = undeformed_gap + operator(p) - approach``, with ``gap >= 0`` where p = 0, ``gap = 0`` between its
    limits, and ``gap <= 0`` where it is at an upper one. This is what a :class:`~contactstudy.Solver` sees.

    Parameters
    ----------
    undeformed_gap
        Heights (x, y) in units of the gap scale; their precision is that of the iteration.
    operator
        Map from pressure to displacement, both (x, y) in units of their scales.
    constraint
        Limits of the pressure of each cell.
    control
        The load over the area of a cell, which is the sum of the pressure, or the approach.
    aspect_ratio
        Length of a cell over its width.
    chosen_operations
        Operations on fields; None chooses them by size and device.
    report
        Called with each residual and its pressure (x, y), a numpy array, on this grid, not on coarser ones; None for
        nothing.
    """

    undeformed_gap: Array
    operator: Operator
    constraint: Constraint
    control: Control
    aspect_ratio: float = field(default=1.0, kw_only=True)
    chosen_operations: ArrayOperations | None = field(default=None, kw_only=True, repr=False)
    report: Callable[[float, Array], object] | None = field(default=None, kw_only=True, repr=False)

    @cached_property
    def operations(self) -> ArrayOperations:
        """Operations on the fields of the problem, which coarser grids share."""
        return self.chosen_operations or operations_for(self.constraint, self.undeformed_gap.shape)

    def uniform(self) -> Array:
        """Return the uniform pressure (x, y) with the prescribed load, or zero under a prescribed approach."""
        gap = self.undeformed_gap
        return arrays().full_like(gap, self.control.uniform(prod(gap.shape)))

    def winkler_start(self) -> Array:
        """Return the pressure (x, y) of a Winkler foundation as compliant as the operator, to start a solve with.

        A first foundation is `COMPLIANCE_RATIO` times as compliant as a cell by itself. The displacement of the
        operator under the deviations of its pressure from the mean, over these deviations, is the compliance of the
        second foundation, whose pressure is returned. The pressure is uniform where no compliance above 0 follows, and
        on elongated cells, where waves along the shorter side are much stiffer than others.
        """
        if not 1 / ASPECT_RATIO < self.aspect_ratio < ASPECT_RATIO:
            return self.uniform()
        compliance = COMPLIANCE_RATIO * self.operator.self_compliance
        pressure = self.project(-self.undeformed_gap / compliance)
        active = self.constraint.active(pressure)
        cells = total(active)
        deviation = (pressure - inner(active, pressure) / cells) * active if cells else active
        variance = inner(deviation, pressure)
        compliance = inner(deviation, self.operator(pressure)) / variance if variance > 0 else 0.0
        if not 0 < compliance < inf:
            return self.uniform()
        return self.project(-self.undeformed_gap / compliance)

    def clip_and_scale(self, trial: Array) -> Array:
        """Cut a `trial` pressure off at the limits, and scale it to the load if one is prescribed, in place."""
        return self.constraint.scale_to_load(trial, self.control.total)

    def project(self, trial: Array) -> Array:
        """Replace a `trial` pressure by the nearest one in L2 within the constraint and with the load, in place."""
        return self.constraint.project(trial, self.control.total)

    def residual(self, pressure: Array, gap: Gap) -> float:
        """Return the dimensionless residual: the largest of the gap's violation and the error of the load.

        `gap` is the gap under `pressure`. See :class:`~contactstudy.SolveOptions`.
        """
        residual = largest_of(gap.violation, self.control.error(gap.load))
        if self.report is not None:
            self.report(residual, device().to_numpy(pressure))
        return residual

    def gap(self, pressure: Array, displacement: Array, into: Gap | None = None) -> Gap:
        """Return the gap under a `pressure` that makes this `displacement`, both (x, y).

        `into` is a gap whose heights may be overwritten; None makes a new array.
        """
        height = arrays().empty_like(pressure) if into is None else into.height
        fields = self.undeformed_gap, displacement, pressure, height
        # heights are counted from an approach that is given
        approach = None if self.control.approach is None else 0.0
        return self.operations.gap(*fields, approach)

    def should_stop(self, residual: float, displacement: Array, tolerance: float, largest: float | None = None) -> bool:
        """Return whether the `residual` is below the `tolerance`, at the rounding of a gap, or not finite.

        The rounding of a gap is `GAP_ROUNDINGS` machine epsilons of the largest absolute value of the `displacement`,
        which is found unless it is given as `largest`.
        """
        largest = max_abs(displacement) if largest is None else largest
        rounding = float(GAP_ROUNDINGS * arrays().finfo(displacement.dtype).eps * largest)
        return not max(tolerance, rounding) < residual < inf

    def coarsened(self) -> "BareProblem | None":
        """Return the problem on blocks of cells with heights averaged, or None where the grid cannot be halved."""
        across, along = self.operator.blocks
        if across * along == 1:
            return None
        gap = self.undeformed_gap
        if across == 2:
            gap = (gap[::2, :] + gap[1::2, :]) / 2
        if along == 2:
            gap = (gap[:, ::2] + gap[:, 1::2]) / 2
        control = self.control.scaled(1.0, across * along)
        operator = self.operator.coarsened()
        return BareProblem(
            gap,
            operator,
            self.constraint,
            control,
            aspect_ratio=self.aspect_ratio * along / across,
            chosen_operations=self.operations,
        )


@dataclass(frozen=True, eq=False)
class Field:
    """Values with the names of their dimensions, their unit, long name and other attributes of the CF conventions.

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
        """Return the quantities under the pressure and a `shear` (component, x, y) [Pa] on the first body.

        The second body has the opposite shear. `bulk` is a uniform stress [Pa] along x in the first and in the second.
        """


# From the depths (z,) [m] to the residual stress xx, yy, zz, yz, xz, xy (6, z, x, y) [Pa] of one body there.
ResidualStress = Callable[[Array], Array]


@runtime_checkable
class DependsOnStrain(Protocol):
    """Derived quantities that also depend on plastic strain below the surface."""

    def with_residual_stress(self, residual: Callable[[int, float], ResidualStress | None]) -> Derived:
        """Return the quantities with residual stress added.

        `residual` maps the index of a body, 0 or 1, and the deepest depth [m] to its residual stress; None for a body
        that does not yield.
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


class OuterSolver(Protocol):
    """Solver around that of the contact, which adds a tangential traction or an attraction to its pressure."""

    def solve(self, problem: "Problem", options: Any, start: Array | None, device: Device) -> Any:
        """Return the Solution of a `problem` with what this solver adds.

        `options` are SolveOptions, `start` is a pressure (x, y) [Pa] to begin with.
        """


class AdhesionSolver(OuterSolver, Protocol):
    """Solver of a contact with adhesion, which adds an attraction to its pressure."""

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
        Indices along x, and along y, of boundary cells that contact should not reach, because the surface goes on
        beyond them.
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
        where the bodies are as long as the grid. They weigh the load per length and means, and are not in the solve.
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
    friction: OuterSolver | None = None
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


# Number of arrays of the grid's size that a solve holds at once: within 0.7 to 1.5 of what was measured.
SOLVE_FIELDS = 14
# Number of arrays of the padded grid's size that a solve holds at once: the spectrum of its operator and the waves of a
# field. On a GPU the work arrays of its transforms are two more.
TRANSFORM_PAIR, PAIR_AND_WORK = 2, 4
# Bytes that any machine has free: asking the system takes as long as a solve of some hundred cells.
FREE_ON_ANY_MACHINE = 2**24
# The largest block [bytes] whose release raises the memory that glibc keeps: 32 MiB less what glibc adds to a block.
LARGEST_KEPT_BLOCK = 2**25 - 2**13


def keep_freed_memory() -> None:
    """Let the C library keep up to 64 MiB of freed memory of this process for the next arrays.

    glibc keeps twice the size of the largest mapped block that was freed, of at most 32 MiB. Before there is one, a
    solve gets new pages for each temporary array, which takes up to a third of its time. Other C libraries do not adapt
    in this way.
    """
    block = np.empty(LARGEST_KEPT_BLOCK, dtype=np.uint8)
    del block


keep_freed_memory()


def solve_bytes(grid: Grid, padded: float, device: Device = ONE_THREAD, precision: Precision = Precision.DOUBLE) -> int:
    """Return the largest memory that a solve on `grid` with that number of `padded` cells holds at once [bytes]."""
    work = TRANSFORM_PAIR if isinstance(device, Cpu) else PAIR_AND_WORK
    return round(precision.bytes * (SOLVE_FIELDS * prod(grid.cells) + work * padded))


def refuse_too_large(
    grid: Grid, padded: float, device: Device = ONE_THREAD, precision: Precision = Precision.DOUBLE
) -> None:
    """Refuse a solve on `grid` with that number of `padded` cells that the `device` cannot hold.

    Raises
    ------
    InvalidInput
        If the memory left is too small.
    """
    needed = solve_bytes(grid, padded, device, precision)
    if needed <= FREE_ON_ANY_MACHINE and isinstance(device, Cpu):
        return
    available = device.available_bytes
    if needed > available:
        where = "this machine" if isinstance(device, Cpu) else repr(device)
        raise InvalidInput(
            f"Grid.cells is {grid.cells!r}: a solve needs {needed / 1e9:.3g} GB and {where} has "
            f"{available / 1e9:.3g} GB left, give fewer cells."
        )

"""The dimensionless contact problem that a solver sees, with its linear map from pressure to displacement."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, prod
from typing import Protocol, Self

from numpy.typing import DTypeLike

from contactstudy.domain.device import Precision, arrays
from contactstudy.domain.fields import Array, inner, max_abs, total
from contactstudy.problem.constraint import Constraint, Control, Gap, largest_of
from contactstudy.problem.field_operations import ArrayOperations, operations_for


class Extension(Protocol):
    """Linear map from the displacement (x, y) of an active set, zero elsewhere, to that of all cells."""

    @property
    def active(self) -> Array:
        """The active set (x, y): 1 in its cells, 0 elsewhere."""

    def __call__(self, displacement: Array) -> Array:
        """Return the `displacement` extended to all cells, and it may be to more beyond them along each axis."""

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


@dataclass(frozen=True)
class WinklerConstants:
    """Constants of the start on a Winkler foundation, judged by the convolutions of 15 contacts.

    Attributes
    ----------
    compliance_ratio
        Compliance of the first foundation over that of a cell. From 1 to 20 the convolutions change by 0.9 to 1.4 times.
    aspect_ratio
        Ratio of the sides of a cell above which the start is uniform. With 3 a roller takes 2 convolutions more.
    """

    compliance_ratio: float = 4.0
    aspect_ratio: float = 30.0


CONSTANTS = WinklerConstants()


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
        Called with each residual and its pressure (x, y) on this grid, not on coarser ones; None for nothing.
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
        """Return the pressure (x, y) of a Winkler foundation as compliant as the operator.

        A first foundation is more compliant than a cell by itself. The operator's compliance is that of the
        deviations from the mean under its pressure, and gives the foundation returned. The pressure is uniform where no
        compliance follows, and on elongated cells, where waves along the shorter side are much stiffer than others.
        """
        if not 1 / CONSTANTS.aspect_ratio < self.aspect_ratio < CONSTANTS.aspect_ratio:
            return self.uniform()
        compliance = CONSTANTS.compliance_ratio * self.operator.self_compliance
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
        return self.control.clip_and_scale(trial, self.constraint)

    def project(self, trial: Array) -> Array:
        """Project a `trial` pressure in L2 onto the admissible ones, in place."""
        return self.control.project(trial, self.constraint)

    def residual(self, pressure: Array, gap: Gap) -> float:
        """Return the dimensionless residual: the largest of the gap's violation and the error of the load.

        `gap` is the gap under `pressure`. See :class:`~contactstudy.SolveOptions`.
        """
        residual = largest_of(gap.violation, self.control.error(gap.load))
        if self.report is not None:
            self.report(residual, pressure)
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
        """Return whether the residual is below the `tolerance`, at the rounding of a gap, or not finite.

        That rounding follows from the largest absolute value of the `displacement`, which is found unless it is given as
        `largest`.
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

"""The dimensionless contact problem that a solver sees, and what the pressures of all cells carry together."""

from dataclasses import dataclass
from math import inf, prod
from typing import Protocol, Self

from contactstudy.domain.device import arrays, fused
from contactstudy.domain.fields import Array, compiled, in_blocks, inner, total
from contactstudy.problem.constraint import Constraint, Gap, largest
from contactstudy.problem.operator import Operator


class Resultant(Protocol):
    """What closes the problem beside the conditions in each cell."""

    def scaled(self, pressure: float, cells: int = 1) -> Self:
        """The same in another unit of pressure (times ``pressure``), on blocks of so many cells."""
        ...

    def is_met_by(self, constraint: Constraint, cells: int) -> bool:
        """Whether so many cells under ``constraint`` can meet it."""
        ...

    def uniform(self, cells: int) -> float:
        """The pressure that meets it if it is the same in so many cells."""
        ...

    def admit(self, trial: Array, constraint: Constraint) -> Array:
        """``trial`` cut off at the limits of ``constraint`` and made to meet this, in place."""
        ...

    def nearest(self, trial: Array, constraint: Constraint) -> Array:
        """The admissible pressure nearest to ``trial``, in place: a step against the gap, made so, is downhill."""
        ...

    def levelled(self, trial: Array, cells: Array, constraint: Constraint) -> Array:
        """``trial`` cut off at the limits and made to meet this by a shift of ``cells``, in place."""
        ...

    def error(self, borne: float) -> float:
        """How far a pressure whose sum is ``borne`` is from meeting it, dimensionless."""
        ...


@dataclass(frozen=True)
class PrescribedLoad:
    """``sum(p) = total``: the load over the area of a cell, in the unit of p."""

    total: float

    def scaled(self, pressure: float, cells: int = 1) -> "PrescribedLoad":
        """In another unit, on larger cells."""
        return PrescribedLoad(float(self.total * pressure / cells))

    def is_met_by(self, constraint: Constraint, cells: int) -> bool:
        """Whether the cells can carry the load."""
        return constraint.capacity(cells) >= self.total

    def uniform(self, cells: int) -> float:
        """The load spread evenly."""
        return self.total / cells

    def admit(self, trial: Array, constraint: Constraint) -> Array:
        """Scaled to the load."""
        return constraint.carrying(trial, self.total)

    def nearest(self, trial: Array, constraint: Constraint) -> Array:
        """Shifted to the load."""
        return constraint.nearest(trial, self.total)

    def levelled(self, trial: Array, cells: Array, constraint: Constraint) -> Array:
        """Shifted to the load."""
        return constraint.levelled(trial, cells, self.total)

    def error(self, borne: float) -> float:
        """``|borne / total - 1|``."""
        return abs(borne / self.total - 1)


# A gap is uncertain by so many roundings of the largest displacement: residuals stop falling at half of it.
ROUNDINGS = 2.0


@dataclass(frozen=True, eq=False)
class BareProblem:
    """Find p within ``constraint`` that meets ``resultant``, with ``p gap = 0`` and ``gap >= 0``.

    Without dimensions, in the precision of ``undeformed_gap`` (x, y): what a solver sees. Cells at an upper
    limit of the constraint have ``gap <= 0``.
    """

    undeformed_gap: Array
    operator: Operator
    constraint: Constraint
    resultant: Resultant

    def uniform(self) -> Array:
        """The load spread evenly."""
        gap = self.undeformed_gap
        return arrays().full_like(gap, self.resultant.uniform(prod(gap.shape)))

    def admit(self, trial: Array) -> Array:
        """``trial`` cut off at the limits and made to carry the load, in place."""
        return self.resultant.admit(trial, self.constraint)

    def nearest(self, trial: Array) -> Array:
        """The admissible pressure nearest to ``trial``, in place."""
        return self.resultant.nearest(trial, self.constraint)

    def levelled(self, trial: Array, cells: Array) -> Array:
        """``trial`` cut off at the limits and made to carry the load by a shift of ``cells``, in place."""
        return self.resultant.levelled(trial, cells, self.constraint)

    def residual(self, pressure: Array, gap: Gap) -> float:
        """The measure of :func:`~contactstudy.solve`: the largest of complementarity, penetration and load.

        ``gap`` is that under ``pressure``.
        """
        if gap.residual is not None:
            return gap.residual
        borne = total(pressure)
        left = self.constraint.residual(pressure, gap, borne)
        return largest(left, self.resultant.error(borne))

    def gap(self, pressure: Array, displacement: Array, into: Gap | None = None) -> Gap:
        """The gap under ``pressure`` and the ``displacement`` it makes, ``into`` the field of another."""
        xp, kernels, most = arrays(), fused(), self.constraint.capacity(1)
        height = xp.empty_like(pressure) if into is None else into.height
        where = self.constraint.approach
        if kernels is not None:
            fields = self.undeformed_gap, displacement, pressure
            heights, cells = compiled(kernels.level, *fields, most, results=2).sum(axis=1).tolist()
            approach = heights / cells if cells else where(pressure, fields[0] + displacement)
            found = compiled(kernels.measured, *fields, approach, most, height, results=5)
            borne, moment, free = found[:3].sum(axis=1).tolist()
            complementarity = moment / free if free > 0 else 0.0
            left = largest(complementarity, found[3].max(), self.resultant.error(borne))
            return Gap(height, approach, left, float(found[4].max()))

        def add(rows: slice) -> tuple[float, float]:
            free = self.constraint.free(pressure[rows, :])
            both = self.undeformed_gap[rows, :] + displacement[rows, :]
            return inner(both, free), float(xp.sum(free))

        heights, cells = map(sum, zip(*in_blocks(add, pressure.shape), strict=True))
        approach = heights / cells if cells else where(pressure, self.undeformed_gap + displacement)

        def count(rows: slice) -> None:
            height[rows, :] = self.undeformed_gap[rows, :] + displacement[rows, :] - approach

        in_blocks(count, height.shape)
        return Gap(height, approach)

    def rounding(self, displacement: Array, farthest: float | None = None) -> float:
        """What rounding leaves uncertain of a gap under ``displacement``: no residual means less.

        ``farthest`` is the size of the largest, where it is known.
        """
        xp = arrays()

        def highest(rows: slice) -> float:
            some = displacement[rows, :]
            return max(float(xp.max(some)), -float(xp.min(some)))

        if farthest is None:
            farthest = largest(*in_blocks(highest, displacement.shape))
        return float(ROUNDINGS * xp.finfo(displacement.dtype).eps * farthest)

    def ends(
        self,
        residual: float,
        displacement: Array,
        tolerance: float,
        farthest: float | None = None,
    ) -> bool:
        """Whether no iteration can improve on ``residual``, or none needs to."""
        uncertain = self.rounding(displacement, farthest)
        return not max(tolerance, uncertain) < residual < inf

    def coarsened(self) -> "BareProblem | None":
        """The same problem on blocks of cells, heights averaged; None where the grid does not halve."""
        across, along = self.operator.blocks
        if across * along == 1:
            return None
        parts = [
            self.undeformed_gap[i::across, j::along] for i in range(across) for j in range(along)
        ]
        gap = sum(parts[1:], start=parts[0]) / len(parts)
        resultant = self.resultant.scaled(1.0, across * along)
        return BareProblem(gap, self.operator.coarsened(), self.constraint, resultant)

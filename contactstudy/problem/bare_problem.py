"""The dimensionless contact problem that a solver sees."""

from dataclasses import dataclass
from math import inf, prod

import numpy as np

from contactstudy.domain.devices.arrays import Array, inner, total
from contactstudy.domain.devices.device import arrays, fused
from contactstudy.domain.devices.rows import in_blocks
from contactstudy.problem.constraint import Constraint
from contactstudy.problem.gap import Gap, largest
from contactstudy.problem.operator import Operator
from contactstudy.problem.resultant import Resultant

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
        """The measure of :func:`~contactstudy.solve`: the largest of complementarity, penetration and load."""
        kernels, most = fused(), self.constraint.capacity(1)
        if kernels is None:
            borne = total(pressure)
            left = self.constraint.residual(pressure, gap, borne)
            return largest(left, self.resultant.error(borne))

        def measure(rows: slice) -> tuple[float, float, float, float]:
            found: tuple[float, float, float, float] = kernels.violations(
                pressure[rows, :], gap.height[rows, :], most
            )
            return found

        borne, moment, free, worst = np.array(in_blocks(measure, pressure.shape)).T
        complementarity = moment.sum() / free.sum() if free.sum() > 0 else 0.0
        return largest(complementarity, *worst, self.resultant.error(float(borne.sum())))

    def gap(self, pressure: Array, displacement: Array, into: Gap | None = None) -> Gap:
        """The gap under ``pressure`` and the ``displacement`` it makes, ``into`` the field of another."""
        xp, kernels, most = arrays(), fused(), self.constraint.capacity(1)
        height = xp.empty_like(pressure) if into is None else into.height

        def add(rows: slice) -> tuple[float, float]:
            both = self.undeformed_gap[rows, :], displacement[rows, :]
            if kernels is not None:
                found: tuple[float, float] = kernels.level(*both, pressure[rows, :], most)
                return found
            free = self.constraint.free(pressure[rows, :])
            return inner(both[0] + both[1], free), float(xp.sum(free))

        heights, cells = map(sum, zip(*in_blocks(add, pressure.shape), strict=True))
        where = self.constraint.approach
        approach = heights / cells if cells else where(pressure, self.undeformed_gap + displacement)

        def count(rows: slice) -> None:
            both = self.undeformed_gap[rows, :], displacement[rows, :]
            if kernels is not None:
                kernels.heights(*both, approach, height[rows, :])
            else:
                height[rows, :] = both[0] + both[1] - approach

        in_blocks(count, height.shape)
        return Gap(height, approach)

    def rounding(self, displacement: Array) -> float:
        """What rounding leaves uncertain of a gap under ``displacement``: no residual means less."""

        xp = arrays()

        def highest(rows: slice) -> float:
            some = displacement[rows, :]
            return max(float(xp.max(some)), -float(xp.min(some)))

        height = largest(*in_blocks(highest, displacement.shape))
        return float(ROUNDINGS * xp.finfo(displacement.dtype).eps * height)

    def ends(self, residual: float, displacement: Array, tolerance: float) -> bool:
        """Whether no iteration can improve on ``residual``, or none needs to."""
        return not max(tolerance, self.rounding(displacement)) < residual < inf

    def coarsened(self) -> "BareProblem | None":
        """The same problem on blocks of cells, heights averaged; None where the grid does not halve."""
        across, along = self.operator.blocks
        if across * along == 1:
            return None
        nx, ny = self.undeformed_gap.shape
        xp = arrays()
        parts = xp.reshape(self.undeformed_gap, (nx // across, across, ny // along, along))
        gap = xp.mean(parts, axis=(1, 3))
        resultant = self.resultant.scaled(1.0, across * along)
        return BareProblem(gap, self.operator.coarsened(), self.constraint, resultant)

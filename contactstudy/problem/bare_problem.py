"""The dimensionless contact problem that a solver sees, and what the pressures of all cells carry together."""

from dataclasses import dataclass, field
from functools import cached_property
from math import inf, prod

from contactstudy.domain.device import arrays
from contactstudy.domain.fields import Array, in_blocks, total
from contactstudy.problem.constraint import Constraint, Gap, Resultant, largest
from contactstudy.problem.operator import Operator
from contactstudy.problem.passes import Passes, passes_for

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
    chosen_passes: Passes | None = field(default=None, kw_only=True, repr=False)

    @cached_property
    def passes(self) -> Passes:
        """Passes over its fields; those of coarser grids are the same."""
        return self.chosen_passes or passes_for(self.constraint, self.undeformed_gap.shape)

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
        return self.passes.levelled(trial, cells, self.resultant)

    def residual(self, pressure: Array, gap: Gap) -> float:
        """The measure of :func:`~contactstudy.solve`: the largest of complementarity, penetration and load.

        ``gap`` is that under ``pressure``.
        """
        borne = total(pressure) if gap.load is None else gap.load
        measured = gap.measured
        if measured is None:
            measured = self.constraint.residual(pressure, gap, borne)
        return largest(measured, self.resultant.error(borne))

    def gap(self, pressure: Array, displacement: Array, into: Gap | None = None) -> Gap:
        """The gap under ``pressure`` and the ``displacement`` it makes, ``into`` the field of another."""
        height = arrays().empty_like(pressure) if into is None else into.height
        return self.passes.gap(self.undeformed_gap, displacement, pressure, height)

    def rounding(self, displacement: Array, farthest: float | None = None) -> float:
        """What rounding leaves uncertain of a gap under ``displacement``: no residual means less.

        ``farthest`` is the size of the largest, where it is known.
        """
        xp = arrays()

        def highest(block: Array) -> float:
            return max(float(xp.max(block)), -float(xp.min(block)))

        if farthest is None:
            farthest = largest(*in_blocks(highest, displacement))
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
        operator = self.operator.coarsened()
        return BareProblem(gap, operator, self.constraint, resultant, chosen_passes=self.passes)

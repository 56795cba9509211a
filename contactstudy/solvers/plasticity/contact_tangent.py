"""How the pressure of a contact answers to a small change of its gap, as long as the same cells bear."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contactstudy.domain.devices.arrays import Array, inner, total
from contactstudy.domain.precision import Precision
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.operator import ApproximateInverse
from contactstudy.problem.problem import Scales
from contactstudy.solvers.plasticity.conjugate_gradients import conjugate_gradients
from contactstudy.solvers.solution import Solution

# A loose answer takes Newton's method no more iterations than an exact one.
TOLERANCE = 1e-2
LONGEST = 200


@dataclass(frozen=True, eq=False)
class ContactTangent:
    """``-dp/dgap`` under a fixed load: ``Pi = K^-1 - K^-1 1 1^T K^-1 / (1^T K^-1 1)`` on the cells that bear.

    Found by conjugate gradients, preconditioned as the contact is.
    """

    bare: BareProblem
    scales: Scales
    cells: Array

    @classmethod
    def of(cls, solution: Solution, precision: Precision) -> "ContactTangent":
        """For the cells that bear in ``solution``."""
        problem = solution.problem
        cells = (solution.pressure > 0).astype(precision.real)
        return cls(problem.bare(precision), problem.scales, cells)

    def __call__(self, gap: Array) -> Array:
        """``Pi gap`` (x, y) [Pa] of a change of the gap (x, y) [m]."""
        count = total(self.cells)
        if count < 2:
            return np.zeros_like(gap)
        real = self.bare.undeformed_gap.dtype
        rest = self._level(((gap / self.scales.gap) * self.cells).astype(real), count)
        found = conjugate_gradients(
            lambda field: self._level(self.bare.operator(field) * self.cells, count),
            lambda field: self._closing(field, count),
            inner,
            rest,
            TOLERANCE,
            LONGEST,
        )
        return np.asarray(found * self.scales.pressure, dtype=np.float64)

    def _closing(self, rest: Array, count: float) -> Array:
        return self._level(self._precondition(rest, self.cells) * self.cells, count)

    def _level(self, field: Array, count: float) -> Array:
        """Without its mean over the cells that bear."""
        return np.asarray((field - total(field) / count) * self.cells)

    @cached_property
    def _precondition(self) -> ApproximateInverse:
        return self.bare.operator.approximate_inverse()

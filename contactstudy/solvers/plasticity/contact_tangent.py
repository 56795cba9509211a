"""Tangent operator of a contact under a fixed load: minus the derivative of the pressure with respect to the gap."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array, inner, total
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.operator import Extension
from contactstudy.problem.problem import Scales
from contactstudy.solvers.conjugate_gradients import conjugate_gradients
from contactstudy.solvers.solution import Solution

# Relative residual of linear systems, with which the Newton method of a plastic step takes as many iterations as with
# exact ones, and their largest number of operator applications.
RTOL, MAXITER = 1e-2, 200


@dataclass(frozen=True, eq=False)
class ContactTangent:
    """Tangent operator ``-dp/dgap`` of a contact under a fixed load.

    It is ``Pi = K^-1 - K^-1 1 1^T K^-1 / (1^T K^-1 1)``, applied by conjugate gradients that are preconditioned as the
    contact is. `contact` (x, y) is 1 in the cells in contact and 0 elsewhere. Cells at a hardness count as the others,
    an approximation: in truth their pressure does not change.
    """

    bare: BareProblem
    scales: Scales
    contact: Array

    @classmethod
    def from_solution(cls, solution: Solution, precision: Precision) -> "ContactTangent":
        """Return the tangent operator of a `solution` whose cells in contact stay the same, in a `precision`."""
        problem = solution.problem
        contact = (solution.pressure > 0).astype(precision.real)
        return cls(problem.bare(precision), problem.scales, contact)

    def __call__(self, gap: Array) -> Array:
        """Return minus the change of the pressure, ``Pi gap`` (x, y) [Pa], by a change of the gap (x, y) [m]."""
        count = total(self.contact)
        if count < 2:
            return np.zeros_like(gap)
        real = self.bare.undeformed_gap.dtype
        deviation = self._deviation(((gap / self.scales.gap) * self.contact).astype(real), count)
        pressure = conjugate_gradients(
            lambda field: self._deviation(self.bare.operator(field) * self.contact, count),
            lambda field: self._preconditioned(field, count),
            inner,
            deviation,
            RTOL,
            MAXITER,
        )
        return np.asarray(pressure * self.scales.pressure, dtype=np.float64)

    def _preconditioned(self, residual: Array, count: float) -> Array:
        """Return the preconditioned `residual` of the gap."""
        return self._deviation(self._extension.pressure(self._extension(residual)), count)

    def _deviation(self, field: Array, count: float) -> Array:
        """Return `field` less its mean over the `count` cells in contact, and zero elsewhere."""
        return np.asarray((field - total(field) / count) * self.contact)

    @cached_property
    def _extension(self) -> Extension:
        """Preconditioner on the cells in contact."""
        return self.bare.operator.approximate_inverse().extension(self.contact)

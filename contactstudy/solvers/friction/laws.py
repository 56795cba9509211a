"""Tangential traction on the surface under full sliding."""

from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.fields import Array
from contactstudy.elasticity.convolution import GeneralConvolution
from contactstudy.problem.problem import Problem
from contactstudy.solvers.fixed_point import solve_by_fixed_point_iteration
from contactstudy.solvers.solution import Solution, TangentialTraction
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Outer iterations between pressure and tangential traction: errors fall by a factor of at least 1.7 from one to the
# next where both bodies are elastic and friction is below 1.
MAX_SLIDING_ITERATIONS = 200


@dataclass(frozen=True, eq=False)
class FullSliding:
    """Full sliding along x: the traction ``coefficient * pressure`` on the first body, and its reaction on the second.

    `coupling` maps tangential traction [Pa] to normal displacement [m]; None for elastically similar bodies (Dundurs'
    beta = 0), where traction does not change the pressure.
    """

    coefficient: float
    coupling: GeneralConvolution | None

    def solve(self, problem: Problem, options: SolveOptions, start: Array | None, device: Device) -> Solution:
        """Return the solution under tangential traction.

        With a coupling, pressure and traction are solved in turn, until the traction changes the gap by less than the
        tolerance. The coupling is odd, so that it has no place in a symmetric operator: its displacement is added to
        the gap.
        """
        coupling = self.coupling
        if coupling is None:
            solution = solve_contact(problem, options, start, device)
            return replace(solution, traction=self.traction(solution.pressure))
        applications = 0

        def gap_change(pressure: Array) -> Array:
            nonlocal applications
            applications += 1
            return self.coefficient * coupling(pressure)

        solution = solve_by_fixed_point_iteration(problem, gap_change, options, start, device, MAX_SLIDING_ITERATIONS)
        return replace(
            solution,
            convolutions=solution.convolutions + applications,
            traction=self.traction(solution.pressure, applications),
        )

    def traction(self, pressure: Array, applications: int = 1) -> TangentialTraction:
        """Return the traction of full sliding under `pressure` (x, y) [Pa]."""
        shear = np.stack([self.coefficient * pressure, np.zeros_like(pressure)])
        method = "full sliding" if self.coupling is None else "full sliding, shear lagged"
        return TangentialTraction(shear, np.zeros(pressure.shape, dtype=bool), method, applications)

"""Tangential traction on the surface: full sliding, and partial slip under a force below that of full sliding."""

from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.fields import Array
from contactstudy.elasticity.convolution import GeneralConvolution
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.problem.problem import Problem
from contactstudy.solvers.fixed_point import solve_by_fixed_point_iteration
from contactstudy.solvers.friction.bulk_stress import BulkStress
from contactstudy.solvers.friction.coulomb_newton import shear_status
from contactstudy.solvers.friction.partial_slip import slip_step, transmission_status
from contactstudy.solvers.solution import Solution, TangentialTraction, with_traction, worst
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

    def solve(
        self, problem: Problem, options: SolveOptions, start: Array | None, device: Device
    ) -> Solution:
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

        solution = solve_by_fixed_point_iteration(
            problem, gap_change, options, start, device, MAX_SLIDING_ITERATIONS
        )
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


@dataclass(frozen=True, eq=False)
class CiavarellaJaeger:
    """Tangential traction as a difference of two normal contacts: ``q = mu (p(P) - p(P - Q / mu))``.

    Cells stick where the second contact presses. It is exact where the tangential compliance is in proportion to the
    normal one: in plane strain, and where Poisson's ratio is zero. `coefficient` is mu; `fraction` is Q / (mu P),
    between -1 and 1. Source: Ciavarella (1998), Int. J. Solids Struct. 35, 2349; Jaeger (1998).
    """

    coefficient: float
    fraction: float

    def solve(
        self, problem: Problem, options: SolveOptions, start: Array | None, device: Device
    ) -> Solution:
        """Return the solution with its tangential traction from two normal contacts, and the worse status of both.

        The tolerance and the residual of the traction are those of the pressures over their relative difference; the
        residual is at most 1.
        """
        fraction = abs(self.fraction)
        if fraction:
            tolerance = max(options.tolerance * fraction, np.finfo(np.float64).tiny)
            options = replace(options, tolerance=tolerance)
        outer = solve_contact(problem, options, start, device)
        if not fraction:
            shear = np.zeros((2, *outer.pressure.shape))
            stick = outer.pressure > 0
            return replace(outer, traction=TangentialTraction(shear, stick, "Ciavarella-Jaeger", 1))
        reduced = replace(problem, control=problem.control.scaled(1 - fraction))
        inner = solve_contact(reduced, options, outer.pressure, device)
        traction_x = self.coefficient * np.maximum(outer.pressure - inner.pressure, 0)
        traction_x *= np.sign(self.fraction)
        if force := traction_x.sum():  # to the exact resultant after clipping
            traction_x *= self.coefficient * self.fraction * outer.pressure.sum() / force
        shear = np.stack([traction_x, np.zeros_like(traction_x)])
        traction = TangentialTraction(shear, inner.pressure > 0, "Ciavarella-Jaeger", 2)
        return with_traction(
            replace(outer, residual=min(outer.residual / fraction, 1.0)),
            inner.status,
            min(inner.residual / fraction, 1.0),
            inner.iterations,
            inner.convolutions,
            traction,
        )


@dataclass(frozen=True, eq=False)
class PartialSlipShear:
    """Tangential traction q of least complementary energy among ``|q| <= mu p`` with a given resultant along x.

    It has two components and minimises ``1/2 q A q``. A is self-adjoint and positive definite and the set convex, so
    that the minimum is unique. Cells within their limit stick, those at it slip against the traction. Loading is
    monotonic. `coefficient` is mu,
    `force_per_length` the resultant [N/m], `response` is A, and `bulk` stretches the bodies as the force rises. Source:
    Kalker (1990), ch. 4; with a bulk stress Nowell & Hills (1987), Int. J. Mech. Sci. 29, 355.
    """

    coefficient: float
    force_per_length: float
    response: ShearResponse
    bulk: BulkStress | None = None

    def solve(
        self, problem: Problem, options: SolveOptions, start: Array | None, device: Device
    ) -> Solution:
        """Return the normal contact with its tangential traction, by one step from no traction."""
        normal = solve_contact(problem, options, start, device)
        limit = self.coefficient * normal.pressure
        acts = transmission_status(self.force_per_length, limit, problem.grid)
        total = self.force_per_length * problem.grid.length / problem.grid.cell_area
        limits = options.tolerance, options.max_iterations
        unloaded, sums = np.zeros((2, *limit.shape)), np.array([total, 0.0])
        bulk = self.bulk or BulkStress()
        stretch = bulk.stretch(problem.grid, 0.0, bulk.size) if bulk.size else None
        step = slip_step(self.response, limit, unloaded, *limits, total=sums, stretch=stretch)
        count = step.applications
        status = worst([acts, shear_status(step.residual, count, *limits)])
        traction = TangentialTraction(
            step.shear, step.stick, "partial slip, Newton", count, bulk=bulk.of_bodies(bulk.size)
        )
        return with_traction(normal, status, step.residual, count, 2.0 * count, traction)

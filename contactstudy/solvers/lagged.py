"""Outer iterations over a displacement that follows from the pressure and is lagged: by mixing, or by substitution."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.fields import Array
from contactstudy.problem.problem import Problem
from contactstudy.solvers.anderson import AndersonMixing
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact


@dataclass(frozen=True)
class LaggedConstants:
    """Constants of the accelerated outer iteration.

    Attributes
    ----------
    depth
        Number of pressures before the last that enter a mixture.
    inner_reduction
        Tolerance of a solve over the change in the outer iteration before; a tenth of it saves no outer iteration.
    first_tolerance
        Largest tolerance of a solve.
    """

    depth: int = 8
    inner_reduction: float = 1e-3
    first_tolerance: float = 1e-4


CONSTANTS = LaggedConstants()


@dataclass(frozen=True, eq=False)
class LaggedSolution:
    """Solution with the lagged displacement under its own pressure.

    Parameters
    ----------
    solution
        The last solution.
    change
        Change of the pressure in the last outer iteration, relative in L1.
    outer_iterations
        Number of solves.
    iterations, convolutions
        Sums over all solves.
    """

    solution: Solution
    change: float
    outer_iterations: int
    iterations: int
    convolutions: float


def solve_with_mixing(
    problem: Problem,
    displacement_of: Callable[[Array], Array] | None,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    *,
    change: float = 1e-6,
    max_outer: int = 100,
) -> LaggedSolution:
    """Solve a problem with a displacement that follows from its own pressure, by Anderson's mixing of the pressures.

    It also converges where the map from pressure to pressure is no contraction. Each outer iteration solves with the
    displacement under a mixture of the pressures before, until one changes the pressure by less than `change`. Mixing:
    :class:`~contactstudy.solvers.anderson.AndersonMixing`.

    Parameters
    ----------
    problem
        The contact in SI units, without the displacement.
    displacement_of
        Map from pressure (x, y) [Pa] to the displacement to add to the gap (x, y) [m]; None for one plain solve.
    options
        Method and tolerance of each solve.
    change
        Change of the pressure in an outer iteration to stop at, relative in L1.
    max_outer
        Number of outer iterations after which the status is :attr:`~contactstudy.Status.NOT_CONVERGED`.

    Returns
    -------
    LaggedSolution
        The last solution and its counts.
    """
    if displacement_of is None:
        solution = solve_contact(problem, options)
        return LaggedSolution(solution, 0.0, 1, solution.iterations, solution.convolutions)
    mixing, guess = AndersonMixing(CONSTANTS.depth), np.zeros_like(problem.undeformed_gap)
    start: Array | None = None
    last_change, outer, iterations, convolutions = np.inf, 0, 0, 0.0
    while True:
        gap = problem.undeformed_gap + displacement_of(guess) if outer else problem.undeformed_gap
        loose = min(CONSTANTS.inner_reduction * last_change, CONSTANTS.first_tolerance)
        inner = replace(options, tolerance=max(options.tolerance, loose))
        solution = solve_contact(replace(problem, undeformed_gap=gap), inner, start)
        outer += 1
        iterations += solution.iterations
        convolutions += solution.convolutions
        start = solution.pressure
        if not np.isfinite(solution.residual):
            return LaggedSolution(solution, np.inf, outer, iterations, convolutions)
        step = solution.pressure - guess
        last_change = float(np.abs(step).sum() / solution.pressure.sum())
        converged = last_change <= change and solution.residual <= options.tolerance
        if converged or outer == max_outer:
            if not converged:
                solution = replace(solution, status=Status.NOT_CONVERGED)
            return LaggedSolution(solution, last_change, outer, iterations, convolutions)
        mixing.record(guess, step)
        guess = mixing.mixture()


def solve_by_substitution(
    problem: Problem,
    displacement_of: Callable[[Array], Array],
    options: SolveOptions,
    start: Array | None,
    on: Device,
    max_outer: int,
) -> Solution:
    """Return the solution of a problem with a displacement that follows from its own pressure, by substitution.

    It converges where the map is a contraction, as that of friction below 1 is between elastic bodies. Each outer
    iteration adds the displacement of the one before to the gap, until that changes the gap in the contact by less than
    the tolerance; the status is :attr:`~contactstudy.Status.NOT_CONVERGED` where it does not.

    Parameters
    ----------
    problem
        The contact in SI units, without the displacement.
    displacement_of
        Map from pressure (x, y) [Pa] to the displacement (x, y) [m], called once in each outer iteration.
    options, start, on
        Method and tolerance of each solve, pressure [Pa] to begin with, and device.
    max_outer
        Largest number of outer iterations.
    """
    solution = solve_contact(problem, options, start, on)
    if not solution.pressure.any():
        return solution
    iterations, convolutions, outer = solution.iterations, solution.convolutions, 1
    added: Array = np.zeros_like(solution.gap)
    while True:
        displacement = displacement_of(solution.pressure)
        change = deviation_in_contact(displacement - added, solution.pressure) / problem.scales.gap
        if change <= options.tolerance or outer == max_outer or not np.isfinite(change):
            break
        added = displacement
        lowered = replace(problem, undeformed_gap=problem.undeformed_gap + added)
        solution = solve_contact(lowered, options, solution.pressure, on)
        iterations += solution.iterations
        convolutions += solution.convolutions
        outer += 1
    status = solution.status
    if status is Status.CONVERGED and not change <= options.tolerance:
        status = Status.NOT_CONVERGED
    return replace(
        solution,
        problem=problem,
        displacement=solution.displacement + added,
        status=status,
        residual=max(solution.residual, change),
        iterations=iterations,
        convolutions=convolutions,
        note=" ".join(
            filter(
                None, (solution.note, f"{outer} outer iterations over the coupled displacement.")
            )
        ),
    )


def deviation_in_contact(change: Array, pressure: Array) -> float:
    """Return the effect of a `change` of the gap: its largest deviation in the contact from its mean there."""
    touching = pressure > 0
    if not touching.any():
        return 0.0
    within = change[touching]
    return float(np.abs(within - within.mean()).max())

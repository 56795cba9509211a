"""A problem whose operator has a part that is not symmetric: lagged into the gap, and accelerated."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.fields import Array
from contactstudy.problem.problem import Problem
from contactstudy.solvers.anderson import anderson_mixture
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Number of pressures that the next one is mixed of; tolerance of a solve over the change in the pass before.
DEPTH, FINER = 8, 1e-3


@dataclass(frozen=True, eq=False)
class LaggedSolution:
    """Solution whose gap holds the lagged part of its own pressure.

    Parameters
    ----------
    solution
        The last solution.
    change
        Change of the pressure in the last pass, relative in L1.
    passes
        Number of solves.
    iterations, convolutions
        Sums over all solves.
    """

    solution: Solution
    change: float
    passes: int
    iterations: int
    convolutions: float


def solve_lagged(
    problem: Problem,
    lagged: Callable[[Array], Array] | None,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    *,
    change: float = 1e-6,
    max_passes: int = 100,
) -> LaggedSolution:
    """Solve a problem with a displacement that follows from its own pressure and is lagged into the gap.

    Each pass solves with the lagged part of a mixture of the pressures before, until a pass changes the pressure by less
    than `change`. Source of the mixing: Anderson (1965), in the form of Walker & Ni (2011), eq. 2.2.

    Parameters
    ----------
    problem
        The contact in SI units, without the lagged part.
    lagged
        Map from pressure (x, y) [Pa] to the displacement to add to the gap (x, y) [m]; None for one plain solve.
    options
        Method and tolerance of each solve.
    change
        Change of the pressure in a pass to stop at, relative in L1.
    max_passes
        Number of passes after which the status is :attr:`~contactstudy.Status.ITERATION_LIMIT`.

    Returns
    -------
    LaggedSolution
        The last solution and what it took.
    """
    mixed: list[Array] = []
    steps: list[Array] = []
    guess = np.zeros_like(problem.undeformed_gap)
    start: Array | None = None
    last_change, passes, iterations, convolutions = np.inf, 0, 0, 0.0
    while True:
        gap = problem.undeformed_gap
        if lagged is not None and passes:
            gap = gap + lagged(guess)
        coarse = 0.0 if lagged is None else min(FINER * last_change, 1e-4)
        loose = replace(options, tolerance=max(options.tolerance, coarse))
        solution = solve_contact(replace(problem, undeformed_gap=gap), loose, start)
        passes += 1
        iterations += solution.iterations
        convolutions += solution.convolutions
        start = solution.pressure
        if lagged is None:
            return LaggedSolution(solution, 0.0, passes, iterations, convolutions)
        if not np.isfinite(solution.residual):
            return LaggedSolution(solution, np.inf, passes, iterations, convolutions)
        step = solution.pressure - guess
        last_change = float(np.abs(step).sum() / solution.pressure.sum())
        converged = last_change <= change and solution.residual <= options.tolerance
        if converged or passes == max_passes:
            if not converged:
                solution = replace(solution, status=Status.ITERATION_LIMIT)
            return LaggedSolution(solution, last_change, passes, iterations, convolutions)
        mixed, steps = [*mixed[-DEPTH:], guess], [*steps[-DEPTH:], step]
        guess = anderson_mixture(mixed, steps)


def solve_coupled(
    problem: Problem,
    lagged: Callable[[Array], Array],
    options: SolveOptions,
    start: Array | None,
    on: Device,
    max_passes: int,
) -> Solution:
    """Return the solution of a problem whose gap also changes by a displacement that is weakly coupled to its pressure.

    Each pass adds the displacement of the pass before to the gap. The passes end where that of a pass changes the gap by
    less than the tolerance; the status is :attr:`~contactstudy.Status.STALLED` where they do not.

    Parameters
    ----------
    problem
        The contact in SI units, without the displacement.
    lagged
        Map from pressure (x, y) [Pa] to the displacement (x, y) [m], called once in each pass.
    options, start, on
        Method and tolerance of each solve, pressure [Pa] to begin with, and device.
    max_passes
        Limit of the number of passes.
    """
    solution = solve_contact(problem, options, start, on)
    if not solution.pressure.any():
        return solution
    iterations, convolutions, passes = solution.iterations, solution.convolutions, 1
    added: Array = np.zeros_like(solution.gap)
    while True:
        displacement = lagged(solution.pressure)
        change = deviation_in_contact(displacement - added, solution.pressure) / problem.scales.gap
        if change <= options.tolerance or passes == max_passes or not np.isfinite(change):
            break
        added = displacement
        lowered = replace(problem, undeformed_gap=problem.undeformed_gap + added)
        solution = solve_contact(lowered, options, solution.pressure, on)
        iterations += solution.iterations
        convolutions += solution.convolutions
        passes += 1
    status = solution.status
    if status is Status.CONVERGED and not change <= options.tolerance:
        status = Status.STALLED
    return replace(
        solution,
        problem=problem,
        displacement=solution.displacement + added,
        status=status,
        residual=max(solution.residual, change),
        iterations=iterations,
        convolutions=convolutions,
        note=" ".join(filter(None, (solution.note, f"{passes} outer iterations over the shear."))),
    )


def deviation_in_contact(change: Array, pressure: Array) -> float:
    """Return the effect of a `change` of the gap: its largest deviation in the contact from its mean there."""
    touching = pressure > 0
    if not touching.any():
        return 0.0
    within = change[touching]
    return float(np.abs(within - within.mean()).max())

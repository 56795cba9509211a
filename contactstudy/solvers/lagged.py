"""A problem whose operator has a part that is not symmetric: lagged into the gap, and accelerated."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions

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
    Settled
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
        solution = loose.solved(replace(problem, undeformed_gap=gap), start)
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
        settled = last_change <= change and solution.residual <= options.tolerance
        if settled or passes == max_passes:
            if not settled:
                solution = replace(solution, status=Status.ITERATION_LIMIT)
            return LaggedSolution(solution, last_change, passes, iterations, convolutions)
        mixed, steps = [*mixed[-DEPTH:], guess], [*steps[-DEPTH:], step]
        guess = _mixed(mixed, steps)


def _mixed(guesses: list[Array], steps: list[Array]) -> Array:
    """Return the combination of guesses with the smallest step, moved by that step."""
    step = steps[-1]
    if len(steps) == 1:
        return guesses[-1] + step
    changes = np.stack([(after - before).ravel() for before, after in pairwise(steps)])
    moves = np.stack([(after - before).ravel() for before, after in pairwise(guesses)])
    share = np.linalg.lstsq(changes.T, step.ravel(), rcond=1e-12)[0]
    return guesses[-1] + step - np.reshape(share @ (moves + changes), step.shape)

"""A problem whose operator has a part that is not symmetric: lagged into the gap, and accelerated."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions

# Pressures that the next one is mixed of, and how much finer than the change in a pass each solve is.
DEPTH, FINER = 6, 1e-3


@dataclass(frozen=True, eq=False)
class Settled:
    """A ``solution`` whose gap holds the lagged part of its own pressure, but for a relative L1 ``change``.

    ``passes`` counts solves, ``iterations`` and ``convolutions`` are those of all.
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
) -> Settled:
    """Solve ``problem`` with ``lagged(pressure)`` [m] added to its gap, until the pressure stays.

    Each pass solves with the lagged part of a mixture of the pressures before, until a pass changes the pressure
    by less than ``change`` in L1. Where nothing is ``lagged``, one solve is enough. Not reaching ``change`` in
    ``max_passes`` is :attr:`~contactstudy.Status.ITERATION_LIMIT`.
    Source of the mixing: Anderson (1965), in the form of Walker & Ni (2011), eq. 2.2.
    """
    mixed: list[Array] = []
    steps: list[Array] = []
    guess = np.zeros_like(problem.undeformed_gap)
    start: Array | None = None
    found, passes, iterations, convolutions = np.inf, 0, 0, 0.0
    while True:
        gap = problem.undeformed_gap
        if lagged is not None and passes:
            gap = gap + lagged(guess)
        coarse = 0.0 if lagged is None else min(FINER * found, 1e-4)
        loose = replace(options, tolerance=max(options.tolerance, coarse))
        solution = loose.solved(replace(problem, undeformed_gap=gap), start)
        passes += 1
        iterations += solution.iterations
        convolutions += solution.convolutions
        start = solution.pressure
        if lagged is None:
            return Settled(solution, 0.0, passes, iterations, convolutions)
        if not np.isfinite(solution.residual):
            return Settled(solution, np.inf, passes, iterations, convolutions)
        step = solution.pressure - guess
        found = float(np.abs(step).sum() / solution.pressure.sum())
        settled = found <= change and solution.residual <= options.tolerance
        if settled or passes == max_passes:
            if not settled:
                solution = replace(solution, status=Status.ITERATION_LIMIT)
            return Settled(solution, found, passes, iterations, convolutions)
        mixed, steps = [*mixed[-DEPTH:], guess], [*steps[-DEPTH:], step]
        guess = _mixed(mixed, steps)


def _mixed(guesses: list[Array], steps: list[Array]) -> Array:
    """The combination of guesses whose step would be the smallest, one such step on."""
    step = steps[-1]
    if len(steps) == 1:
        return guesses[-1] + step
    changes = np.stack([(after - before).ravel() for before, after in pairwise(steps)])
    moves = np.stack([(after - before).ravel() for before, after in pairwise(guesses)])
    share = np.linalg.lstsq(changes.T, step.ravel(), rcond=1e-12)[0]
    return guesses[-1] + step - np.reshape(share @ (moves + changes), step.shape)

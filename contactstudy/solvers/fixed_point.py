"""A contact with a displacement that follows from its own pressure, by fixed-point (Picard) iteration or with mixing.

The mixing is that of Anderson (1965), in the form of Walker & Ni (2011), eq. 2.2.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.fields import Array
from contactstudy.problem.constraint import largest_of
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact


def solve_by_fixed_point_iteration(
    problem: Problem,
    displacement_of: Callable[[Array], Array],
    options: SolveOptions,
    start: Array | None,
    device: Device,
    max_outer: int,
) -> Solution:
    """Return the solution of a problem with a displacement that follows from its own pressure, by fixed-point iteration.

    It converges where the map is a contraction. The displacement by friction between elastic bodies is one for a
    coefficient of friction below 1. Each outer iteration adds the displacement under the last pressure to the gap, and
    solves the contact again, until the displacement changes the gap in the contact by at most the tolerance, in units
    of ``problem.scales.gap``. If it still changes by more after the last one, the status is
    :attr:`~contactstudy.Status.NOT_CONVERGED`.

    Parameters
    ----------
    problem
        The contact in SI units, without the displacement.
    displacement_of
        Map from pressure (x, y) [Pa] to the displacement (x, y) [m], called once in each outer iteration.
    options, start, device
        Method and tolerance of each solve, pressure [Pa] to begin with, and device.
    max_outer
        Largest number of outer iterations.
    """
    solution = solve_contact(problem, options, start, device)
    if not solution.pressure.any():
        return solution
    iterations, convolutions, outer = solution.iterations, solution.convolutions, 1
    added: Array = np.zeros_like(solution.gap)
    while True:
        displacement = displacement_of(solution.pressure)
        change = _change_in_contact(displacement - added, solution) / problem.scales.gap
        if change <= options.tolerance or outer == max_outer or not np.isfinite(change):
            break
        added = displacement
        displaced = replace(problem, undeformed_gap=problem.undeformed_gap + added)
        solution = solve_contact(displaced, options, solution.pressure, device)
        iterations += solution.iterations
        convolutions += solution.convolutions
        outer += 1
    status = solution.status
    if status.has_converged and not change <= options.tolerance:
        status = Status.NOT_CONVERGED if np.isfinite(change) else Status.NOT_FINITE
    return replace(
        solution,
        problem=problem,
        displacement=solution.displacement + added,
        status=status,
        residual=largest_of(solution.residual, change),
        iterations=iterations,
        convolutions=convolutions,
        note=f"{solution.note} {outer} outer iterations over the coupled displacement.".lstrip(),
    )


def _change_in_contact(change: Array, solution: Solution) -> float:
    """Return the largest `change` of the gap in the contact; under a given load, of what differs from its mean."""
    within = change[solution.pressure > 0]
    if not within.size:
        return 0.0
    if solution.problem.control.approach is None:
        within = within - within.mean()
    return float(np.abs(within).max())


# Singular values of the changes below this fraction of the largest are noise of the solves.
CUT_OFF = 1e-8
# Number of pressures before the last that enter a mixed pressure.
DEPTH = 8
# Tolerance of a solve over the change in the outer iteration before; a tenth of it saves no outer iteration.
INNER_REDUCTION = 1e-3
# Largest tolerance of a solve.
FIRST_TOLERANCE = 1e-4


class AndersonMixing:
    """Mixing of the last iterates of a fixed-point iteration, by Anderson (1965).

    Parameters
    ----------
    depth
        Number of iterates before the last that enter a mixed iterate.
    """

    def __init__(self, depth: int) -> None:
        self._depth = depth
        self.restart()

    def restart(self) -> None:
        """Forget all iterates."""
        self._iterates: list[Array] = []
        self._steps: list[Array] = []

    def record(self, iterate: Array, step: Array) -> None:
        """Record an `iterate` and the `step` that the fixed-point map adds to it."""
        self._iterates = [*self._iterates, iterate][-self._depth - 1 :]
        self._steps = [*self._steps, step][-self._depth - 1 :]

    @property
    def mixes(self) -> bool:
        """True if there are several iterates, so that the mixed iterate differs from the plain next one."""
        return len(self._steps) > 1

    def mixed_iterate(self) -> Array:
        """Return the combination of the iterates with the smallest step, moved by that step."""
        iterate, step = self._iterates[-1], self._steps[-1]
        if not self.mixes:
            return iterate + step
        changes = np.stack([(b - a).ravel() for a, b in pairwise(self._steps)], axis=1)
        moves = np.stack([(b - a).ravel() for a, b in pairwise(self._iterates)], axis=1)
        weights = np.linalg.lstsq(changes, step.ravel(), rcond=CUT_OFF)[0]
        return iterate + step - ((moves + changes) @ weights).reshape(step.shape)


@dataclass(frozen=True, eq=False)
class LaggedSolution:
    """Solution with a lagged displacement: the one under the mixed pressure of the outer iterations before.

    Where the outer iterations have converged, it is the displacement under the pressure of the solution.

    Parameters
    ----------
    solution
        The last solution, with the iterations and convolutions of all.
    change
        Change of the pressure in the last outer iteration, relative in L1.
    outer_iterations
        Number of solves.
    """

    solution: Solution
    change: float
    outer_iterations: int


def solve_with_mixing(
    problem: Problem,
    displacement_of: Callable[[Array], Array] | None,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    *,
    change: float = 1e-6,
    max_outer: int = 100,
    progress: Callable[[float, float], object] | None = None,
) -> LaggedSolution:
    """Return the solution of a problem with a displacement that follows from its own pressure, by Anderson's mixing.

    It also converges where the map from pressure to pressure is no contraction. Each outer iteration solves with the
    displacement under the mixed pressures before, until one changes the pressure by less than `change`.

    Parameters
    ----------
    problem
        The contact in SI units, without the displacement.
    displacement_of
        Map from pressure (x, y) [Pa] to the displacement to add to the gap (x, y) [m]; None for a single solve.
    options
        Method and tolerance of each solve.
    change
        Change of the pressure in an outer iteration to stop at, relative in L1.
    max_outer
        Number of outer iterations after which the status is :attr:`~contactstudy.Status.NOT_CONVERGED`, and the residual
        at least the change of the pressure.
    progress
        Called after each outer iteration with the change of the pressure in it, and with `change`.

    Returns
    -------
    LaggedSolution
        The last solution and its counts.
    """
    if displacement_of is None:
        solution = solve_contact(problem, options)
        if progress is not None:
            progress(0.0, change)
        return LaggedSolution(solution, 0.0, 1)
    mixing, guess = AndersonMixing(DEPTH), np.zeros_like(problem.undeformed_gap)
    start: Array | None = None
    last_change, outer, iterations, convolutions = np.inf, 0, 0, 0.0
    while True:
        gap = problem.undeformed_gap + displacement_of(guess) if outer else problem.undeformed_gap
        loose = min(INNER_REDUCTION * last_change, FIRST_TOLERANCE)
        inner = replace(options, tolerance=max(options.tolerance, loose))
        solution = solve_contact(replace(problem, undeformed_gap=gap), inner, start)
        outer += 1
        iterations += solution.iterations
        convolutions += solution.convolutions
        start = solution.pressure
        solution = replace(solution, iterations=iterations, convolutions=convolutions)
        if not np.isfinite(solution.residual):
            return LaggedSolution(solution, np.inf, outer)
        step = solution.pressure - guess
        distance = float(np.abs(step).sum())
        last_change = distance / float(solution.pressure.sum()) if distance else 0.0
        if progress is not None:
            progress(last_change, change)
        is_exact = solution.residual <= options.tolerance or solution.status is Status.PRECISION_LIMIT
        converged = last_change <= change and is_exact
        if converged or outer == max_outer:
            if not converged:
                residual = largest_of(solution.residual, last_change)
                solution = replace(solution, status=Status.NOT_CONVERGED, residual=residual)
            return LaggedSolution(solution, last_change, outer)
        mixing.record(guess, step)
        guess = mixing.mixed_iterate()

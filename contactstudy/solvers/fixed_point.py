"""A contact with a displacement that follows from its own pressure, solved by fixed-point (Picard) iteration."""

from collections.abc import Callable
from dataclasses import replace

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

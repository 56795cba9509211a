"""What every hard case is held to: the same cases as in the study ``stability``."""

import numpy as np
import pytest

import contactstudy as cs
from studies.reference.hard_case import PADDINGS, SOLVERS
from studies.reference.hard_cases import CASES

# Solutions that claim nothing, and say why.
UNFINISHED = {cs.Status.ITERATION_LIMIT, cs.Status.STALLED, cs.Status.NO_ADMISSIBLE_PRESSURE}


def ends_well(name: str, padding: str, solver: str) -> cs.Solution:
    """Solve a case, and hold it to its stated error, or to a status that says why there is none."""
    case = CASES[name]
    problem = case.scene.problem(case.grid, PADDINGS[padding])
    solution = case.solve(problem, SOLVERS[solver])
    assert solution.status in case.allowed_statuses(padding)
    for field in (solution.pressure, solution.displacement, solution.gap):
        assert np.isfinite(field).all()
    assert (solution.pressure >= 0).all()
    assert (solution.pressure <= case.scene.hardness).all()
    if solution.status in UNFINISHED:
        return solution
    carried = solution.pressure.sum() / problem.control.total
    # the solver's own sum is rounded: each pressure, and its way through the sum by halves
    rounding = np.finfo(case.options.precision.real).eps / 2 * (1 + np.log2(solution.pressure.size))
    assert carried == pytest.approx(1, rel=max(solution.residual, rounding, 1e-12))
    error, stated = case.error_and_bound(solution, PADDINGS[padding], SOLVERS[solver])
    assert error <= stated
    # and is worth stating: a residual times the condition of a few dozen elongated cells
    assert stated < max(1e-4, 100 * case.options.tolerance)
    return solution

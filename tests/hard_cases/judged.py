"""What every hard case is held to, the named ones of the study ``stability`` among them."""

import numpy as np
import pytest

import contactstudy as cs
from studies.reference.hard_case import PADDINGS, SOLVERS, Verdict
from tests.hard_cases.cases import CASES


def ends_well(name: str, padding: str, solver: str) -> cs.Solution:
    """Solve a case, and hold it to its stated error, or to a status that says why there is none."""
    case = CASES[name]
    problem = case.scene.problem(case.grid, PADDINGS[padding])
    solution = case.solve(problem, SOLVERS[solver])
    for field in (solution.pressure, solution.displacement, solution.gap):
        assert np.isfinite(field).all()
    assert (solution.pressure >= 0).all()
    assert (solution.pressure <= case.scene.hardness).all()
    judged = case.judge(solution, padding, SOLVERS[solver])
    assert judged.verdict in (Verdict.WITHIN_STATED_ERROR, Verdict.EXPLAINED_BY_STATUS), judged
    if judged.verdict is Verdict.WITHIN_STATED_ERROR:
        carried = solution.pressure.sum() / problem.control.total
        # the solver's own sum is rounded: each pressure, and its way through the sum by halves
        eps = np.finfo(case.options.precision.real).eps
        rounding = eps / 2 * (1 + np.log2(solution.pressure.size))
        assert carried == pytest.approx(1, rel=max(solution.residual, rounding, 1e-12))
    return solution

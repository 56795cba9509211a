"""What every hard case is held to, the named ones of the study ``stability`` among them: a dense matrix."""

import numpy as np
import pytest

from studies.definitions.hard_cases import SOLVERS
from tests.hard_cases.cases import CASES, PADDINGS
from tests.hard_cases.judged import Verdict, judged_by


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("padding", PADDINGS)
@pytest.mark.parametrize("name", CASES)
def test_a_hard_case_ends_well(name: str, padding: str, solver: str) -> None:
    """It keeps its stated error, or a status says why there is none."""
    case = CASES[name]
    problem = case.scene.problem(case.grid, PADDINGS[padding])
    solution = case.solve(problem, SOLVERS[solver])
    for field in (solution.pressure, solution.displacement, solution.gap):
        assert np.isfinite(field).all()
    assert (solution.pressure >= 0).all()
    assert (solution.pressure <= case.scene.hardness).all()
    judged = judged_by(case, solution, padding)
    assert judged.verdict in (Verdict.WITHIN_STATED_ERROR, Verdict.EXPLAINED_BY_STATUS), judged
    if judged.verdict is Verdict.WITHIN_STATED_ERROR:
        carried = solution.pressure.sum() / problem.control.total
        # the solver's own sum is rounded: each pressure, and its way through the sum by halves
        eps = np.finfo(case.options.precision).eps
        rounding = eps / 2 * (1 + np.log2(solution.pressure.size))
        assert carried == pytest.approx(1, rel=max(solution.residual, rounding, 1e-12))

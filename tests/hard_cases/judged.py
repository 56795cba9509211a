"""What every hard case is held to, the named ones of the study ``stability`` among them: a dense matrix."""

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.grid import across_and_along
from studies.definitions.hard_cases import SOLVERS
from tests.hard_cases.cases import CASES
from tests.hard_cases.dense_solver import answer, influence_matrix, plane_strain_matrix
from tests.hard_cases.hard_case import PADDINGS, HardCase, Judgement, Verdict


def judged_by(
    case: HardCase, solution: cs.Contact, padding: str, *, strips: bool = False
) -> Judgement:
    """The verdict by a dense matrix, whose strips are those of plane strain."""

    def reference() -> tuple[np.ndarray, float]:
        both = across_and_along(PADDINGS[padding])
        matrix_of = plane_strain_matrix if strips else influence_matrix
        dense = answer(case.scene, case.grid, both, solution, matrix_of)
        return dense.pressure * solution.problem.scales.pressure, dense.error

    return case.judge(solution, padding, reference)


def ends_well(name: str, padding: str, solver: str) -> cs.Solution:
    """Solve a case, and hold it to its stated error, or to a status that says why there is none."""
    case = CASES[name]
    problem = case.scene.problem(case.grid, PADDINGS[padding])
    solution = case.solve(problem, SOLVERS[solver])
    for field in (solution.pressure, solution.displacement, solution.gap):
        assert np.isfinite(field).all()
    assert (solution.pressure >= 0).all()
    assert (solution.pressure <= case.scene.hardness).all()
    judged = judged_by(case, solution, padding, strips=name == "strips of plane strain")
    assert judged.verdict in (Verdict.WITHIN_STATED_ERROR, Verdict.EXPLAINED_BY_STATUS), judged
    if judged.verdict is Verdict.WITHIN_STATED_ERROR:
        carried = solution.pressure.sum() / problem.control.total
        # the solver's own sum is rounded: each pressure, and its way through the sum by halves
        eps = np.finfo(case.options.precision).eps
        rounding = eps / 2 * (1 + np.log2(solution.pressure.size))
        assert carried == pytest.approx(1, rel=max(solution.residual, rounding, 1e-12))
    return solution

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions.hard_cases import SOLVERS
from tests.hard_cases.cases import CASES
from tests.hard_cases.hard_case import EXACT


@pytest.mark.parametrize("solver", SOLVERS)
def test_an_interrupted_solve_goes_on_where_it_stopped(solver: str) -> None:
    case = CASES["restart"]
    problem = case.scene.problem(case.grid, EXACT)
    whole = cs.solve(problem, tolerance=1e-10, solver=SOLVERS[solver])
    first = cs.solve(problem, tolerance=1e-10, solver=SOLVERS[solver], max_iterations=5)
    assert first.status is cs.Status.ITERATION_LIMIT
    second = cs.solve(problem, tolerance=1e-10, solver=SOLVERS[solver], start=first.pressure)
    assert second.status is cs.Status.CONVERGED
    assert second.iterations < whole.iterations
    # two residuals times the condition of 24 cells
    difference = np.abs(second.pressure - whole.pressure).max() / problem.scales.pressure
    assert difference < 2 * 24 * 1e-10

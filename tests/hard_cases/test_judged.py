"""What the judgement of hard cases refuses: answers that are worse than the program says."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions.hard_cases import ROUGH, HardCase, grid, with_heights
from tests.hard_cases.cases import CASES, PADDINGS
from tests.hard_cases.dense_solver import answer
from tests.hard_cases.judged import Verdict, judged_by

CASE = HardCase(with_heights(ROUGH), grid())
SOLVER = cs.PreconditionedCG()
PADDING = "exact"


@pytest.fixture(scope="module")
def solution() -> cs.Contact:
    return CASE.solve(CASE.scene.problem(CASE.grid, PADDINGS[PADDING]), SOLVER)


def test_an_answer_is_judged_by_the_error_that_the_program_states(solution: cs.Contact) -> None:
    judged = judged_by(CASE, solution, PADDING)
    assert judged.verdict is Verdict.WITHIN_STATED_ERROR
    assert judged.error <= judged.stated == solution.error.l1.residual < 1e-8
    dense = answer(CASE.scene, CASE.grid, (cs.ZeroPadding(), cs.ExactPeriodicity()), solution)
    difference = np.abs(solution.pressure / solution.problem.scales.pressure - dense.pressure)
    assert judged.error == pytest.approx(difference.sum() / dense.pressure.sum(), rel=1e-9)


@dataclass(frozen=True)
class Misreporting:
    """A solver whose pressure is wrong by a part, and which says that it has converged."""

    part: float

    def iterate(self, problem: cs.BareProblem, *, tolerance: float, max_iterations: int, start: object) -> cs.Iterate:
        right = SOLVER.iterate(problem, tolerance=tolerance, max_iterations=max_iterations, start=None)
        noise = 1 + self.part * np.random.default_rng(1).standard_normal(right.pressure.shape)
        noisy = np.maximum(right.pressure * noise, 0.0)
        noisy *= right.pressure.sum() / noisy.sum()
        return replace(right, pressure=noisy)


@pytest.mark.parametrize("part", [1e-6, 0.3])
def test_a_solver_that_misreports_its_residual_is_refused(part: float) -> None:
    noisy = CASE.solve(CASE.scene.problem(CASE.grid, PADDINGS[PADDING]), Misreporting(part))
    assert judged_by(CASE, noisy, PADDING).verdict is Verdict.WRONG


def test_a_solution_with_the_window_of_another_padding_is_refused() -> None:
    other = "circular"
    solution = CASE.solve(CASE.scene.problem(CASE.grid, PADDINGS[other]), SOLVER)
    assert judged_by(CASE, solution, other).verdict is Verdict.WITHIN_STATED_ERROR
    # the dense answer of exact periodicity, in the scales of this problem
    assert judged_by(CASE, solution, PADDING).verdict is Verdict.WRONG


def test_a_status_explains_a_missing_answer_only_where_it_is_expected(solution: cs.Contact) -> None:
    case = CASES["hardness below the mean pressure"]
    problem = case.scene.problem(case.grid, PADDINGS[PADDING])
    soft = case.solve(problem, SOLVER)
    assert judged_by(case, soft, PADDING).verdict is Verdict.EXPLAINED_BY_STATUS
    stalled = replace(solution, status=cs.Status.STALLED)
    assert judged_by(CASE, stalled, PADDING).verdict is Verdict.WRONG

"""What every hard case is held to, the named ones of the study ``stability`` among them: a dense matrix."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.grid import across_and_along
from studies.definitions.hard_cases import ROUGH, SOLVERS, UNFINISHED, HardCase, grid, stated_error, with_heights
from studies.reference.line_contact import relative_l1
from tests.hard_cases.cases import CASES, PADDINGS
from tests.hard_cases.dense_solver import answer


def is_right(case: HardCase, solution: cs.Contact, padding: str) -> bool:
    """Whether an answer keeps the error that it states, by a dense matrix, or a status explains why there is none."""
    expected = case.expects(solution, PADDINGS[padding])
    if solution.status in UNFINISHED:
        return expected
    dense = answer(case.scene, case.grid, across_and_along(PADDINGS[padding]), solution)
    error = relative_l1(solution.pressure / solution.problem.scales.pressure, dense.pressure)
    stated = stated_error(solution)
    return bool(expected and error <= stated + dense.error and case.is_useful(stated))


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("padding", PADDINGS)
@pytest.mark.parametrize("name", CASES)
def test_a_hard_case_ends_well(name: str, padding: str, solver: str) -> None:
    case = CASES[name]
    problem = case.scene.problem(case.grid, PADDINGS[padding])
    solution = case.solve(problem, SOLVERS[solver])
    for field in (solution.pressure, solution.displacement, solution.gap):
        assert np.isfinite(field).all()
    assert (solution.pressure >= 0).all()
    assert (solution.pressure <= case.scene.hardness).all()
    assert is_right(case, solution, padding), solution.status
    if solution.status not in UNFINISHED:
        carried = solution.pressure.sum() / problem.control.total
        # the solver's own sum is rounded: each pressure, and its way through the sum by halves
        eps = np.finfo(case.options.precision).eps
        rounding = eps / 2 * (1 + np.log2(solution.pressure.size))
        assert carried == pytest.approx(1, rel=max(solution.residual, rounding, 1e-12))


CASE, SOLVER = HardCase(with_heights(ROUGH), grid()), cs.PreconditionedCG()


@dataclass(frozen=True)
class Misreporting:
    """A solver whose pressure is wrong by a part, and which says that it has converged."""

    part: float

    def iterate(self, problem: cs.BareProblem, *, tolerance: float, max_iterations: int, start: object) -> cs.Iterate:
        right = SOLVER.iterate(problem, tolerance=tolerance, max_iterations=max_iterations, start=None)
        noise = 1 + self.part * np.random.default_rng(1).standard_normal(right.pressure.shape)
        noisy = np.maximum(right.pressure * noise, 0.0)
        return replace(right, pressure=noisy * right.pressure.sum() / noisy.sum())


def test_an_answer_that_is_worse_than_it_says_or_of_another_padding_is_not_right() -> None:
    for part in (1e-6, 0.3):
        noisy = CASE.solve(CASE.scene.problem(CASE.grid, PADDINGS["exact"]), Misreporting(part))
        assert not is_right(CASE, noisy, "exact")
    circular = CASE.solve(CASE.scene.problem(CASE.grid, PADDINGS["circular"]), SOLVER)
    assert is_right(CASE, circular, "circular")
    assert not is_right(CASE, circular, "exact")
    assert not is_right(CASE, replace(circular, status=cs.Status.STALLED), "circular")

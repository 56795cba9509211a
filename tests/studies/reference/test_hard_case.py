from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from studies.reference.dense_solver import answer, stated_error
from studies.reference.hard_case import EXACT, ROUGH, EquivalentForm, HardCase, grid, with_heights

CASE = HardCase(with_heights(ROUGH), grid())
PAIR = (cs.PreconditionedCG(), (cs.ZeroPadding(), EXACT))


@pytest.fixture(scope="module")
def solution() -> cs.Solution:
    solver, padding = PAIR
    return CASE.solve(CASE.scene.problem(CASE.grid, padding), solver)


def judged(case: HardCase, solution: cs.Solution) -> tuple[float, float]:
    solver, padding = PAIR
    return case.error_and_bound(solution, padding, solver)


def test_a_pressure_is_judged_by_the_dense_answer_over_the_peak(solution: cs.Solution) -> None:
    """A pressure that is wrong in one cell is wrong by that, and is not said to be right."""
    error, stated = judged(CASE, solution)
    assert error <= stated < 1e-7
    highest = solution.pressure.max()
    place = np.unravel_index(solution.pressure.argmax(), solution.pressure.shape)
    wrong = solution.pressure.copy()
    wrong[place] *= 1.25
    off = replace(solution, pressure=wrong)
    found, allowed = judged(CASE, off)
    assert found == pytest.approx(0.25 * highest / (1.25 * highest), abs=2 * stated)
    assert allowed > found
    dense = answer(CASE.scene, CASE.grid, PAIR[1], solution)
    unit = solution.problem.scales.pressure
    assert stated == pytest.approx(stated_error(solution, dense) * unit / highest, rel=1e-12)


def test_a_pressure_is_judged_by_that_of_an_equivalent_form(solution: cs.Solution) -> None:
    mirrored = with_heights(ROUGH[::-1])
    equivalent = EquivalentForm(
        mirrored, CASE.grid, lambda pressure: pressure[::-1], tolerance=3e-6
    )
    error, allowed = judged(replace(CASE, equivalent=equivalent), solution)
    assert allowed == 3e-6
    assert error < 1e-7
    equivalent = replace(equivalent, to_original=lambda pressure: 2 * pressure[::-1])
    error, allowed = judged(replace(CASE, equivalent=equivalent), solution)
    assert error == pytest.approx(1, rel=1e-6)


def test_other_heights_may_move_the_pressure_by_their_difference_over_the_smallest_eigenvalue(
    solution: cs.Solution,
) -> None:
    """Beside what the equivalent's pressure may be wrong by, and what the dense answer states."""
    heights = np.zeros(CASE.grid.cells)
    heights[3, 4], heights[7, 2] = 3e-6, -4e-6
    equivalent = EquivalentForm(
        with_heights(ROUGH + heights),
        CASE.grid,
        lambda pressure: pressure,
        2e-6,
        other_heights=True,
    )
    error, allowed = judged(replace(CASE, equivalent=equivalent), solution)
    dense = answer(CASE.scene, CASE.grid, PAIR[1], solution)
    unit, highest = solution.problem.scales.pressure, solution.pressure.max()
    # in multiples of what a contact flattens, 3-4-5
    change = 5e-6 / dense.smallest_eigenvalue * unit / highest
    _, stated = judged(CASE, solution)
    # heights are told to machine epsilons of the largest gap
    assert allowed == pytest.approx(2e-6 + stated + change, rel=1e-6)
    assert error <= allowed

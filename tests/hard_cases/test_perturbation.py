from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from studies.reference.hard_case import PADDINGS
from studies.reference.hard_cases import CASES


def test_a_nudge_of_heights_is_allowed_little() -> None:
    case, padding, solver = (
        CASES["heights nudged by 1e-10"],
        PADDINGS["exact"],
        cs.PreconditionedCG(),
    )
    solution = case.solve(case.scene.problem(case.grid, padding), solver)
    _, stated = case.error_and_bound(solution, padding, solver)
    # 1e-10 of an rms of 0.1, times the condition of 24 cells across, by root of their number
    assert 1e-11 < stated < 1e-11 * 24 * np.sqrt(288)


@pytest.mark.parametrize(
    ("name", "padding"), [("moved by whole cells", "superposed"), ("twice the period", "circular")]
)
def test_a_truncated_window_tells_what_exact_periodicity_does_not(name: str, padding: str) -> None:
    case = replace(CASES[name], paddings=(padding,))
    assert padding not in CASES[name].paddings
    solution = case.solve(case.scene.problem(case.grid, PADDINGS[padding]), cs.PreconditionedCG())
    error, stated = case.error_and_bound(solution, PADDINGS[padding], cs.PreconditionedCG())
    assert error > 1e-3 > stated

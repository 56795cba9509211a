from dataclasses import replace

import pytest

import contactstudy as cs
from studies.reference.hard_case import PADDINGS
from studies.reference.hard_cases import CASES


@pytest.mark.parametrize(
    ("name", "padding"), [("moved by whole cells", "superposed"), ("twice the period", "circular")]
)
def test_a_truncated_window_tells_what_exact_periodicity_does_not(name: str, padding: str) -> None:
    case = replace(CASES[name], paddings=(padding,))
    assert padding not in CASES[name].paddings
    solution = case.solve(case.scene.problem(case.grid, PADDINGS[padding]), cs.PreconditionedCG())
    error, stated = case.error_and_bound(solution, PADDINGS[padding], cs.PreconditionedCG())
    assert error > 1e-3 > stated

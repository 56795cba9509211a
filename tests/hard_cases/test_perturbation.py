from dataclasses import replace

import pytest

import contactstudy as cs
from studies.definitions.hard_case import PADDINGS, Verdict
from tests.hard_cases.cases import CASES
from tests.hard_cases.judged import judged_by


@pytest.mark.parametrize(
    ("name", "padding"), [("moved by whole cells", "superposed"), ("twice the period", "circular")]
)
def test_a_truncated_window_tells_what_exact_periodicity_does_not(name: str, padding: str) -> None:
    case = replace(CASES[name], paddings=(padding,))
    assert padding not in CASES[name].paddings
    solver = cs.PreconditionedCG()
    solution = case.solve(case.scene.problem(case.grid, PADDINGS[padding]), solver)
    judged = judged_by(case, solution, padding)
    assert judged.error > 1e-3 > judged.stated
    assert judged.verdict is Verdict.WRONG

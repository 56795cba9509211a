"""What becomes of a hard case, of solutions that are written here."""

from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

import contactstudy as cs
from studies.definitions import stability
from studies.registry import load

DONE, LIMIT, STALLED = cs.Status.CONVERGED, cs.Status.PRECISION_LIMIT, cs.Status.STALLED
RIGHT, EXPLAINED, WRONG, NOT = range(4)


@pytest.mark.parametrize(
    ("status", "residual", "padding", "error", "verdict"),
    [
        (DONE, 1e-6, "exact", 0.02, RIGHT),
        (DONE, 1e-6, "exact", 0.021, WRONG),
        # it claims nothing
        (DONE, 1.1e-6, "exact", 0.01, EXPLAINED),
        # no more can be had of its numbers, and that is a claim
        (LIMIT, 1e-3, "exact", 0.01, RIGHT),
        (STALLED, 1e-3, "exact", 0.01, WRONG),
        (STALLED, 1e-7, "exact", 0.01, WRONG),
        (DONE, 1e-7, "zero", 0.01, NOT),
    ],
)
def test_a_case_is_right_within_its_stated_error_and_else_must_say_why(
    status: cs.Status,
    residual: float,
    padding: str,
    error: float,
    verdict: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = SimpleNamespace(
        options=cs.SolveOptions(1e-6),
        paddings=("exact",),
        may_end=lambda _: {DONE, LIMIT},
        judge=lambda *_: (error, 0.02),
    )
    monkeypatch.setattr(stability, "CASES", {"made up": case})
    one = stability.HardCaseRun("made up", padding, "Polonsky-Keer")
    solution: Any = SimpleNamespace(status=status, residual=residual)
    found = {name: float(of) for name, of in load("stability").measures(one, solution).items()}
    assert found["verdict"] == verdict
    judged = padding == "exact" and (residual <= 1e-6 or status is LIMIT)
    assert found["pressure_error"] == (error if judged else 0)
    assert found["stated_error"] == (0.02 if judged else inf)

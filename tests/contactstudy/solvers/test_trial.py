"""The pressure one step ahead, by hand: with array operations, and with compiled passes."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from contactstudy.domain import fields
from contactstudy.problem.constraint import Compressive, HardnessLimited
from contactstudy.problem.passes import CompiledPasses, passes_for
from contactstudy.solvers.preconditioned_cg import PressureStep, trial_along

COMPRESSIVE = Compressive()
RNG = np.random.default_rng(3)
CELLS = np.zeros((5, 4))
CELLS[1:4, 1:] = 1.0
PRESSURE = CELLS * (2 + RNG.random(CELLS.shape))
CLOSING = CELLS * RNG.standard_normal(CELLS.shape)
COUNT = CELLS.sum()


@pytest.fixture(params=["array operations", "compiled"], autouse=True)
def passes(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param == "compiled":
        pytest.importorskip("numba")
        monkeypatch.setattr(fields, "LARGE", 1)
    chosen = passes_for(COMPRESSIVE, CELLS.shape)
    assert isinstance(chosen, CompiledPasses) == (request.param == "compiled")


def step(sum_of_step: float = 0.0) -> PressureStep:
    """Across the closing pressure, with a response that is no multiple of it."""
    others = np.stack([CELLS.ravel(), CLOSING.ravel()])
    taken = (CELLS * RNG.standard_normal(CELLS.shape)).ravel()
    taken -= others.T @ np.linalg.solve(others @ others.T, others @ taken)
    taken = taken.reshape(CELLS.shape) + CELLS * sum_of_step / COUNT
    response = 0.7 * taken + 0.1 * RNG.standard_normal(CELLS.shape)
    response *= 0.5 / (taken * response).sum()
    return PressureStep(PRESSURE + taken, PRESSURE, response, np.zeros_like(response), 0.5)


def back(last: PressureStep) -> np.ndarray:
    """That step, from its end to its beginning."""
    return last.before - last.after


def direction(
    gap: np.ndarray, last: PressureStep | None, length: float = 0.25, constraint: Any = COMPRESSIVE
) -> tuple[np.ndarray, bool]:
    """Over the ``length``; the pressure before the last step is overwritten."""
    height: Any = SimpleNamespace(height=gap)
    problem: Any = SimpleNamespace(passes=passes_for(constraint, gap.shape))
    trial, found = trial_along(problem, PRESSURE, height, CLOSING, CELLS, last, last, length)
    return (trial - PRESSURE) / length, found.cut


def plain() -> np.ndarray:
    """Against the pressure that closes, and the load stays."""
    return np.asarray(CELLS * (CLOSING.sum() / COUNT - CLOSING))


def test_the_first_step_is_against_the_closing_pressure(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever there is in the memory that it is written to."""
    monkeypatch.setattr(np, "empty_like", lambda field: np.full_like(field, np.nan))
    found, cut = direction(CLOSING, None)
    np.testing.assert_allclose(found, plain(), rtol=0, atol=1e-13)
    assert not cut


def kept_of(last: PressureStep) -> float:
    """So much of the last step as makes the work of the new one on its response zero."""
    return float(-(plain() * last.displacement_before).sum() / last.curvature)


def test_a_step_is_conjugate_to_the_last_one_where_that_is_downhill() -> None:
    """It is written in place of that step, and shifts no load."""
    last = step()
    kept, before = kept_of(last), back(last)
    gap = CLOSING - np.sign(kept) * before
    found, _ = direction(gap, last)
    np.testing.assert_allclose(found, plain() + kept * before, rtol=0, atol=1e-12)
    assert abs((found * last.displacement_before).sum()) < 1e-12
    assert abs(found.sum()) < 1e-12
    np.testing.assert_array_equal(last.before, PRESSURE + 0.25 * found)


def test_a_step_that_would_be_uphill_is_the_plain_one() -> None:
    """What the last step adds to its slope: twice what there is, and half of it."""
    downhill = (CLOSING * CLOSING).sum()
    for share, expected in ((2.0, False), (0.5, True)):
        last = step()
        kept, before = kept_of(last), back(last)
        rises = share * downhill / (kept * (before * before).sum())
        found, _ = direction(CLOSING + rises * before, last)
        assert np.allclose(found, plain() + kept * before) == expected
        assert np.allclose(found, plain()) != expected


def test_a_last_step_that_shifted_load_shifts_none_now() -> None:
    last = step(sum_of_step=0.5)
    found, _ = direction(CLOSING - np.sign(kept_of(last)) * back(last), last)
    assert not np.allclose(found, plain())
    assert abs(found.sum()) < 1e-12


def test_a_last_step_that_bends_the_wrong_way_is_forgotten() -> None:
    last = step()
    for curvature in (0.0, -1.0):
        found, _ = direction(CLOSING, replace(last, before=last.before.copy(), curvature=curvature))
        np.testing.assert_allclose(found, plain(), rtol=0, atol=1e-13)


def test_a_limit_that_is_met_is_said() -> None:
    """So far along the direction that a cell would pull."""
    farthest = float((PRESSURE[CELLS > 0] / -plain()[CELLS > 0])[plain()[CELLS > 0] < 0].min())
    assert not direction(CLOSING, None, length=0.99 * farthest)[1]
    assert direction(CLOSING, None, length=1.01 * farthest)[1]
    highest = (PRESSURE + 0.25 * plain()).max()
    for share, cut in ((0.99, True), (1.01, False)):
        hard = HardnessLimited(share * highest)
        assert direction(CLOSING, None, constraint=hard)[1] == cut

"""The line from a pressure to a trial, by hand, and by compiled passes that are told what they find."""

import numpy as np
import pytest

from contactstudy.problem.constraint import Gap
from contactstudy.solvers import preconditioned_cg as line
from contactstudy.solvers.preconditioned_cg import advance, curvature_to, meets_a_limit, slope_to
from tests.contactstudy.solvers.kernels import Kernels, limited

PRESSURE = np.array([[1.0, 2.0], [0.5, 0.0], [3.0, 1.5]])
TRIAL = np.array([[2.0, 1.0], [0.75, 0.25], [1.0, 0.0]])
MOVED = np.array([[0.5, 4.0], [1.0, 2.0], [0.25, 0.0]])
AHEAD = np.array([[2.5, 3.0], [1.5, 2.25], [0.75, 1.0]])
GAP = Gap(np.array([[0.5, -1.0], [2.0, 4.0], [0.25, 0.5]]), 0.0)
STEP, RESPONSE = TRIAL - PRESSURE, AHEAD - MOVED


def test_slope_and_curvature_are_works_of_the_step() -> None:
    # steps of 1, -1, 0.25, 0.25, -2, and -1.5
    assert slope_to(TRIAL, PRESSURE, GAP) == 0.5 + 1 + 0.5 + 1 - 0.5 - 0.75
    # that change the displacement by 2, -1, 0.5, 0.25, 0.5 and 1
    assert curvature_to(TRIAL, PRESSURE, AHEAD, MOVED) == 2 + 1 + 0.125 + 0.0625 - 1 - 1.5


@pytest.mark.parametrize(("factor", "meets"), [(1.0, False), (1.01, True)])
def test_a_limit_is_met_beyond_it(factor: float, meets: bool) -> None:  # noqa: FBT001
    assert meets_a_limit(limited(3.0), TRIAL, PRESSURE, factor) == meets
    higher = PRESSURE + 0.5 * np.eye(3, 2)
    assert meets_a_limit(limited(1.5), higher, PRESSURE, 0.0)
    assert not meets_a_limit(limited(3.5), np.maximum(higher, TRIAL), PRESSURE, 1.0)
    assert meets_a_limit(limited(3.5), PRESSURE + np.eye(3, 2), PRESSURE, 3.0)


@pytest.mark.parametrize("taken", [1.0, 0.5, 2.0])
def test_an_advance_leaves_what_is_ahead_and_the_steps_there(taken: float) -> None:
    trial, pressure, ahead, moved = (one.copy() for one in (TRIAL, PRESSURE, AHEAD, MOVED))
    advance(limited(2.5), trial, pressure, ahead, moved, taken)
    there = TRIAL if taken == 1 else np.clip(PRESSURE + taken * STEP, 0, 2.5)
    np.testing.assert_array_equal(trial, there)
    np.testing.assert_array_equal(ahead, MOVED + taken * RESPONSE)
    np.testing.assert_array_equal(pressure, taken * STEP)
    np.testing.assert_array_equal(moved, taken * RESPONSE)


def test_compiled_passes_are_asked_with_the_limit_of_a_cell(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of three rows."""
    kernels = Kernels(slope=(0.5,), curvature=(0.25,), beyond=(0.0,))
    monkeypatch.setattr(line, "fused", lambda: kernels)
    problem = limited(2.5)
    assert slope_to(TRIAL, PRESSURE, GAP) == 1.5
    assert curvature_to(TRIAL, PRESSURE, AHEAD, MOVED) == 0.75
    assert not meets_a_limit(problem, TRIAL, PRESSURE, 2.0)
    assert kernels.asked["beyond"][2:4] == (2.0, 2.5)
    kernels.results["beyond"] = (1.0,)
    assert meets_a_limit(problem, TRIAL, PRESSURE, 2.0)
    advance(problem, TRIAL, PRESSURE, AHEAD, MOVED, 0.5)
    assert kernels.asked["advance"][4:] == (0.5, 2.5)

"""A trial pressure by hand, and by compiled passes that are told what they find."""

from dataclasses import replace

import numpy as np
import pytest

from contactstudy.problem.constraint import Gap
from contactstudy.problem.passes import TrialSums
from contactstudy.solvers.preconditioned_cg import PressureStep, _direction, trial_along
from tests.contactstudy.solvers.kernels import Kernels, limited

PASSES = limited(4.0).passes
PRESSURE = np.array([[1.0, 2.0], [0.5, 0.0], [3.0, 1.5]])
CELLS = np.array([[1.0, 1.0], [1.0, 0.0], [1.0, 0.0]])
CLOSING = np.array([[0.5, -1.0], [2.0, 0.0], [0.25, 0.0]])
HEIGHT = np.array([[0.5, -1.0], [2.0, 4.0], [0.25, 0.5]])
# From its end to its beginning, of other cells, too.
BACK = np.array([[0.25, -0.5], [1.0, 5.0], [0.5, 0.0]])
MOVED = np.array([[1.0, 0.5], [0.25, 3.0], [2.0, 0.125]])
RESPONSE = np.array([[1.0, -2.0], [3.0, 7.0], [0.5, 0.25]])
STEP = PressureStep(PRESSURE + BACK, PRESSURE, MOVED + RESPONSE, MOVED, curvature=4.0)
# Four cells that 1.75 would close; 9.0625 along what the step moved, 2.5 of that in these cells.
LEVEL = 1.75 / 4
ALONG = 0.5 + 2 + 6 + 0.125
KEPT = (ALONG - LEVEL * 2.5) / 4


def test_a_direction_is_level_and_conjugate_to_the_last_step_where_that_is_downhill() -> None:
    assert _direction(PASSES, HEIGHT, CLOSING, CELLS, None) == (LEVEL, 0)
    # the step changed these cells by 1.25 together
    found = _direction(PASSES, HEIGHT, CLOSING, CELLS, STEP)
    assert found == pytest.approx((LEVEL - KEPT * 1.25 / 4, KEPT))
    # 5.3125 downhill against the gap, of which so much of the step would lose 2.75 a time
    assert (HEIGHT * CLOSING).sum() == 5.3125
    assert (HEIGHT * CELLS * BACK).sum() == 2.75
    for curvature, conjugate in (
        (4.0, True),
        (3.9, True),
        (3.8, False),
        (0.0, False),
        (-4.0, False),
    ):
        kept = _direction(PASSES, HEIGHT, CLOSING, CELLS, replace(STEP, curvature=curvature))[1]
        assert bool(kept) == conjugate
    # a step that had lowered the energy, however little it bends
    back = replace(STEP, before=PRESSURE - BACK, curvature=0.5)
    assert _direction(PASSES, HEIGHT, CLOSING, CELLS, back)[1] == pytest.approx(8 * KEPT)


def test_a_trial_goes_against_the_closing_pressure_and_keeps_the_load() -> None:
    gap = Gap(HEIGHT, 0.0)
    alone, found = trial_along(limited(4.0), PRESSURE, gap, CLOSING, CELLS, None, None, 0.5)
    np.testing.assert_allclose(alone, PRESSURE + 0.5 * (LEVEL - CLOSING) * CELLS)
    assert alone.sum() == pytest.approx(PRESSURE.sum())
    assert found.load == pytest.approx(PRESSURE.sum())
    assert found.slope == pytest.approx((HEIGHT * (alone - PRESSURE)).sum())
    # 0.5 Pa less 0.78
    assert found.cut
    last = replace(STEP, before=STEP.before.copy())
    both, found = trial_along(limited(4.0), PRESSURE, gap, CLOSING, CELLS, last, last, 0.25)
    way = LEVEL - KEPT * 1.25 / 4 - CLOSING + KEPT * BACK
    np.testing.assert_allclose(both, PRESSURE + 0.25 * way * CELLS)
    assert both is last.before
    assert both.sum() == pytest.approx(PRESSURE.sum())
    assert found.slope == pytest.approx(0.25 * (HEIGHT * way * CELLS).sum())
    assert not found.cut
    assert trial_along(limited(3.0), PRESSURE, gap, CLOSING, CELLS, None, None, 0.25)[1].cut


def test_compiled_passes_are_asked_for_the_sums_of_all_rows() -> None:
    """Of three rows: four cells with 1.5 to close; then seven sums."""
    kernels = Kernels(
        totals=(4 / 3, 0.5), trial=[(0, 2, 1, -3, 2), (0, 1, 2, 1, 0), (0, 1, 0, 0, 0)]
    )
    problem = limited(4.0, kernels)
    gap = Gap(HEIGHT, 0.0)
    trial, found = trial_along(problem, PRESSURE, gap, CLOSING, CELLS, None, None, 0.5)
    assert found == TrialSums(cut=False, load=4.0, slope=-2.0, bearing=3.0, largest=2.0)
    assert trial.shape == PRESSURE.shape
    assert kernels.asked["trial"][4:8] == pytest.approx((1.5 / 4, 0.0, 0.5, 4.0))
    # count, closed, downhill, along, over, ahead, shifted
    kernels.results |= {"products": (1.0, 2.0, 30.0, 4.0, 0.5, 1.0, 3.0), "trial": (1, 0, 0, 0, 0)}
    assert trial_along(problem, PRESSURE, gap, CLOSING, CELLS, STEP, STEP, 0.5)[1].cut
    # a level of 2, (12 - 2 * 1.5) / 4 of the step, which had shifted three cells by 9
    assert kernels.asked["trial"][4:6] == pytest.approx((2 - 2.25 * 9 / 3, 2.25))

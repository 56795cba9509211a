import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.integration.evolve import StepError, evolve
from tests.contactstudy.evolution.creeping import LOAD, SOLID, rolling_cylinder

EXACT = cs.ExactPeriodicity()
GRID = cs.Grid((64, 1), (0.6, 1.0))


@pytest.mark.parametrize("phase", [0.0, 0.7, np.pi / 2])
def test_steps_of_whole_periods_are_cut_and_their_error_is_known(phase: float) -> None:
    load = cs.SineLoad(LOAD, 0.7 * LOAD, 1.0, phase)
    scene = rolling_cylinder(SOLID, load)
    times = np.arange(0.0, 3.5)
    found = evolve(scene, GRID, EXACT, times=times)
    fine = evolve(scene, GRID, EXACT, times=np.linspace(0, 3, 193), step_error=StepError.NONE)
    for frame, true in zip(found.frames, fine.frames[::64], strict=True):
        wrong = np.abs(frame.pressure - true.pressure).sum() / true.pressure.sum()
        assert wrong <= frame.step_error + 1e-6


def test_a_frame_before_the_load_is_zero_keeps_its_own_error() -> None:
    scene = rolling_cylinder(SOLID, cs.SineLoad(0.0, LOAD, 0.5))
    found = evolve(scene, GRID, EXACT, times=[0.5, 1.0])
    fine = evolve(scene, GRID, EXACT, times=np.linspace(0, 0.5, 65), step_error=StepError.NONE)
    true = fine.frames[-1].pressure
    wrong = np.abs(found.frames[0].pressure - true).sum() / true.sum()
    assert 0 < wrong <= found.frames[0].step_error
    assert found.frames[1].step_error == 0

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.integration.evolve import ErrorEstimator, evolve
from tests.contactstudy.evolution.creeping import LOAD, RIGID, SOLID, rolling_cylinder

EXACT = cs.ExactPeriodicity()
GRID = cs.Grid((64, 1), (0.6, 1.0))


@pytest.mark.cases(1)
@pytest.mark.parametrize("phase", [0.7, 0.0, np.pi / 2])
def test_steps_of_whole_periods_are_cut_and_their_error_is_known(phase: float) -> None:
    load = cs.SineLoad(LOAD, 0.7 * LOAD, 1.0, phase)
    scene = rolling_cylinder(SOLID, load)
    times = np.arange(0.0, 3.5)
    found = evolve(scene, GRID, EXACT, times=times)
    fine = evolve(
        scene, GRID, EXACT, times=np.linspace(0, 3, 97), error_estimator=ErrorEstimator.NONE
    )
    for frame, true in zip(found.frames, fine.frames[::32], strict=True):
        wrong = np.abs(frame.pressure - true.pressure).sum() / true.pressure.sum()
        assert wrong <= frame.time_discretisation_error + 1e-6


def test_a_body_that_yields_keeps_the_dent_of_a_load_that_turns_between_the_instants() -> None:
    """Quarters of the period from a phase of 45 degrees on are 0.71 of the amplitude away from the mean."""
    body = cs.ElasticPlasticHalfSpace(1.0, 0.0, 0.02, 0.1)
    load = cs.SineLoad(LOAD, 0.9 * LOAD, 1.0, np.pi / 4)
    scene, grid = (
        replace(rolling_cylinder(SOLID, load), solids=(body, RIGID)),
        cs.Grid((16, 1), GRID.extent),
    )
    found, at_turns = (
        cs.solve(scene, grid, EXACT, times=times).quantities["dent_depth"].value
        for times in ([0.0, 1.0], [0.0, 1 / 8, 5 / 8, 1.0])
    )
    assert found == pytest.approx(at_turns, rel=0.05)


def test_a_frame_before_the_load_is_zero_keeps_its_own_error() -> None:
    scene = rolling_cylinder(SOLID, cs.SineLoad(0.0, LOAD, 0.5))
    found = evolve(scene, GRID, EXACT, times=[0.5, 1.0])
    fine = evolve(
        scene, GRID, EXACT, times=np.linspace(0, 0.5, 65), error_estimator=ErrorEstimator.NONE
    )
    true = fine.frames[-1].pressure
    wrong = np.abs(found.frames[0].pressure - true).sum() / true.sum()
    assert 0 < wrong <= found.frames[0].time_discretisation_error
    assert found.frames[1].time_discretisation_error == 0

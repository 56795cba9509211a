"""Plans of contacts that change in time."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from tests.contactstudy.evolution.creeping import LOAD, SOLID, rolling_cylinder


def test_a_plan_is_wide_enough_for_the_end_and_keeps_to_its_error() -> None:
    """The half-width after two times is known; both errors are those of the march itself."""
    history = cs.LoadHistory((0.0, 2.0), (LOAD, LOAD))
    scene = rolling_cylinder(SOLID, history)
    plan = cs.plan(scene, error=1e-2)
    assert plan.grid.extent[0] > 2 * 0.1516
    found = cs.evolve(scene, plan.grid, plan.padding, times=[0.0, 1.0, 2.0], error=1e-2)
    assert found.status is cs.Status.CONVERGED
    assert found.step_error <= 1e-2
    assert found.grid_error <= 2e-2  # the estimate is a bound, the plan's error is not
    assert plan.steps / 4 < found.steps < 4 * plan.steps
    assert any("solves" in reason for reason in plan.reasons)


def test_a_plan_makes_room_for_wear() -> None:
    """a^3 = 1.5 R k s P beyond Hertz's, as for a rigid cylinder."""
    scene = rolling_cylinder(
        replace(SOLID, relaxation=()),
        cs.LoadHistory((0.0, 1.0), (LOAD, LOAD)),
        wear=cs.Wear(2.0, 1.0),
    )
    plan = cs.plan(scene, error=2e-2)
    assert plan.grid.extent[0] / 2 > np.cbrt(1.5 * 2 * LOAD)


def test_rolling_takes_passes() -> None:
    plan = cs.plan(rolling_cylinder(SOLID, rolling=cs.Rolling(0.1)), error=1e-2)
    found = cs.solve_rolling(
        rolling_cylinder(SOLID, rolling=cs.Rolling(0.1)), plan.grid, plan.padding
    )
    assert found.settled.passes == pytest.approx(plan.steps, rel=0.8)
    assert found.solution.status is cs.Status.CONVERGED

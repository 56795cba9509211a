"""Plans of contacts that change in time."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.evolve import evolve
from contactstudy.evolution.rolling import solve_rolling
from contactstudy.planning.plan import plan_grid
from tests.contactstudy.evolution.creeping import LOAD, SOLID, rolling_cylinder


def test_a_plan_is_wide_enough_for_the_end_and_keeps_to_its_error() -> None:
    """The half-width after two times is known; both errors are those of the march itself."""
    history = cs.LoadHistory((0.0, 2.0), (LOAD, LOAD))
    scene = rolling_cylinder(SOLID, history)
    plan = cs.plan(scene, error=1e-2)
    assert plan.grid.extent[0] > 2 * 0.1516
    found = evolve(scene, plan.grid, plan.padding, times=[0.0, 1.0, 2.0], error=1e-2)
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
    found = solve_rolling(rolling_cylinder(SOLID, rolling=cs.Rolling(0.1)), plan.grid, plan.padding)
    assert found.lagged.passes == pytest.approx(plan.steps, abs=2)
    assert found.solution.status is cs.Status.CONVERGED


@pytest.mark.cases(1)
@pytest.mark.parametrize("ratio", [2.5, 4.0])
def test_a_plan_makes_room_for_what_yields(ratio: float) -> None:
    """Width and layers hold the plastic zone; steps are foreseen within a factor of three.

    A plan expects an error; its bound is up to a fifth more here.
    """
    elastic = cs.Scene(
        cs.LineLoad(1e6),
        (cs.HalfSpace(210e9, 0.3), cs.HalfSpace(np.inf, 0.0)),
        (cs.Cylinder(0.01),),
    )
    assert elastic.hertz is not None
    body = cs.ElasticPlasticHalfSpace(210e9, 0.3, elastic.hertz.peak_pressure / ratio, 2e9)
    history = cs.LoadHistory((0.0, 1.0), (0.0, 1e6))
    scene = replace(elastic, load=history, solids=(body, elastic.solids[1]))
    plan = cs.plan(scene, error=8e-2, times=(0.0, 1.0))
    assert plan.grid.cells[1] == 1
    assert plan.error <= 8e-2
    found = evolve(
        scene, plan.grid, plan.padding, times=(0.0, 1.0), error=8e-2, options=cs.SolveOptions(1e-6)
    )
    assert found.status is cs.Status.CONVERGED
    assert plan.steps / 3 < found.steps < 3 * plan.steps
    assert found.grid_error < 1.2 * 8e-2
    said = next(reason for reason in plan.reasons if reason.startswith("yield:"))
    layers = found.frames[-1].coupled_state["equivalent0"].shape[0]
    assert f"{ratio:.3g} times the lowest yield stress" in said
    assert 0.7 < int(said.split("some ")[1].split()[0]) / layers < 1.4


def test_a_finer_grid_of_what_yields_is_said_to_take_more() -> None:
    body = cs.ElasticPlasticHalfSpace(210e9, 0.3, 1e9)
    history = cs.LoadHistory((0.0, 1.0), (0.0, 1e6))
    scene = cs.Scene(history, (body, cs.HalfSpace(np.inf, 0.0)), (cs.Cylinder(0.01),))
    coarse, fine = (
        plan_grid(scene, error=1e-2, grid=cs.Grid((cells, 1), (1e-3, 1e-3))) for cells in (64, 128)
    )
    # operators are matrices over layers for every wave: twice of both
    assert 5 < fine.bytes / coarse.bytes < 9

"""Plans of contacts that change in time."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.evolve import evolve
from contactstudy.evolution.rolling import solve_rolling
from contactstudy.planning.in_time import extremes
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
    assert found.settled.passes == pytest.approx(plan.steps, rel=0.8)
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
    plan = cs.plan(scene, error=8e-2)
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
        cs.plan(scene, error=1e-2, grid=cs.Grid((cells, 1), (1e-3, 1e-3))) for cells in (64, 128)
    )
    # operators are matrices over layers for every wave: twice of both
    assert 5 < fine.bytes / coarse.bytes < 9


def test_a_plan_in_time_holds_its_fields_beside_one_solve() -> None:
    scene = rolling_cylinder(SOLID)
    plan, found = cs.plan(scene, error=1e-2), extremes(scene, 1e-2)
    one = cs.plan(found.narrow, error=1e-2, grid=plan.grid)
    assert plan.steps == found.steps
    assert plan.bytes == one.bytes + 8 * 10 * plan.grid.cells[0] * plan.grid.cells[1]
    assert plan.error == one.error


def test_the_numbers_of_a_plan_in_time_are_those_of_its_laws() -> None:
    """A cylinder with a = 0.1 at once; the body creeps with one term to 2.5 times its compliance."""
    error = 1e-2
    bodies = extremes(rolling_cylinder(SOLID), error)
    assert bodies.width == pytest.approx(2 * 1.2 * 0.1 * 2.5**0.5, rel=1e-12)
    assert bodies.steps == round(33 + 1.1 * error**-0.5)
    assert bodies.fields == 2 * 1 + 8
    assert bodies.narrow.hertz.half_width == pytest.approx(0.1, rel=1e-12)
    assert bodies.narrow.wear is bodies.narrow.rolling is None

    # relaxation times a hundred times apart: two decades more
    two = replace(SOLID, relaxation=((0.3, 0.1), (0.3, 10.0)))
    terms = sorted(time for _, time in two.creep.terms)
    decades = 1 + np.log10(terms[1] / terms[0])
    assert extremes(rolling_cylinder(two), error).steps == round(33 + 1.1 * decades * error**-0.5)
    assert extremes(rolling_cylinder(two), error).fields == 2 * 2 + 8

    # a fluid flows for as long as it is loaded: J = 1 + t
    fluid = cs.ViscoelasticHalfSpace(0.0, 0.0, ((1.0, 1.0),))
    flowing = extremes(rolling_cylinder(fluid, cs.LoadHistory((1.0, 4.0), (LOAD, LOAD))), error)
    assert flowing.width == pytest.approx(2 * 1.2 * 0.1 * 2, rel=1e-12)
    assert flowing.steps == round(33 + 1.1 * error**-0.5)
    assert flowing.fields == 2 * 1 + 8

    # worn until it is twice as wide: a^3 = 0.1^3 + 1.5 R k P t
    rate = 7 * 0.1**3 / (1.5 * LOAD)
    elastic = replace(SOLID, equilibrium_modulus=1.0, relaxation=())
    worn = extremes(
        rolling_cylinder(
            elastic, cs.LoadHistory((0.0, 2.0), (LOAD, LOAD)), wear=cs.Wear(rate, 0.5)
        ),
        error,
    )
    assert worn.width == pytest.approx(2 * 1.2 * 0.2, rel=1e-12)
    assert worn.steps == round(33 + 0.05 / error**1.9)

    rolling = extremes(rolling_cylinder(SOLID, rolling=cs.Rolling(0.1)), error)
    assert rolling.width == pytest.approx(2 * 1.2 * 0.1 * 2.5**0.5 * 1.5, rel=1e-12)
    assert (rolling.steps, rolling.fields) == (8 * 3.5, 4 * 8)


RIGID = cs.HalfSpace(np.inf, 0.3)
HELD = cs.LineLoad(0.02 * np.pi)
HISTORY = cs.LoadHistory((0.0, 2.0), (0.02 * np.pi, 0.02 * np.pi))


def rolled(body: cs.Body, load: object = HISTORY, **named: object) -> cs.Scene:
    """A cylinder of 4 m on a body of 2 Pa at once: a half-width of 0.4 m."""
    return cs.Scene(load, (body, RIGID), (cs.Cylinder(4.0),), **named)  # type: ignore[arg-type]


def test_laws_hold_of_any_radius_and_modulus() -> None:
    creeps = cs.ViscoelasticHalfSpace(0.8, 0.0, ((1.2, 0.4),))
    assert extremes(rolled(creeps), 0.01).width == pytest.approx(2 * 1.2 * 0.4 * 2.5**0.5)
    rolling = extremes(rolled(creeps, HELD, rolling=cs.Rolling(0.1)), 0.01)
    assert rolling.steps == 8 * 3.5
    # worn until it is twice as wide: a^3 = 0.4^3 + 1.5 R k P t
    elastic = cs.HalfSpace(2.0, 0.0)
    wear = cs.Wear(7 * 0.4**3 / (1.5 * 4 * 0.02 * np.pi * 2), 1.0)
    worn = extremes(rolled(elastic, wear=wear), 0.01)
    assert worn.width == pytest.approx(2 * 1.2 * 0.8)
    assert worn.steps == round(33 + 0.05 / 0.01**1.9)
    # a load without an end wears for no known time
    still = extremes(rolled(elastic, HELD, wear=wear), 0.01)
    assert (still.steps, still.width) == (1, pytest.approx(2 * 1.2 * 0.4))


@pytest.mark.parametrize("ratio", [1.5, 6.0])
def test_what_yields_takes_its_steps_and_its_width_where_that_is_larger(ratio: float) -> None:
    """The peak pressure is 0.1 Pa; the zone reaches 1.25 (0.62 + 0.07 r^2) half-widths."""
    body = cs.ElasticPlasticHalfSpace(2.0, 0.0, 0.1 / ratio)
    found = extremes(rolled(body), 0.02)
    assert found.plastic is not None
    assert found.plastic.ratio == pytest.approx(ratio)
    assert found.steps == 1 + found.plastic.steps(0.02)
    reach = 1.25 * (0.62 + 0.07 * ratio**2)
    assert found.width == pytest.approx(2 * 0.4 * max(1.2, reach))

import tracemalloc
from dataclasses import replace
from itertools import count

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.planning import pilot
from tests.contactstudy.evolution.creeping import LOAD, SOLID, rolling_cylinder
from tests.contactstudy.evolution.test_roll_repeatedly import scene as yielding_cylinder

EXACT = cs.ExactPeriodicity()
GRID = cs.Grid((24, 1), (0.6, 1.0))
WORN = rolling_cylinder(
    cs.HalfSpace(1.0, 0.0),
    rolling=cs.Rolling(0.1),
    wear=cs.Wear(1.0, speed=0.01, circumference=1.0),
)
KINDS = {
    "wear": (WORN, GRID, cs.TimeSteps((1.0, 20.0))),
    "rolling": (
        rolling_cylinder(
            SOLID, load=cs.LoadHistory((0.0, 100.0), (LOAD, 0.5 * LOAD)), rolling=cs.Rolling(0.1)
        ),
        GRID,
        cs.TimeSteps(np.linspace(0.0, 100.0, 3)),  # type: ignore[arg-type]
    ),
    "passes": (
        replace(yielding_cylinder(2.2), rolling=cs.Rolling(passes=12, distance=1.6)),
        cs.Grid((24, 1), (4.8, 1.0)),
        cs.TimeSteps(),
    ),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_pilot_ends_at_its_time_limit_and_forecasts_the_rest(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, grid, steps = KINDS[kind]
    solved: list[int] = []
    iterate = cs.PreconditionedCG.iterate

    def counted(*arguments: object, **named: object) -> cs.Iterate:
        solved.append(1)
        return iterate(*arguments, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(cs.PreconditionedCG, "iterate", counted)

    def counts(*, seconds_a_reading: float) -> tuple[int, int]:
        """Solves that a pilot makes, and those that it forecasts."""
        solved.clear()
        clock = count(0.0, seconds_a_reading)
        monkeypatch.setattr(pilot, "process_time", lambda: next(clock))
        _, solves = pilot.seconds_and_solves(scene, grid, EXACT, 1e-2, steps)
        return len(solved), solves

    made, all_solves = counts(seconds_a_reading=0.0)
    made_within_limit, forecast = counts(seconds_a_reading=5.0)
    assert made_within_limit < made / 2
    assert all_solves / 5 < forecast < 5 * all_solves  # the first steps of wear are short


@pytest.mark.whole
def test_a_plan_of_passes_has_room_for_what_they_leave_behind() -> None:
    scene = replace(yielding_cylinder(4.0), rolling=cs.Rolling(passes=1, distance=0.6))
    planned = cs.plan(scene, error=0.1)
    tracemalloc.start()
    found = cs.solve(scene, planned.grid, planned.padding)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.status is not cs.Status.YIELD_AT_EDGE
    assert peak / 3 < planned.bytes < 3 * peak


def test_the_solves_of_a_plan_are_those_of_the_steps_that_are_given() -> None:
    creep = rolling_cylinder(SOLID, cs.LoadHistory((0.0, 2.0), (LOAD, LOAD)))
    for named in ({"instants": 3}, {"times": (0.0, 0.1, 2.0), "error": 3e-4}):
        steps = cs.TimeSteps(**named)  # type: ignore[arg-type]
        found = cs.solve(creep, GRID, EXACT, times=steps)
        assert cs.plan(creep, grid=GRID, times=steps).solves == found.trajectory.solves


def test_the_steps_of_passes_grow_with_the_cells_of_the_plan() -> None:
    """Passes of 0.4 m roll by one cell a step: 8 steps each on cells of 5 cm."""
    scene = replace(yielding_cylinder(2.2), rolling=cs.Rolling(passes=3, distance=0.4))
    assert cs.plan(scene, grid=cs.Grid((96, 1), (4.8, 1.0))).solves == pytest.approx(24, abs=2)

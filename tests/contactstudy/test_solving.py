"""What `solve` reports, and the keywords that it takes for each kind of scene."""

from dataclasses import replace

import pytest

import contactstudy as cs
from contactstudy.domain.device import threads
from tests.conftest import STEEL
from tests.contactstudy.evolution.creeping import LOAD, SOLID, rolling_cylinder
from tests.contactstudy.evolution.test_roll_repeatedly import scene as yielding_cylinder
from tests.contactstudy.lubrication import scenes as films

EXACT = cs.ExactPeriodicity()
# A scene of each of these kinds, with its grid.
NARROW = cs.Grid((24, 1), (0.6, 1.0))
KINDS = {
    "creep": (rolling_cylinder(SOLID, load=cs.LoadHistory((-2.0, -1.0), (0.5 * LOAD, LOAD))), NARROW),
    "static": (films.DRY, films.grid(24, 1.2)),
    "rolling": (rolling_cylinder(SOLID, rolling=cs.Rolling(speed=0.1)), NARROW),
    "passes": (
        replace(yielding_cylinder(2.2), rolling=cs.Rolling(passes=2, distance=0.4)),
        cs.Grid((24, 1), (4.8, 1.0)),
    ),
    "film": (films.by_moes(20, 2), films.grid(64, 3.0)),
}


@pytest.mark.cases(5)
@pytest.mark.parametrize("kind", KINDS)
def test_a_solve_reports_its_progress_on_the_threads_of_its_device(kind: str) -> None:
    seen: list[tuple[cs.Progress, int]] = []
    cs.solve(*KINDS[kind], EXACT, device=cs.Cpu(threads=2), progress=lambda now: seen.append((now, threads())))
    fractions = [progress.fraction for progress, _ in seen]
    assert 0 <= min(fractions) < 1
    assert fractions[-1] == 1
    assert (kind == "rolling") == any("change of the gap" in progress.text for progress, _ in seen)
    assert {count for _, count in seen} == {2}
    assert threads() == 1


def test_an_elastic_contact_in_a_load_history_has_the_bounds_of_that_contact_alone() -> None:
    grid = cs.Grid((48, 1), (4e-4, 1e-4))
    history = cs.LoadHistory((0.0, 1.0), (1e5, 5e4))
    scene = cs.Scene(history, (STEEL, STEEL), (cs.Cylinder(0.01),))
    last = cs.solve(scene, grid, EXACT, times=[0.0, 1.0]).frames[-1].quantities
    alone = cs.solve(replace(scene, load=cs.LineLoad(5e4)), grid, EXACT).quantities
    for name in ("contact_area", "half_width", "mean_gap", "approach"):
        assert last[name].value == pytest.approx(alone[name].value, rel=1e-5)
        assert last[name].bound == pytest.approx(alone[name].bound, rel=0.1)


@pytest.mark.parametrize(
    ("name", "friction"), [("surface_tension", cs.Sliding(0.2)), ("largest_shear", cs.Fretting.cycle(0.4, 2e4))]
)
def test_a_number_at_an_edge_is_refined_for_where_it_is_named(name: str, friction: cs.Sliding | cs.Fretting) -> None:
    stress = (cs.SubsurfaceStress((0.0,)),) if name == "surface_tension" else ()
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01),), friction=friction, outputs=stress)
    named, plain = (cs.solve(scene, error=error) for error in ({name: 0.1}, 0.1))
    assert named.met
    assert named.grid.cells > plain.grid.cells


def test_a_pressure_of_another_load_is_scaled_and_said_and_one_of_another_extent_is_refused() -> None:
    scene, grid = films.DRY, films.grid(24, 1.2)
    before = cs.solve(scene, grid, EXACT)
    assert cs.solve(scene, grid, EXACT, start=before).note == before.note
    heavier = cs.solve(replace(scene, load=cs.LineLoad(1.2 * scene.largest_load)), grid, EXACT, start=before)
    assert "carried 0.833 times the load" in heavier.summary()
    planned = cs.solve(heavier.scene, error=0.1, start=cs.solve(scene, error=0.1))
    assert "carried 0.833 times the load" in planned.note
    with pytest.raises(cs.InvalidInput, match="is on a grid of"):
        cs.solve(scene, films.grid(24, 1.3), EXACT, start=before)


def test_a_grid_is_refined_from_that_of_a_start_unless_that_is_of_another_scene() -> None:
    before = cs.solve(films.DRY, error=0.01)
    seen: list[cs.Progress] = []
    again = cs.solve(films.DRY, error=0.01, start=before, progress=seen.append)
    assert {progress.grid for progress in seen} == {before.grid}
    assert "began with solve.start" in again.note
    wavy = replace(films.DRY, shapes=(*films.DRY.shapes, cs.Waviness(1e-8, along=1e-4)))
    assert "not one of this scene" in cs.solve(wavy, error=0.05, start=before).note


def test_an_evolution_says_that_its_bodies_are_too_small_for_half_spaces() -> None:
    soft = cs.HalfSpace(1e6, 0.3)
    scene = cs.Scene(cs.LoadHistory((0.0, 1.0), (500.0, 1000.0)), (soft, soft), (cs.Cylinder(0.01),))
    answer = cs.solve(scene, cs.Grid((24, 1), (0.015, 0.01)), EXACT)
    assert "half-space" in answer.accuracy
    assert answer.accuracy.startswith(answer.warnings[0].rstrip("."))

from dataclasses import replace
from pathlib import Path

import pytest

import contactstudy as cs
from contactstudy import TimeSteps
from studies.model.case import Case
from studies.scene_study.measures import measures
from studies.scene_study.study_of import study_of

OIL = Path(__file__).parents[3] / "examples" / "oil.toml"


def test_a_sweep_over_speed_has_a_grid_for_each_film() -> None:
    study = study_of(OIL, {"lubrication.mean_speed": "0.1:10:3:log m/s"})
    cases = [study.case_at({"lubrication_mean_speed": speed}) for speed in (0.1, 1.0, 10.0)]
    assert all(isinstance(case, Case) for case in cases)
    slow, medium, fast = (case.grid.extent[0] for case in cases)  # type: ignore[attr-defined]
    assert slow < medium < fast  # a thicker film needs a longer inlet


def test_what_is_recorded_of_a_film_is_that_of_its_contact() -> None:
    case = Case(cs.read_scene(OIL).scene, cs.Grid((160, 1), (1.2e-3, 1e-3)), cs.ExactPeriodicity())
    film = case.run()
    measured = measures(case, film)
    assert float(measured["central_film"]) == film.central_film
    assert float(measured["friction_coefficient"]) == film.friction
    assert float(measured["moes_film"]) == film.scales.expected_film * film.scales.film
    assert int(case.record(film)["solver_status"]) == list(cs.Status).index(film.status)
    estimate = film.error.central_film.total
    assert float(measured["central_film_estimate"]) == pytest.approx(estimate)
    assert float(measured["central_film_bound"]) == pytest.approx(estimate * film.central_film)


def test_a_film_that_changes_in_time_is_marched_at_every_point() -> None:
    oil = cs.read_scene(OIL)
    history = cs.SpeedHistory((0.0, 1e-4), (0.5, 1.0))
    scene = replace(oil.scene, lubrication=replace(oil.scene.lubrication, mean_speed=history))
    a = 1e-4
    file = cs.SceneFile(scene, grid=cs.Grid((64, 1), (10 * a, a)), time_steps=TimeSteps(instants=3))
    study = study_of(file, {"load.per_length": "80 N/mm,100 N/mm"})
    case = study.case_at({"load_per_length": 1e5})
    evolution = case.run(case.prepare())
    measured = study.measures(case, evolution)
    assert float(measured["final_central_film"]) == evolution.frames[-1].central_film > evolution.frames[0].central_film
    lowest = min(frame.minimum_film for frame in evolution.frames)
    assert float(measured["minimum_film"]) == lowest
    assert int(case.record(evolution)["steps"]) == evolution.films.steps

"""Sweeps of lubricated scenes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.io.document import TimeSteps
from studies.model import film_case
from studies.model.film_case import FilmCase, film_measures
from studies.scene_study.study_of import study_of

OIL = Path(__file__).parents[3] / "examples" / "oil.toml"


def test_a_sweep_over_speed_has_a_grid_for_each_film() -> None:
    study = study_of(OIL, {"lubrication.mean_speed": "0.1:10:3:log m/s"})
    cases = [study.scene_at({"lubrication_mean_speed": speed}) for speed in (0.1, 1.0, 10.0)]
    assert all(isinstance(case, FilmCase) for case in cases)
    widths = [case.grid.extent[0] for case in cases]  # type: ignore[attr-defined]
    assert widths == sorted(widths)


def test_what_is_recorded_of_a_film_is_that_of_its_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(film_case, "perf_counter", iter((10.0, 12.5)).__next__)
    scene = cs.read_scene(OIL).scene
    case = FilmCase(scene, cs.film_grid(scene, 2e-2), cs.ExactPeriodicity())
    solved = case.run()
    measured = film_measures(case, solved)
    contact = solved.contact
    assert float(measured["central_film"]) == contact.central_film
    assert float(measured["friction"]) == contact.friction
    assert int(case.record(solved)["solver_status"]) == 0
    estimate = cs.film_error(contact).central_film.total
    assert float(measured["central_film_estimate"]) == pytest.approx(estimate)
    assert float(measured["wall_time"]) == 2.5
    # one half of the width below half the film of Moes, the other above
    moes = contact.scales.expected_film * contact.scales.film
    film = np.where(case.grid.x < 0, 0.4, 0.6)[:, None] * moes
    monkeypatch.setattr(cs.LubricatedContact, "is_smooth", False)
    thin = film_measures(case, replace(solved, contact=replace(contact, film=film)))
    assert float(thin["moes_film"]) == moes
    share = case.grid.extent[0] / (4 * contact.scales.hertz.half_width)
    assert float(thin["thin_area"]) == pytest.approx(share)


def test_a_film_that_changes_in_time_is_marched_at_every_point() -> None:
    oil = cs.read_scene(OIL)
    assert oil.scene.lubrication is not None
    history = cs.SpeedHistory((0.0, 1e-4), (0.5, 1.0))
    scene = replace(oil.scene, lubrication=replace(oil.scene.lubrication, mean_speed=history))
    a = 1e-4
    file = cs.SceneFile(scene, grid=cs.Grid((64, 1), (10 * a, a)), time_steps=TimeSteps(instants=3))
    study = study_of(file, {"load.per_length": "80 N/mm,100 N/mm"})
    case = study.scene_at({"load_per_length": 1e5})
    march = case.run(case.prepare())
    assert isinstance(march, cs.FilmEvolution)
    measured = study.measures(case, march)
    assert float(measured["final_central_film"]) == march.central_film[-1]
    assert float(measured["lowest_film"]) == march.minimum_film.min()
    assert int(case.record(march)["steps"]) == march.steps

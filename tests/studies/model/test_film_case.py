"""Sweeps of lubricated scenes."""

from pathlib import Path

import pytest

import contactstudy as cs
from studies.model.film_case import FilmCase, film_measures
from studies.scene_study.study_of import study_of

OIL = Path(__file__).parents[3] / "examples" / "oil.toml"


def test_a_sweep_over_speed_has_a_grid_for_each_film() -> None:
    study = study_of(OIL, {"lubrication.mean_speed": "0.1:10:3:log m/s"})
    cases = [study.scene_at({"lubrication_mean_speed": speed}) for speed in (0.1, 1.0, 10.0)]
    assert all(isinstance(case, FilmCase) for case in cases)
    widths = [case.grid.extent[0] for case in cases]  # type: ignore[attr-defined]
    assert widths == sorted(widths)


def test_what_is_recorded_of_a_film_is_that_of_its_contact() -> None:
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

"""Lubricated scenes in files: read, written, planned, solved and labelled."""

from dataclasses import replace
from math import inf
from pathlib import Path

import pytest

import contactstudy as cs
from tests.contactstudy.lubrication.scenes import by_moes, grid

OIL = Path(__file__).parents[3] / "examples" / "oil.toml"


def test_a_file_names_the_lubricant_with_units_and_laws() -> None:
    lubrication = cs.read_scene(OIL).scene.lubrication
    assert lubrication == cs.Lubrication(
        cs.Lubricant(0.04, 2e-8, shear=cs.Eyring(5e6)), 1.0, slide_roll_ratio=0.1
    )


def test_a_lubricated_scene_reads_back_as_it_was_written(tmp_path: Path) -> None:
    scene = by_moes(20, 5)
    cs.write_scene(scene, tmp_path / "film.toml")
    assert cs.read_scene(tmp_path / "film.toml").scene == scene


def test_the_plan_of_a_file_reaches_its_error() -> None:
    described = cs.read_scene(OIL)
    planned = described.plan()
    assert planned.dimension == 1
    assert planned.error == 0.01
    contact = described.lubricate(planned)
    assert contact.status is cs.FilmStatus.CONVERGED
    assert contact.error is not None
    assert contact.error.central_film.total <= 0.01
    assert contact.error.minimum_film.total <= 0.01


def test_a_rough_plan_has_cells_for_its_waves_and_no_error() -> None:
    scene = by_moes(20, 5, cs.Waviness(1e-8, across=1e-4, along=5e-5))
    planned = cs.plan(scene)
    assert planned.dimension == 2
    assert planned.error == inf
    assert planned.grid.cell[0] <= 1e-4 / 8
    assert planned.grid.cell[1] <= 5e-5 / 8
    assert "not known beforehand" in " ".join(planned.warnings)
    with pytest.raises(cs.InvalidInput, match=r"contactstudy\.plan\(scene\)\.grid"):
        cs.solve_lubricated(scene, error=1e-2)


def test_a_load_that_changes_is_planned_at_its_largest() -> None:
    load = cs.LoadHistory((0.0, 1.0), (5e4, 1e5))
    assert cs.plan(replace(by_moes(20, 5), load=load)).grid == cs.plan(by_moes(20, 5)).grid


def test_a_dataset_has_the_film_its_errors_and_the_scene() -> None:
    contact = cs.solve_lubricated(by_moes(20, 5), grid(100, 4.5))
    dataset = replace(contact, error=cs.film_error(contact)).to_dataset()
    assert dataset["film"].dims == ("x", "y")
    assert float(dataset["central_film"]) == contact.central_film
    assert dataset["central_film_error_estimate"].dims == ("cause",)
    assert "[lubrication.lubricant]" in dataset.attrs["scene"]


def test_stress_below_the_surface_takes_pressure_and_friction() -> None:
    stress = cs.SubsurfaceStress(depths=(2e-5,))
    scene = replace(by_moes(20, 5, shear=cs.LimitingShear(0.1)), outputs=(stress,))
    assert scene.lubrication is not None
    still = replace(scene, lubrication=replace(scene.lubrication, slide_roll_ratio=0.0))
    dragged, plain = (
        cs.solve_lubricated(one, grid(100, 4.5)).to_dataset() for one in (scene, still)
    )
    assert dragged["von_mises"].dims == ("z", "x", "y")
    change = float((dragged["stress"] - plain["stress"]).sel(component="xz").sum())
    # shear that enters at the surface passes through every depth of a wide strip; z points into the body, and the stress
    # on a surface that faces -z is that on the film, against the body's motion
    assert change == pytest.approx(float(dragged["shear"].sum()), rel=0.1)

from dataclasses import replace
from math import inf
from pathlib import Path

import pytest

import contactstudy as cs
from contactstudy.answers.lubricated_contact import film_answer
from contactstudy.lubrication.solve_lubricated import solve_lubricated
from contactstudy.planning.plan import plan_grid
from tests.contactstudy.lubrication.scenes import by_moes, grid, with_motion


def test_the_plan_of_a_file_reaches_its_error() -> None:
    described = cs.read_scene(Path(__file__).parents[3] / "examples" / "oil.toml")
    planned = described.plan()
    assert planned.dimension == 1
    assert planned.error == 0.01
    contact = described.solve()
    assert contact.grid.length == planned.grid.length
    assert contact.status is cs.Status.CONVERGED
    assert contact.judged["friction_coefficient"].ratio <= 1
    assert contact.error.central_film.total <= 0.01
    assert contact.error.minimum_film.total <= 0.01


def test_a_rough_plan_has_cells_for_its_waves_and_no_error() -> None:
    scene = by_moes(20, 5, cs.Waviness(1e-8, across=1e-4, along=5e-5))
    planned = cs.plan(scene)
    assert planned.dimension == 2
    assert planned.error == inf
    assert planned.grid.cell_size[0] <= 1e-4 / 8
    assert planned.grid.cell_size[1] <= 5e-5 / 8
    assert "is not predicted" in " ".join(planned.warnings)


def test_a_load_that_changes_is_planned_at_its_largest() -> None:
    load = cs.LoadHistory((0.0, 1.0), (5e4, 1e5))
    scene = by_moes(20, 5)
    assert plan_grid(replace(scene, load=load)).grid == plan_grid(scene).grid


def test_stress_below_the_surface_takes_pressure_and_friction() -> None:
    stress = cs.SubsurfaceStress(depths=(2e-5,))
    scene = replace(by_moes(20, 5, shear=cs.LimitingShear(0.1)), outputs=(stress,))
    still = with_motion(scene, slide_roll_ratio=0.0)
    dragged, plain = (film_answer(solve_lubricated(one, grid(100, 4.5))).to_dataset() for one in (scene, still))
    assert dragged["von_mises"].dims == ("z", "x", "y")
    change = float((dragged["stress"] - plain["stress"]).sel(component="xz").sum())
    # shear that enters at the surface passes through every depth of a wide strip; z points into the body, and the stress
    # on a surface that faces -z is that on the film, against the body's motion
    assert change == pytest.approx(float(dragged["shear"].sum()), rel=0.1)


EVOLUTION = """
[load]
kind = "LoadHistory"
times = ["0 us", "50 us", "0.1 ms"]
per_length = ["100 N/mm", "100 N/mm", "120 N/mm"]
[[solids]]
material = "steel"
[[solids]]
material = "steel"
[[shapes]]
kind = "Cylinder"
radius = "10 mm"
[[shapes]]
kind = "MovingShape"
body = 1
shape = {kind = "Waviness", amplitude = "10 nm", across = "0.2 mm", along = "inf"}
[lubrication]
mean_speed = {times = ["0 us", "80 us"], mean_speed = ["100 mm/s", "1 m/s"]}
cavitation = {kind = "ElrodAdams"}
[lubrication.lubricant]
viscosity = "40 mPa*s"
pressure_viscosity = "20 1/GPa"
shear = {kind = "Eyring", reference = "5 MPa"}
[grid]
cells = [100, 1]
extent = ["1.2 mm", "1 mm"]
[time_steps]
instants = 3
error = 0.01
"""


def test_a_file_marches_a_film_with_histories_of_load_and_speed(tmp_path: Path) -> None:
    (tmp_path / "evolution.toml").write_text(EVOLUTION)
    described = cs.read_scene(tmp_path / "evolution.toml")
    lubrication = described.scene.lubrication
    assert lubrication.lubricant == cs.Lubricant(0.04, 2e-8, shear=cs.Eyring(5e6))
    assert lubrication.mean_speed == cs.SpeedHistory((0.0, 8e-5), (0.1, 1.0))
    every_step = replace(described, time_steps=cs.TimeSteps(error=0.01)).solve()
    assert len(every_step.times) == every_step.films.steps / 2 + 1  # each pair of steps
    assert every_step.times[-1] == 1e-4
    evolution = described.solve()
    assert evolution.times == pytest.approx([0, 5e-5, 1e-4])
    assert evolution.frames[-1].load_per_length == pytest.approx(1.2e5, rel=1e-5)
    speeds = evolution.to_dataset()["mean_speed"]
    assert speeds.dims == ("time",)
    assert speeds.values == pytest.approx([0.1, 0.6625, 1.0])

"""What a sweep of a scene records of each point."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
import studies
from contactstudy.io.scene_files.scene_schema import PlanSettings
from studies.engine.run import run
from studies.model.outcome import CaseStatus
from studies.scene_study.measures import measures
from tests.studies.conftest import quiet
from tests.studies.scene_study.conftest import SMOOTH, given

BODIES = (cs.HalfSpace(210e9, 0.3),) * 2


def swept(scene: cs.SceneFile | Path, vary: dict[str, object], out: Path) -> xr.Dataset:
    return run(studies.study_of(scene, vary), out, workers=0, log=quiet)


def test_a_scene_in_time_is_swept_with_the_steps_of_its_solve(smooth: Path, tmp_path: Path) -> None:
    wears = '[wear]\ncoefficient = 1e-16\nspeed = "20 mm/s"\n[time_steps]\nend = 1000\ninstants = 2\n'
    smooth.write_text(SMOOTH.replace("1e-2", "5e-2") + wears, encoding="utf-8")
    found = swept(smooth, {"load.per_length": "100 N/mm"}, tmp_path)
    single = cs.read_scene(smooth).solve().quantities["final_peak_pressure"]
    bound = float(found["final_peak_pressure_bound"][0])
    assert bound == pytest.approx(single.bound, rel=1e-3)
    assert abs(float(found["final_peak_pressure"][0]) - single.value) < bound + single.bound


def test_bodies_that_are_separated_are_a_result_and_a_load_that_no_pressure_carries_a_failure(tmp_path: Path) -> None:
    scene = cs.Scene(cs.Approach(1e-6), BODIES, (cs.Cylinder(0.01),))
    file = cs.SceneFile(scene, grid=cs.Grid((32, 1), (1e-3, 1e-3)), padding=cs.ExactPeriodicity())
    apart, pressed = swept(file, {"load.approach": [-1e-6, 1e-6]}, tmp_path)["contact_fraction"].values
    assert apart == 0 < pressed
    both = cs.ExactPeriodicity(), cs.ExactPeriodicity()
    flat = cs.Scene(cs.LineLoad(2e4), BODIES, (cs.Waviness(1e-7, across=1e-4),))
    file = cs.SceneFile(flat, grid=cs.Grid((24, 1), (1e-4, 1e-4)), padding=both)
    found = swept(file, {"hardness": [1e8, 1e9]}, tmp_path / "flat")
    assert found["case_status"].values.tolist() == [CaseStatus.FAILED, CaseStatus.OK]
    assert "NO_ADMISSIBLE_PRESSURE" in str(found["error"].values[0])
    assert np.isnan(found["peak_pressure"].values).tolist() == [True, False]


def test_a_sweep_keeps_the_errors_of_the_numbers_that_are_named(smooth: Path, tmp_path: Path) -> None:
    named = "{ peak_pressure = '0.2 %', contact_area = '50 %' }"
    smooth.write_text(SMOOTH.replace("1e-2", named), encoding="utf-8")
    found = swept(smooth, {"load.per_length": "80,100 N/mm"}, tmp_path)
    assert found["accuracy_met"].values.tolist() == [1.0, 1.0]
    assert (found["peak_pressure_bound"] <= 2e-3 * found["peak_pressure"]).all()
    # the bound of every other number may be any
    smooth.write_text(smooth.read_text(encoding="utf-8") + given(16, "0.3 mm"), encoding="utf-8")
    [case] = studies.study_of(smooth, {"load.per_length": "100 N/mm"}).cases()
    assert str(measures(case, case.run(case.prepare()))["above_request"].values) == "peak_pressure"


def test_areas_over_hertz_s_keep_to_their_bounds(smooth: Path) -> None:
    smooth.write_text(SMOOTH + given(46, "0.4 mm", "0.4 mm"), encoding="utf-8")
    [case] = studies.study_of(smooth, {"load.per_length": "100 N/mm"}).cases()
    found = measures(case, case.run(case.prepare()))
    fraction = 2 * case.scene.hertz.half_width / case.grid.extent[0]
    for name, value in (("contact_fraction", fraction), ("contact_area_over_hertz", 1.0)):
        assert abs(float(found[name]) - value) <= float(found[f"{name}_bound"]) < 0.1 * value


def test_an_approach_that_is_given_is_recorded_as_given(smooth: Path, tmp_path: Path) -> None:
    dataset = swept(smooth, {"load": [cs.Approach(1e-6), cs.Approach(2e-6)], "plan.error": [0.1]}, tmp_path)
    assert dataset["approach"].values.ravel().tolist() == [1e-6, 2e-6]
    # over that of the load which the approach takes
    width = 2 * cs.read_scene(smooth).scene.hertz.half_width  # type: ignore[union-attr]
    area = dataset["contact_area"] / dataset["contact_area_over_hertz"]
    np.testing.assert_allclose(area, width * np.sqrt(dataset["load"] / 1e5), rtol=1e-12)


def test_every_contact_is_measured_without_asking(rough: Path, tmp_path: Path) -> None:
    dataset = swept(rough, {"load.per_length": "20:100:5 N/mm"}, tmp_path)
    assert dataset["load_per_length"].attrs["units"] == "N m-1"
    names = (
        "load contact_area contact_fraction contact_perimeter peak_pressure mean_pressure approach stiffness "
        "mean_gap wall_time solver_status iterations residual pressure_l1_estimate case_status"
    )
    for name in names.split():
        assert dataset[name].dims == ("load_per_length",), name
        assert "long_name" in dataset[name].attrs, name
    # more load, more contact, nearer bodies
    for name, sign in (("contact_area", 1), ("approach", 1), ("mean_gap", -1)):
        assert (sign * dataset[name].diff("load_per_length") > 0).all()
    assert "per_length" in dataset.attrs["scene"]


@pytest.mark.parametrize("load", [cs.LineLoad(1.5e5), cs.TotalLoad(1.2e3)])
def test_a_sweep_of_rollers_holds_what_a_solve_of_each_says(load: cs.LineLoad | cs.TotalLoad, tmp_path: Path) -> None:
    """The load per length is that of the roller, and each has a grid of its own."""
    lengths = np.array([8e-3, 12e-3])
    first = cs.Scene(load, BODIES, (cs.Cylinder(5e-3), cs.FiniteLength(8e-3)))
    described = cs.SceneFile(first, plan_settings=PlanSettings(error=0.2))
    found = swept(described, {"shapes.1.length": list(lengths)}, tmp_path)
    alone = [
        cs.solve(replace(first, shapes=(first.shapes[0], cs.FiniteLength(length))), error=0.2) for length in lengths
    ]
    expected = load.total / lengths if isinstance(load, cs.TotalLoad) else np.full(2, load.per_length)
    np.testing.assert_allclose(found["load"], expected, rtol=1e-9)
    np.testing.assert_allclose(found["mean_pressure"] * found["contact_area"], expected * lengths, rtol=1e-9)
    for name in ("mean_pressure", "contact_area", "mean_gap"):
        of_solves = [answer.quantities[name].value for answer in alone]
        np.testing.assert_allclose(found[name], of_solves, rtol=0.15, err_msg=name)

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

LOADS = "20:100:9 N/mm"


def solved(path: Path, out: Path, loads: str = LOADS) -> xr.Dataset:
    return run(studies.study_of(path, {"load.per_length": loads}), out, workers=0, log=quiet)


def test_a_scene_in_time_is_swept_with_the_steps_of_its_solve(smooth: Path, tmp_path: Path) -> None:
    wears = '[wear]\ncoefficient = 1e-16\nspeed = "20 mm/s"\n[time_steps]\nend = 1000\ninstants = 2\n'
    smooth.write_text(SMOOTH.replace("1e-2", "5e-2") + wears, encoding="utf-8")
    swept = solved(smooth, tmp_path, "100 N/mm")
    single = cs.read_scene(smooth).solve().quantities["final_peak_pressure"]
    bound = float(swept["final_peak_pressure_bound"][0])
    assert bound == pytest.approx(single.bound, rel=1e-3)
    assert abs(float(swept["final_peak_pressure"][0]) - single.value) < bound + single.bound


def test_separated_bodies_are_a_result_of_a_sweep_and_no_failure(tmp_path: Path) -> None:
    steel = cs.HalfSpace(210e9, 0.3)
    scene = cs.Scene(cs.Approach(1e-6), (steel, steel), (cs.Cylinder(0.01),))
    file = cs.SceneFile(scene, grid=cs.Grid((32, 1), (1e-3, 1e-3)), padding=cs.ExactPeriodicity())
    study = studies.study_of(file, {"load.approach": [-1e-6, 1e-6]})
    apart, pressed = run(study, tmp_path, workers=0, log=quiet)["contact_fraction"].values
    assert apart == 0 < pressed


def test_a_sweep_keeps_the_errors_of_the_numbers_that_are_named(smooth: Path, tmp_path: Path) -> None:
    named = "{ peak_pressure = '0.2 %', contact_area = '50 %' }"
    smooth.write_text(SMOOTH.replace("1e-2", named), encoding="utf-8")
    swept = solved(smooth, tmp_path, "80,100 N/mm")
    assert swept["accuracy_met"].values.tolist() == [1.0, 1.0]
    assert (swept["peak_pressure_bound"] <= 2e-3 * swept["peak_pressure"]).all()
    # the bound of every other number may be any
    smooth.write_text(smooth.read_text(encoding="utf-8") + given(16, "0.3 mm"), encoding="utf-8")
    [case] = studies.study_of(smooth, {"load.per_length": "100 N/mm"}).cases()
    found = measures(case, case.run(case.prepare()))
    assert str(found["above_request"].values) == "peak_pressure"


def test_areas_over_hertz_s_keep_to_their_bounds(smooth: Path) -> None:
    smooth.write_text(SMOOTH + given(46, "0.4 mm", "0.4 mm"), encoding="utf-8")
    [case] = studies.study_of(smooth, {"load.per_length": "100 N/mm"}).cases()
    found = measures(case, case.run(case.prepare()))
    fraction = 2 * case.scene.hertz.half_width / case.grid.extent[0]
    for name, value in (("contact_fraction", fraction), ("contact_area_over_hertz", 1.0)):
        assert abs(float(found[name]) - value) <= float(found[f"{name}_bound"]) < 0.1 * value


def test_an_approach_that_is_given_is_recorded_as_given(smooth: Path, tmp_path: Path) -> None:
    loads = [cs.Approach(1e-6), cs.Approach(2e-6)]
    study = studies.study_of(smooth, {"load": loads, "plan.error": [0.1]})
    dataset = run(study, tmp_path, workers=0, log=quiet)
    assert dataset["approach"].values.ravel().tolist() == [1e-6, 2e-6]
    # over that of the load which the approach takes, to a cell at either end
    width = 2 * cs.read_scene(smooth).scene.hertz.half_width  # type: ignore[union-attr]
    area = dataset["contact_area"] / dataset["contact_area_over_hertz"]
    np.testing.assert_allclose(area, width * np.sqrt(dataset["load"] / 1e5), rtol=1e-12)


def test_every_contact_is_measured_without_asking(rough: Path, tmp_path: Path) -> None:
    dataset = solved(rough, tmp_path)
    assert dataset["load_per_length"].attrs["units"] == "N m-1"
    names = (
        "load contact_area contact_fraction contact_perimeter peak_pressure mean_pressure approach stiffness "
        "mean_gap wall_time solver_status iterations residual pressure_l1_estimate case_status"
    )
    for name in names.split():
        assert dataset[name].dims == ("load_per_length",), name
        assert "long_name" in dataset[name].attrs, name
    # more load, more contact, nearer bodies
    assert (dataset["contact_area"].diff("load_per_length") > 0).all()
    assert (dataset["approach"].diff("load_per_length") > 0).all()
    assert (dataset["mean_gap"].diff("load_per_length") < 0).all()
    fraction = dataset["contact_area"] / _width(dataset)
    np.testing.assert_allclose(dataset["contact_fraction"], fraction, rtol=1e-3)
    assert "planned once" in dataset.attrs["notes"]
    assert "per_length" in dataset.attrs["scene"]


def _width(dataset: xr.Dataset) -> float:
    """Of the grid, as the notes say it, to four digits."""
    return 1e-6 * float(dataset.attrs["notes"].split(" over ")[1].split(" µm ")[0])


@pytest.mark.parametrize("load", [cs.LineLoad(1.5e5), cs.TotalLoad(1.2e3)])
def test_a_sweep_of_rollers_holds_what_a_solve_of_each_says(load: cs.LineLoad | cs.TotalLoad, tmp_path: Path) -> None:
    """The load per length is that of the roller, and each has a grid of its own."""
    lengths = np.array([8e-3, 12e-3])
    steel = cs.HalfSpace(210e9, 0.3)
    first = cs.Scene(load, (steel, steel), (cs.Cylinder(5e-3), cs.FiniteLength(8e-3)))
    described = cs.SceneFile(first, plan_settings=PlanSettings(error=0.2))
    study = studies.study_of(described, {"shapes.1.length": list(lengths)})
    found = run(study, tmp_path, workers=0, log=quiet)
    alone = [
        cs.solve(replace(first, shapes=(first.shapes[0], cs.FiniteLength(length))), error=0.2) for length in lengths
    ]
    expected = load.total / lengths if isinstance(load, cs.TotalLoad) else load.per_length
    np.testing.assert_allclose(found["load"], np.broadcast_to(expected, 2), rtol=1e-9)
    carried = found["mean_pressure"] * found["contact_area"]
    np.testing.assert_allclose(carried, expected * lengths, rtol=1e-9)
    for name in ("mean_pressure", "contact_area", "mean_gap"):
        of_solves = [answer.quantities[name].value for answer in alone]
        np.testing.assert_allclose(found[name], of_solves, rtol=0.15, err_msg=name)


def test_a_load_that_no_pressure_carries_is_a_failed_point_without_numbers(tmp_path: Path) -> None:
    steel = cs.HalfSpace(210e9, 0.3)
    wave = cs.Waviness(1e-7, across=1e-4)
    both = cs.ExactPeriodicity(), cs.ExactPeriodicity()
    file = cs.SceneFile(
        cs.Scene(cs.LineLoad(2e4), (steel, steel), (wave,)),
        grid=cs.Grid((24, 1), (1e-4, 1e-4)),
        padding=both,
    )
    study = studies.study_of(file, {"hardness": [1e8, 1e9]})
    found = run(study, tmp_path, workers=0, log=quiet)
    assert found["case_status"].values.tolist() == [CaseStatus.FAILED, CaseStatus.OK]
    assert "NO_ADMISSIBLE_PRESSURE" in str(found["error"].values[0])
    for name in ("peak_pressure", "contact_area", "mean_gap", "approach"):
        assert np.isnan(found[name].values).tolist() == [True, False]

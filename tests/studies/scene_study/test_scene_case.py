from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
import studies
from contactstudy.accuracy.discretisation.cells import contact_perimeter
from contactstudy.io.scene_files.scene_schema import PlanSettings
from studies.engine.run import run
from studies.model.outcome import CaseStatus
from studies.scene_study.measures import measures, normal_stiffness
from tests.studies.conftest import quiet
from tests.studies.scene_study.conftest import SMOOTH, given

LOADS = "20:100:9 N/mm"


def solved(path: Path, out: Path, loads: str = LOADS) -> xr.Dataset:
    return run(studies.study_of(path, {"load.per_length": loads}), out, workers=0, log=quiet)


def test_a_scene_in_time_is_swept_with_the_steps_of_its_solve(smooth: Path, tmp_path: Path) -> None:
    wears = (
        '[wear]\ncoefficient = 1e-16\nspeed = "20 mm/s"\n[time_steps]\nend = 1000\ninstants = 2\n'
    )
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


def test_approach_and_stiffness_are_those_of_hertz(smooth: Path) -> None:
    study = studies.study_of(smooth, {"load.per_length": "50:100:3 N/mm", "plan.error": [1e-4]})
    for case in study.cases():
        hertz = case.scene.hertz
        found = measures(case, case.run(case.prepare()))
        modulus, load = np.pi * hertz.contact_modulus, hertz.load_per_length
        # Johnson (1985), eq. 4.45 counted from the datum: both bodies move by the logarithm of the distance
        turns = np.log(2 * 2 * hertz.radius / hertz.half_width)
        approach = load / modulus * (2 * turns + 1)
        stiffness = modulus / (2 * turns)
        # the grid's error is 1e-4 in L1; the mean of half a cell's error in the half-width stays below 1 %
        assert float(found["approach"].values) == pytest.approx(approach, rel=1e-2)
        assert float(found["stiffness"].values) == pytest.approx(stiffness, rel=1e-2)
        area = 2 * hertz.half_width
        assert float(found["contact_area"].values) == pytest.approx(area, rel=2 / 32)
        assert float(found["mean_pressure"].values) == pytest.approx(
            load / float(found["contact_area"].values), rel=1e-12
        )


def test_stiffness_is_the_slope_of_the_load_over_the_approach(rough: Path) -> None:
    # no cell changes sides between loads this near, but for a few: differences of 1e-3 in the load
    study = studies.study_of(rough, {"load.per_length": [9.99e4, 1e5, 1.001e5]})
    found = [measures(case, case.run(case.prepare())) for case in study.cases()]
    load, approach = ([float(one[name].values) for one in found] for name in ("load", "approach"))
    slope = (load[2] - load[0]) / (approach[2] - approach[0])
    # the slope of a rough contact jumps with each cell that comes in, some 1 in 100 of those there are
    assert float(found[1]["stiffness"].values) == pytest.approx(slope, rel=3e-2)


def test_the_load_of_an_adhesive_contact_is_the_pressure_less_the_attraction(
    tmp_path: Path,
) -> None:
    solids = cs.HalfSpace(1e6, 0.49), cs.HalfSpace(np.inf, 0.3)
    scene = cs.Scene(
        cs.LineLoad(2.0), solids, (cs.Cylinder(0.01),), adhesion=cs.Adhesion(0.05, 1e-5)
    )
    file = cs.SceneFile(scene, grid=cs.Grid((128, 1), (6e-3, 1e-3)), padding=cs.ExactPeriodicity())
    [case] = studies.study_of(file, {"load.per_length": [2.0]}).cases()
    found, single = (
        measures(case, case.run(case.prepare())),
        cs.solve(scene, file.grid, file.padding),
    )
    assert float(found["load"].values) == pytest.approx(2.0, rel=1e-6)
    assert float(found["approach"].values) == pytest.approx(single.approach, rel=1e-6)


@pytest.mark.parametrize("law", ["exponential", "dugdale"])
@pytest.mark.parametrize("load", [-1.0, 1.0])
def test_the_stiffness_of_an_adhesive_contact_counts_how_the_attraction_changes(
    law: str, load: float
) -> None:
    """It is the slope of the load over the approach, which falls as pull-off comes near."""
    solids = cs.HalfSpace(1e6, 0.49), cs.HalfSpace(np.inf, 0.3)
    adhesion = cs.Adhesion(0.05, 1e-5, law, branch="from full contact")
    scene = cs.Scene(cs.LineLoad(load), solids, (cs.Cylinder(0.01),), adhesion=adhesion)
    grid, step = cs.Grid((256, 1), (6e-3, 1e-3)), 2e-3
    before, here, after = (
        cs.solve(replace(scene, load=cs.LineLoad(at)), grid, cs.ExactPeriodicity(), tolerance=1e-9)
        for at in (load - step, load, load + step)
    )
    slope = 2 * step / (after.approach - before.approach)
    # differences are first order in the cells that come in
    assert normal_stiffness(here) == pytest.approx(slope, rel=5e-3)
    rigid = replace(here, adhesion=None)
    assert normal_stiffness(rigid) > 1.01 * slope


@pytest.mark.parametrize("cells", [46, 73])
def test_stiffness_and_area_on_coarse_cells_keep_to_their_bounds(smooth: Path, cells: int) -> None:
    smooth.write_text(SMOOTH + given(cells, "0.4 mm", "0.4 mm"), encoding="utf-8")
    [case] = studies.study_of(smooth, {"load.per_length": "100 N/mm"}).cases()
    hertz, found = case.scene.hertz, measures(case, case.run(case.prepare()))
    modulus = np.pi * hertz.contact_modulus
    true = {
        "stiffness": modulus / (2 * np.log(2 * 2 * hertz.radius / hertz.half_width)),
        "contact_fraction": 2 * hertz.half_width / case.grid.extent[0],
        "contact_area_over_hertz": 1.0,
    }
    for name, value in true.items():
        bound = float(found[f"{name}_bound"])
        assert abs(float(found[name]) - value) <= bound < 0.1 * value


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


def test_stress_is_recorded_where_a_scene_names_it(smooth: Path, tmp_path: Path) -> None:
    stress = '[[outputs]]\nkind = "SubsurfaceStress"\ndepths = ["40 um", "80 um", "120 um"]\n'
    smooth.write_text(SMOOTH + stress, encoding="utf-8")
    dataset = solved(smooth, tmp_path, "100 N/mm,200 N/mm")
    # 0.56 of the peak pressure at 0.786 half-widths of 105 um (Johnson 1985, fig. 4.2), the nearest depth named
    assert float(dataset["largest_von_mises_depth"][0]) == 80e-6
    ratio = float((dataset["largest_von_mises"] / dataset["peak_pressure"])[0])
    assert ratio == pytest.approx(0.557, abs=0.01)


GRID = cs.Grid((4, 5), (4 * 2.0, 5 * 3.0))  # a cell is 2 m across and 3 m along

EXACT, FREE = cs.ExactPeriodicity(), cs.ZeroPadding()


@pytest.mark.parametrize(
    ("paddings", "round_the_ends"),
    [
        (None, 0), ((FREE, FREE), 0), ((EXACT, FREE), 3), ((FREE, EXACT), 4), ((EXACT, EXACT), 7),
        ((FREE, cs.DuplicatedPadding()), 4),
    ],
)  # fmt: skip
def test_a_perimeter_counts_the_edges_of_cells_round_the_ends_that_repeat(
    paddings: cs.Paddings | None, round_the_ends: float
) -> None:
    """Two cells in the corner, one behind the other along x, and one alone in the middle."""
    touching = np.zeros(GRID.cells, dtype=bool)
    touching[0, 0] = touching[1, 0] = touching[2, 3] = True
    # along x an edge is 3 m: one behind the two, and two of the one; along y it is 2 m: two and two
    assert contact_perimeter(touching, GRID, paddings) == 3 * 3 + 2 * 4 + round_the_ends


@pytest.mark.parametrize("load", [cs.LineLoad(1.5e5), cs.TotalLoad(1.2e3)])
def test_a_sweep_of_rollers_holds_what_a_solve_of_each_says(
    load: cs.LineLoad | cs.TotalLoad, tmp_path: Path
) -> None:
    """The load per length is that of the roller, and each has a grid of its own."""
    lengths = np.array([8e-3, 12e-3])
    steel = cs.HalfSpace(210e9, 0.3)
    first = cs.Scene(load, (steel, steel), (cs.Cylinder(5e-3), cs.FiniteLength(8e-3)))
    described = cs.SceneFile(first, plan_settings=PlanSettings(error=0.2))
    study = studies.study_of(described, {"shapes.1.length": list(lengths)})
    found = run(study, tmp_path, workers=0, log=quiet)
    alone = [
        cs.solve(replace(first, shapes=(first.shapes[0], cs.FiniteLength(length))), error=0.2)
        for length in lengths
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

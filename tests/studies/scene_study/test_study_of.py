"""The study of a scene: the axes of its fields, and what its cases have in common."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
import studies
from contactstudy import InvalidInput
from contactstudy.planning.planned import memory
from studies.model.case import Case
from studies.scene_study import study_of as grids
from tests.studies.scene_study.conftest import CYLINDER, ROUGH, SMOOTH, STEEL, given


def scenes(study: studies.Study) -> list[Case]:
    return [case for case in study.cases() if isinstance(case, Case)]


def shape(case: Case, number: int = 1) -> Any:
    return case.scene.shapes[number]


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("field", "values", "expected"),
    [
        ("load.per_length", "50:400:8 N/mm", [5e4 * k for k in range(1, 9)]),
        ("load.per_length", [1e5, 5e4], [5e4, 1e5]),
        ("radius", "0.01,20 mm,0.03", [0.01, 0.02, 0.03]),
        ("solids.1.youngs_modulus", "70 GPa,inf", ["70000000000", "inf"]),
        ("hardness", "2 GPa,4 GPa", [2e9, 4e9]),
        ("plan.error", "half_width = 2 %,half_width = 3 %", ["half_width = 2 %", "half_width = 3 %"]),
        ("period", "0.1 mm,0.2 mm", [1e-4, 2e-4]),
        ("solve.max_iterations", "3:9:3", [3, 6, 9]),
        ("padding", "ExactPeriodicity,DuplicatedPadding", ["ExactPeriodicity", "DuplicatedPadding"]),
    ],
)
def test_every_field_is_an_axis_in_si_units(smooth: Path, field: str, values: object, expected: list[object]) -> None:
    study = studies.study_of(smooth, {field: values})
    assert list(study.axes[0].values) == expected
    assert len(set(study.cases())) == len(expected)
    # names have no unit in a file, so that it stands in the long name
    assert study.axes[0].long_name.endswith(" [Pa]") == ("inf" in expected)


def test_values_reach_the_case_that_is_solved(smooth: Path) -> None:
    crown = '[[shapes]]\nkind = "Crown"\nend_drop = "5 um"\nlength = "10 mm"\n'
    by_name = SMOOTH.replace(STEEL, '[[solids]]\nmaterial = "steel"\n', 1)
    smooth.write_text(by_name + crown + given(32, "0.4 mm", "0.2 mm"), encoding="utf-8")
    varied = {
        "end_drop": "10 um",
        "solids.0.material": "bronze",
        "padding": '{kind="Superposition", images=3}',
        "tolerance": "1e-5",
        "grid.cells": "[32, 1],[64, 1]",
        "period": "0.2 mm,0.4 mm",
    }
    cases = scenes(studies.study_of(smooth, varied))
    assert {(case.grid.cells[0], case.grid.length) for case in cases} == {
        (32, 2e-4), (64, 2e-4), (32, 4e-4), (64, 4e-4)
    }  # fmt: skip
    for case in cases:
        assert shape(case).radius == pytest.approx((10e-3 / 2) ** 2 / (2 * 10e-6), rel=1e-2)
        assert case.scene.solids[0].youngs_modulus != case.scene.solids[1].youngs_modulus  # type: ignore[attr-defined]
        assert (case.padding, case.options) == (cs.Superposition(3), cs.SolveOptions(1e-5))


def test_values_of_python_are_varied_like_those_of_files(smooth: Path) -> None:
    ramp = np.linspace(0, 1e-8, 24).reshape(8, 3)
    rough = [cs.MeasuredSurface(factor * ramp, (4e-4, 2e-4)) for factor in (1, 2)]
    history = cs.LoadHistory((0.0, 1.0), (0.0, 1e5))
    scene = replace(cs.read_scene(smooth).scene, shapes=(cs.Cylinder(0.01), rough[0]), load=history, hardness=3e9)
    given = cs.SceneFile(scene, grid=cs.Grid((8, 3), (4e-4, 2e-4)))
    study = studies.study_of(given, {"shapes.1": rough, "load.per_length": np.array([[0, 1e5], [0, 2e5]])})
    assert study.axes[0].values == ("surface 0", "surface 1")
    assert {case.scene.load.per_length[1] for case in scenes(study)} == {1e5, 2e5}  # type: ignore[attr-defined]
    assert {case.scene.hardness for case in scenes(study)} == {3e9}
    with pytest.raises(InvalidInput, match="unknown key 'heights'"):
        studies.study_of(given, {"shapes.1.heights": [ramp]})


def test_what_a_file_varies_stays_for_fields_that_are_not_named(smooth: Path) -> None:
    own = '[vary]\nload.per_length = "50:100:3 N/mm"\nshapes.0.radius = "8,10 mm"\n'
    smooth.write_text(f"{SMOOTH}{own}", encoding="utf-8")
    assert [axis.values for axis in studies.study_of(smooth).axes] == [(8e-3, 1e-2), (5e4, 7.5e4, 1e5)]
    assert [axis.values for axis in studies.study_of(smooth, {"radius": [5e-3]}).axes] == [(5e-3,), (5e4, 7.5e4, 1e5)]
    assert [axis.values for axis in studies.study_of(smooth, [{"radius": [5e-3]}]).axes] == [(5e-3,)]


def test_fields_of_one_group_change_together(smooth: Path) -> None:
    study = studies.study_of(
        smooth, [{"radius": "20 mm,10 mm", "load.per_length": "80 N/mm,40 N/mm"}, {"plan.error": [0.1]}]
    )
    pairs = {(shape(case, 0).radius, case.scene.load.per_length) for case in scenes(study)}
    assert pairs == {(0.02, 8e4), (0.01, 4e4)}
    assert "along shapes_0_radius: load.per_length = 80000.0, 40000.0" in study.notes
    with pytest.raises(InvalidInput, match=r"2, 1 values of shapes\.0\.radius"):
        studies.study_of(smooth, [{"radius": "20 mm,10 mm", "load.per_length": "80 N/mm"}])


def test_the_fields_of_a_part_are_set_in_every_order(smooth: Path) -> None:
    file = replace(cs.read_scene(smooth), padding=cs.Superposition(6))
    kinds = cs.Superposition, cs.CircularSuperposition
    images, padding = {"images": [1, 2]}, {"padding": [kind(6) for kind in kinds]}
    for vary in (images | padding, padding | images):
        found = {case.padding for case in scenes(studies.study_of(file, vary))}
        assert found == {kind(n) for kind in kinds for n in (1, 2)}
    [none] = scenes(studies.study_of(file, {"padding": "none"}))
    assert none.padding == cs.ExactPeriodicity()


def test_the_axes_that_a_person_writes_twice_or_wrongly_are_named(rough: Path) -> None:
    for vary, said in (
        ({"load": "50 N/mm"}, "load is '50 N/mm': give it as load.per_length"),
        ({"load.per_lenght": "50 N/mm"}, "did you mean"),
        ({"load.per_length": "50 MPa"}, "a load per length"),
        ({"load.per_length": "50 N/mm,"}, "lacks a value"),
        ({"load.per_length": "0:400:3:log N/mm"}, "above 0"),
        ({"load.per_length": "1 N/m:2 kN/m:3"}, "has the units"),
        ({"load.per_length": "50 N/mm,100,200 N/mm"}, "some have none"),
        ({"shapes.2.rms": "1 um"}, "0 Cylinder, 1 Roughness"),
        ({"shapes.0.rms": "1 um"}, r"shapes\[0\]: 'rms' is a key of Roughness: give that kind, or choose from radius"),
        ({"friction": "Sliding"}, r"friction\.coefficient: it is missing"),
        ({"images": [1], "padding": [cs.ExactPeriodicity()]}, "'images' is a key of Superposition: give that kind"),
        ({"grid.cells": "48"}, r"grid.cells is 48: give \[a whole number of at least 2, "),
        ({"surfaces": "*.x3p"}, "MeasuredSurface"),
        ({"plan.error": "0.1:0.2:1000001"}, "plan.error has 1000001 values, more than 1000000: give fewer"),
        ({}, "has nothing to vary"),
    ):
        with pytest.raises(cs.InvalidInput, match=said):
            studies.study_of(rough, vary)


@pytest.mark.whole
def test_one_rough_surface_and_one_grid_for_all_loads(rough: Path) -> None:
    study = studies.study_of(rough, {"load.per_length": "20:100:3 N/mm", "shapes.1.rms": "0.1 um,0.2 um"})
    cases = scenes(study)
    assert len({case.grid for case in cases}) == 1
    ((across, along),) = {shape(case).extent for case in cases}
    width, length = cases[0].grid.extent
    assert across >= width
    assert along == length
    first, last = (shape(case).gap(case.grid) for case in (cases[0], cases[-1]))
    # the same surface, twice as high
    np.testing.assert_allclose(last, 2 * first, rtol=1e-12)
    said = " ".join(study.notes)
    assert "planned once for 6 points" in said
    assert "random surfaces have the extent" in said


def test_a_finer_grid_shows_the_same_surface_whose_own_extent_is_kept(rough: Path) -> None:
    cases = scenes(studies.study_of(rough, {"plan.error": "0.05,0.2"}))
    assert len({case.grid for case in cases}) == 2
    assert len({shape(case) for case in cases}) == 1
    rough.write_text(ROUGH.replace("seed = 3", 'seed = 3\nextent = ["0.3 mm", "0.24 mm"]'), encoding="utf-8")
    study = studies.study_of(rough, {"load.per_length": "20,100 N/mm"})
    assert {shape(case).extent for case in scenes(study)} == {(3e-4, 2.4e-4)}
    assert "random surfaces" not in " ".join(study.notes)


def test_a_common_grid_fits_the_machine(rough: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    vary = {"load.per_length": "20,100 N/mm"}
    padding = cs.ExactPeriodicity()
    needed = memory(scenes(studies.study_of(rough, vary))[0].grid, padding)
    monkeypatch.setattr(grids, "available_bytes", lambda: needed)
    study = studies.study_of(rough, vary)
    (grid,) = {case.grid for case in scenes(study)}
    assert memory(grid, padding) <= 0.8 * needed
    assert "it is the finest that fits" in " ".join(study.notes)


def measured(scene_file: Path, heights: np.ndarray, width: float) -> cs.Scene:
    extent = (width, width / heights.shape[0] * heights.shape[1])
    scene = cs.read_scene(scene_file).scene
    surface = cs.MeasuredSurface(heights, extent, seam=cs.Tapered())
    return replace(scene, shapes=(*scene.shapes, surface))


def test_a_common_grid_is_no_wider_than_the_narrowest_measured_surface(smooth: Path) -> None:
    heights = 1e-9 * np.random.default_rng(0).standard_normal((60, 8))
    rough = measured(smooth, heights, 1e-3)
    surfaces = [cs.MeasuredSurface(heights, (width, 1e-4)) for width in (1e-3, 2.25e-4)]
    study = studies.study_of(rough, {"shapes.1": surfaces, "plan.error": [0.3]})
    assert {case.grid.extent[0] for case in scenes(study)} == {2.25e-4}
    assert "but a measured surface is 225 µm wide" in " ".join(study.notes)
    wide = cs.SceneFile(rough, grid=cs.Grid((32, 32), (4e-3, 1e-4)))
    with pytest.raises(cs.InvalidInput, match="give a narrower grid"):
        studies.study_of(wide, {"load.per_length": [1e4, 2e4]})
    # but where the surface repeats across
    mirrored = replace(rough, shapes=(rough.shapes[0], replace(surfaces[0], seam_across=cs.Mirrored())))
    repeats = cs.SceneFile(mirrored, grid=cs.Grid((32, 8), (2e-3, 1e-4)))
    assert len(studies.study_of(repeats, {"load.per_length": [1e4, 2e4]}).cases()) == 2


def test_tiles_of_a_surface_are_an_axis(smooth: Path) -> None:
    heights = np.random.default_rng(0).standard_normal((40, 60)) * 1e-8
    study = studies.study_of(measured(smooth, heights, 1e-3), {"tiles": "2x3"})
    assert study.axes[0].values == (0, 1, 2, 3, 4, 5)
    parts = [shape(case).heights for case in scenes(study)]
    np.testing.assert_array_equal(np.block([parts[:3], parts[3:]]), heights)
    # heights have the sizes of the surface whose place they take
    study = studies.study_of(measured(smooth, heights, 1e-3), {"surfaces": [heights, 2 * heights]})
    assert {shape(case).extent for case in scenes(study)} == {(1e-3, 1.5e-3)}


def test_a_surface_is_as_measured_cut_or_turned_whatever_the_scene_has(smooth: Path) -> None:
    measured = cs.MeasuredSurface(np.arange(24.0).reshape(4, 6) * 1e-9, extent=(1e-3, 2e-3))
    upper = cs.Tile((2, 1), 1)
    scene = cs.read_scene(smooth).scene
    file = cs.SceneFile(replace(scene, shapes=(*scene.shapes, measured.turned())), grid=cs.Grid((8, 8), (1e-4, 1e-4)))
    for key, value, wanted in (("turn", "none", measured), ("tile", upper, measured.cut(upper).turned())):
        [found] = [shape(case) for case in scenes(studies.study_of(file, {f"shapes.1.{key}": [value]}))]
        assert (found, found.is_turned) == (wanted, wanted.is_turned)


def test_surfaces_are_an_axis_of_names(smooth: Path, tmp_path: Path) -> None:
    folder = tmp_path / "measured"
    folder.mkdir()
    for name in ("b", "a"):
        heights = np.random.default_rng(ord(name)).standard_normal((40, 20)) * 1e-8
        cs.MeasuredSurface(heights, extent=(1e-3, 5e-4)).write(folder / f"{name}.nc")
    surface = '[[shapes]]\nkind = "MeasuredSurface"\nfile = "measured/a.nc"\nseam_across = "Mirrored"\n'
    smooth.write_text(SMOOTH + surface, encoding="utf-8")
    study = studies.study_of(smooth, {"surfaces": "measured/*.nc"})
    assert study.axes[0].values == ("a.nc", "b.nc")
    surfaces = [shape(case) for case in scenes(study)]
    assert len({surface.digest for surface in surfaces}) == 2
    assert {surface.seam_across for surface in surfaces} == {cs.Mirrored()}


RUBBER = f"""{CYLINDER}{given(32, "8 mm")}[[solids]]
kind = "ViscoelasticHalfSpace"
equilibrium_modulus = "1 MPa"
poisson_ratio = 0.5
relaxation = [["2 MPa", "0.1 s"]]
[[solids]]
youngs_modulus = inf
poisson_ratio = 0.3
[load]
per_length = "500 N/m"
[rolling]
speed = "1 mm/s"
"""


def test_a_scene_that_rolls_is_swept(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(RUBBER)
    study = studies.study_of(tmp_path / "scene.toml", {"rolling.speed": "1,10 mm/s"})
    slow, fast = studies.run(study, tmp_path, workers=0, log=lambda _: None)["rolling_resistance"].values
    assert study.axes[0].units == "m/s"
    assert 0 < slow != fast > 0

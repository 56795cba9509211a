"""A study from a scene: any field varied, one grid and one surface for all points."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
import studies
from studies.scene_study.scene_case import SceneCase


def scenes(study: studies.Study) -> list[SceneCase]:
    return [case for case in study.cases() if isinstance(case, SceneCase)]


@pytest.mark.parametrize(
    ("field", "values", "expected"),
    [
        ("load.per_length", "50 N/mm,100 N/mm", [5e4, 1e5]),
        ("load.per_length", "50,100 N/mm", [5e4, 1e5]),
        ("load.per_length", "50:400:8 N/mm", [5e4 * k for k in range(1, 9)]),
        ("load.per_length", "1 N/mm:100 N/mm:3:log", [1e3, 1e4, 1e5]),
        ("load.per_length", [1e5, 5e4], [5e4, 1e5]),
        ("shapes.0.radius", "10 mm, 2 cm", [0.01, 0.02]),
        ("radius", "10 mm, 2 cm", [0.01, 0.02]),
        ("solids.1.youngs_modulus", "70 GPa,inf", ["70000000000", "inf"]),
        ("hardness", "2 GPa,4 GPa", [2e9, 4e9]),
        ("tolerance", "1e-4,1e-6", [1e-6, 1e-4]),
        ("plan.error", [0.01, 1e-4], [1e-4, 0.01]),
        ("period", "0.1 mm,0.2 mm", [1e-4, 2e-4]),
        ("solve.max_iterations", "3:9:3", [3, 6, 9]),
        ("precision", "single,double", ["single", "double"]),
        ("solver", "PolonskyKeer,PreconditionedCG", ["PolonskyKeer", "PreconditionedCG"]),
        (
            "padding",
            "ExactPeriodicity,DuplicatedPadding",
            ["ExactPeriodicity", "DuplicatedPadding"],
        ),
    ],
)
def test_every_field_is_an_axis_in_si_units(
    smooth: Path, field: str, values: object, expected: list[object]
) -> None:
    study = studies.Study.of(smooth, {field: values})
    assert list(study.points[0].values) == expected
    assert len(set(study.cases())) == len(expected)


def test_values_reach_the_case_that_is_solved(smooth: Path) -> None:
    varied = {
        "load.per_length": "20 N/mm,40 N/mm",
        "padding": '{kind="Superposition", images=3}',
        "tolerance": "1e-5",
        "precision": "single",
    }
    for case in scenes(studies.Study.of(smooth, varied)):
        assert case.scene.load.per_length in (2e4, 4e4)
        assert case.padding == cs.Superposition(3)
        assert (case.tolerance, case.precision) == (1e-5, cs.Precision.SINGLE)


def test_a_grid_that_is_given_is_kept_and_its_fields_vary(smooth: Path) -> None:
    smooth.write_text(
        smooth.read_text(encoding="utf-8")
        + '\n[grid]\ncells = [32, 1]\nextent = ["0.4 mm", "0.2 mm"]\n',
        encoding="utf-8",
    )
    varied = {"grid.cells": "[32, 1],[64, 1]", "period": "0.2 mm,0.4 mm"}
    found = {
        (case.grid.cells[0], case.grid.period) for case in scenes(studies.Study.of(smooth, varied))
    }
    assert found == {(32, 2e-4), (64, 2e-4), (32, 4e-4), (64, 4e-4)}


def test_scenes_of_python_are_varied_like_files(smooth: Path) -> None:
    described = cs.read_scene(smooth)
    scene = replace(described.scene, hardness=3e9)
    study = studies.Study.of(
        scene, {"shapes.0": [cs.Cylinder(0.01), cs.Cylinder(0.02)]}, name="two"
    )
    assert [case.scene.shapes[0].radius for case in scenes(study)] == [0.01, 0.02]  # type: ignore[attr-defined]
    assert all(case.scene.hardness == 3e9 for case in scenes(study))


def test_one_rough_surface_and_one_grid_for_all_loads(rough: Path) -> None:
    study = studies.Study.of(
        rough, {"load.per_length": "20:100:3 N/mm", "shapes.1.rms": "0.1 um,0.2 um"}
    )
    cases = scenes(study)
    assert len({case.grid for case in cases}) == 1
    assert {case.scene.shapes[1].extent for case in cases} == {cases[0].grid.extent}  # type: ignore[attr-defined]
    first, last = (case.scene.shapes[1].gap(case.grid) for case in (cases[0], cases[-1]))
    # the same surface, twice as high
    np.testing.assert_allclose(last, 2 * first, rtol=1e-12)
    said = " ".join(study.notes)
    assert "planned once for 6 points" in said
    assert "random surfaces are fixed" in said


def test_a_finer_grid_shows_the_same_surface(rough: Path) -> None:
    cases = scenes(studies.Study.of(rough, {"plan.error": "0.05,0.2"}))
    assert len({case.grid for case in cases}) == 2
    assert len({case.scene.shapes[1] for case in cases}) == 1


def test_where_periods_share_no_part_the_study_says_that_surfaces_differ(rough: Path) -> None:
    study = studies.Study.of(rough, {"period": "0.5 mm,0.7 mm"})
    assert "random surfaces differ" in " ".join(study.notes)


def test_a_grid_that_cannot_hold_a_surface_is_refused(smooth: Path) -> None:
    heights = np.zeros((8, 8))
    heights[3, 3] = 1e-7
    described = cs.read_scene(smooth)
    surface = cs.MeasuredSurface(heights, extent=(1e-4, 1e-4), seam=cs.Tapered())
    scene = replace(described.scene, shapes=(*described.scene.shapes, surface))
    wide = replace(described, scene=scene, grid=cs.Grid((32, 32), (4e-4, 1e-4)))
    with pytest.raises(cs.InvalidInput, match="no wider than the surface"):
        studies.Study.of(wide, {"load.per_length": [1e4, 2e4]})


def test_windows_of_a_surface_are_an_axis(smooth: Path) -> None:
    heights = np.random.default_rng(0).standard_normal((40, 60)) * 1e-8
    described = cs.read_scene(smooth)
    surface = cs.MeasuredSurface(heights, extent=(1e-3, 1.5e-3), seam=cs.Tapered())
    scene = replace(described.scene, shapes=(*described.scene.shapes, surface))
    study = studies.Study.of(scene, {"windows": "2x3"})
    assert study.points[0].values == (0, 1, 2, 3, 4, 5)
    parts = [case.scene.shapes[1].heights for case in scenes(study)]  # type: ignore[attr-defined]
    np.testing.assert_array_equal(np.block([parts[:3], parts[3:]]), heights)
    assert "planned once for 6 points" in study.notes[-1]


def test_surfaces_are_an_axis_of_names(smooth: Path, tmp_path: Path) -> None:
    folder = tmp_path / "measured"
    folder.mkdir()
    for name in ("b", "a"):
        heights = np.random.default_rng(ord(name)).standard_normal((40, 20)) * 1e-8
        cs.MeasuredSurface(heights, extent=(1e-3, 5e-4)).write(folder / f"{name}.nc")
    smooth.write_text(
        smooth.read_text(encoding="utf-8").replace(
            "[plan]", '[[shapes]]\nkind = "MeasuredSurface"\nfile = "measured/a.nc"\n[plan]'
        ),
        encoding="utf-8",
    )
    study = studies.Study.of(smooth, {"surfaces": "measured/*.nc"})
    assert study.points[0].values == ("a.nc", "b.nc")
    digests = [case.scene.shapes[1].digest for case in scenes(study)]  # type: ignore[attr-defined]
    assert len(set(digests)) == 2


def test_the_axes_that_a_person_writes_twice_or_wrongly_are_named(rough: Path) -> None:
    for vary, said in (
        ({"load": "50 N/mm"}, "load.per_length"),
        ({"load.per_lenght": "50 N/mm"}, "did you mean"),
        ({"load.per_length": "50 MPa"}, "a load per length"),
        ({"load.per_length": "50 N/mm,"}, "lacks a value"),
        ({"load.per_length": "50:400 N/mm"}, "number of values"),
        ({"load.per_length": "0:400:3:log N/mm"}, "above 0"),
        ({"load.per_length": "50 N/mm,100,200 N/mm"}, "some have none"),
        ({"load.per_length": "-5 N/mm"}, "above 0"),
        ({"shapes.7.rms": "1 um"}, "0 Cylinder, 1 Roughness"),
        ({"shapes.0.rms": "1 um"}, "Cylinder|has no"),
        ({"padding.images": "1,2"}, "give padding in the file"),
        ({"grid.cells": "[32, 1]"}, "give grid in the file"),
        ({"padding": "Duplicated"}, "DuplicatedPadding"),
        ({"surfaces": "*.x3p"}, "MeasuredSurface"),
        ({"windows": "12"}, "MeasuredSurface|2x6"),
        ({"seed": "1.5"}, "whole number"),
        ({}, "vary is empty"),
    ):
        with pytest.raises(cs.InvalidInput, match=said):
            studies.Study.of(rough, vary)

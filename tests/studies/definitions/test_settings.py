from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from studies.advice.compared_scene import ComparedScene, compared_scene, paper_scene, scene_in
from studies.definitions.settings import measures, preset
from studies.model.study import Point
from studies.reference.line_contact import HERTZ, SCENE
from studies.registry import load

EXAMPLES = Path(__file__).parents[3] / "examples"

A = HERTZ.half_width
POINT: Point = {"padding": "exact", "images": 1, "period": 1, "grid": 24}


@pytest.fixture(scope="module")
def wavy() -> ComparedScene:
    """A cylinder with waves along its length, on one period of them."""
    shapes = (*SCENE.shapes, cs.Waviness(amplitude=2e-8, along=1.2 * A))
    grid = cs.Grid((12, 6), (2.4 * A, 1.2 * A))
    return compared_scene(cs.SceneFile(replace(SCENE, shapes=shapes), grid=grid), "wavy")


def measured(subject: ComparedScene, **point: object) -> dict[str, float]:
    study = preset("padding", subject)
    case = study.case_at({**POINT, **point})  # type: ignore[arg-type, dict-item]
    small = case
    if case.reference is not None:
        grid = replace(case.reference.grid, cells=(96, 48))
        small = replace(case, reference=replace(case.reference, grid=grid))
    return {
        name: float(one.values) for name, one in measures(small, small.run(small.prepare())).items()
    }


def test_several_periods_of_a_scene_have_the_error_of_one(wavy: ComparedScene) -> None:
    one, two, three = (measured(wavy, period=n) for n in (1, 2, 3))
    for several in (two, three):
        assert several["pressure_error_l1"] == pytest.approx(one["pressure_error_l1"], rel=1e-4)
        for name in ("contact_area_error", "mean_gap_error"):
            assert several[name] == pytest.approx(one[name], abs=1e-6)


def test_an_error_against_a_finer_grid_has_the_bound_of_that_grid_beside_it(
    wavy: ComparedScene,
) -> None:
    found = measured(wavy)
    grid = cs.Grid((96, 48), wavy.extent)
    finer = cs.solve(wavy.scene, grid, cs.ExactPeriodicity(), tolerance=1e-8)
    assert found["reference_error_l1"] == pytest.approx(finer.error.l1.total, rel=1e-6)


def test_the_free_ends_of_a_roller_are_one_of_its_paddings() -> None:
    roller = scene_in(EXAMPLES / "rough-roller.toml").subject()
    study = preset("grid", roller)
    assert "free" in study.axes[0].values
    case = study.case_at({**POINT, "padding": "free"})
    assert case.padding == (cs.ZeroPadding(), cs.ZeroPadding())
    with pytest.raises(cs.InvalidInput, match="ends along its length"):
        study.case_at({**POINT, "period": 2})


def test_a_measured_surface_has_no_period_but_its_own() -> None:
    heights = 1e-8 * np.random.default_rng(1).standard_normal((16, 16))
    shapes = (*SCENE.shapes, cs.MeasuredSurface(heights, (2.4 * A, 2.4 * A)))
    grid = cs.Grid((16, 16), (2.4 * A, 2.4 * A))
    subject = compared_scene(cs.SceneFile(replace(SCENE, shapes=shapes), grid=grid), "measured")
    with pytest.raises(cs.InvalidInput, match="has one period"):
        preset("period", subject).case_at({**POINT, "period": 2})


def test_an_unknown_preset_is_answered_with_the_right_one() -> None:
    with pytest.raises(cs.InvalidInput, match="did you mean 'padding'"):
        preset("paddin", paper_scene().subject())


def test_every_padding_may_have_one_cell_along_a_contact_that_does_not_vary() -> None:
    study = preset("pareto", paper_scene().subject())
    names = {axis.name: axis.values for axis in study.axes}
    for padding in names["padding"]:
        point = {"padding": padding, "images": 1, "period": 2.4, "grid": 48, "along": "one"}
        assert study.case_at(point).grid.cells == (48, 1)  # type: ignore[attr-defined]
        assert study.case_at(point | {"along": "square"}).grid.cells == (48, 48)  # type: ignore[attr-defined]


def test_the_paper_s_methods_are_compared_at_the_length_that_it_names() -> None:
    paper, images = (load(name) for name in ("paper", "images"))
    for study in (paper, images):
        values = {axis.name: axis.values for axis in study.axes}
        assert {"duplicated", "superposed"} <= set(values["padding"])
        assert 6 in values["images"]
        assert 3.0 in values["period"]


def test_the_set_up_of_a_contact_at_rest_makes_its_coefficients() -> None:
    [case] = load("padding").override({"padding": "exact", "period": "2.4", "images": "1"}).cases()
    prepared = case.prepare()
    assert prepared.problem.grid == case.grid  # type: ignore[attr-defined]
    assert case.run(prepared).answer.pressure.any()

from dataclasses import replace
from pathlib import Path

import pytest

from studies.advice.compared_scene import scene_in
from studies.definitions.settings import preset
from studies.registry import load

EXAMPLES = Path(__file__).parents[3] / "examples"


def test_the_pressure_of_fig_5_is_that_in_the_middle_of_the_length() -> None:
    """A window of one image makes the pressure vary along the length, so that the place matters."""
    study = load("paper").override({"padding": "superposed", "images": "1"})
    [case] = study.cases()
    solution = case.run(case.prepare())
    scaled = solution.answer.pressure / case.scene.hertz.peak_pressure
    found = study.measures(case, solution)
    assert found["pressure_true"].values == pytest.approx(
        case.scene.hertz.pressure(case.grid.x) / case.scene.hertz.peak_pressure, rel=1e-12
    )
    assert found["pressure"].values == pytest.approx(scaled[:, 80], rel=1e-12)
    # pressure is constant in each cell, whose borders stand beside its centre
    borders = found[found["x"].attrs["bounds"]].values
    assert borders[:, 0] == pytest.approx(found["x"].values - 1.2 / 128, abs=1e-12)
    assert borders[1:, 0] == pytest.approx(borders[:-1, 1], abs=1e-12)
    labels = [variable.attrs["long_name"] for variable in found.values()]
    assert len(set(labels)) == len(labels)
    assert all("units" in variable.attrs for variable in found.values())
    assert scaled[:, 80] != pytest.approx(scaled[:, 50], rel=1e-3)


@pytest.mark.parametrize("scene", ["rough", "oil"])
def test_any_scene_has_the_comparison_of_the_paper(scene: str) -> None:
    study = preset("paper", scene_in(EXAMPLES / f"{scene}.toml").subject())
    [case] = study.override({"padding": "exact", "images": "6", "grid": "24"}).cases()
    grid = replace(case.reference.grid, cells=(72, min(72, case.reference.grid.cells[1])))
    case = replace(case, reference=replace(case.reference, grid=grid))
    found = study.measures(case, case.run(case.prepare()))
    assert abs(found["pressure"] - found["pressure_true"]).max() < 0.5
    assert (found["pressure_min"] <= found["pressure"]).all()
    assert found["pressure_error_l1"] > 0

import pytest

from studies.registry import load


def test_the_pressure_of_fig_5_is_that_in_the_middle_of_the_length() -> None:
    """A window of one image makes the pressure vary along the length, so that the place matters."""
    study = load("paper").override({"padding": "superposed", "images": "1"})
    [case] = study.cases()
    solution = case.run(case.prepare())
    scaled = solution.pressure / case.scene.hertz.peak_pressure
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

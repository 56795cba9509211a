from typing import Any

import numpy as np
import pytest
import xarray as xr

from tests.studies.report.drawings.drawn import findings


def over(axes: str, **values: Any) -> dict[str, Any]:
    return {name: (axes.split(), np.asarray(value)) for name, value in values.items()}


STEPS, GRID = [10, 20, 40], [64, 96, 128]


def wear() -> xr.Dataset:
    """The explicit limit is at 10 / 0.4 = 25 steps."""
    width = np.arange(12.0).reshape(2, 3, 1, 2)
    longest = np.tile([0.4, 0.8, 1.6], (2, 1))[:, :, None]
    error = np.array([[0.1, 0.05, 0.02], [9.0, 5.0, 0.01]])[:, :, None]
    data = over("scheme steps grid distance", half_width=width)
    data |= over("scheme steps grid", pressure_error_l1=error, longest_explicit=longest)
    data |= over("scheme steps grid", solves=np.full((2, 3, 1), 60))
    schemes = ["implicit", "explicit"]
    return xr.Dataset(data, {"scheme": schemes, "steps": STEPS, "grid": [64], "distance": [0, 1]})


def creep() -> xr.Dataset:
    """The error by the steps falls as their square, down to four times that of the cells."""
    by_steps = np.array([0.64, 0.16, 0.04])[:, None] * np.array([1.0, 0.75, 0.5])
    data = over(
        "steps grid",
        pressure_error_l1=by_steps / [[2], [4], [5]],
        time_discretisation_error=by_steps,
        grid_error=np.tile([0.01, 0.01, 0.03], (3, 1)),
        convolutions=np.full((3, 3), 100.0),
    )
    width = np.arange(18.0).reshape(3, 3, 2)
    data |= over("steps grid time", half_width=width, peak_pressure=18 + width)
    return xr.Dataset(data, {"steps": STEPS, "grid": GRID, "time": [0.0, 1.0]})


def friction() -> xr.Dataset:
    axes = "grid rough_grid poisson_ratio"
    data = over(axes, superposition_error=[[[0.001, 0.02]]], transverse_traction=[[[0.0, 0.07]]])
    data |= over(
        f"{axes} coefficient",
        von_mises=[[[[0.5, 0.6, 0.9], [0.558, 0.57, 0.8]]]],
        depth=[[[[0.7, 0.6, 0.0], [0.7, 0.015, 0.0]]]],
    )
    sticks = {"stick": [[[[1, 0.4], [1, 0.53]]]], "stick_sphere": [[[[1, 0.6], [1, 0.7]]]]}
    data |= over(f"{axes} fraction", **sticks)
    coords = {"poisson_ratio": [0.0, 0.3], "coefficient": [0.0, 0.2, 0.4], "fraction": [0.0, 0.75]}
    return xr.Dataset(data, coords | {"grid": [65], "rough_grid": [24]})


def coating() -> xr.Dataset:
    """A coating four times as stiff, and one a quarter as stiff."""
    data = over(
        "grid ratio thickness",
        half_width=[[[1.01, 1.5, 2.1], [0.98, 0.7, 0.51]]],
        peak_pressure=[[[0.99, 0.7, 0.5], [1.02, 1.5, 2.0]]],
        reference_error=[[[np.nan, 2e-4, np.nan], [np.nan, 1e-4, np.nan]]],
    )
    return xr.Dataset(data, {"grid": [64], "ratio": [0.25, 4.0], "thickness": [0.1, 1.0, 10.0]})


@pytest.mark.parametrize(
    ("name", "dataset", "sentences"),
    [
        ("wear", wear(), [
            "With 20 steps of wear the error is 5.0 % (implicit) and 500 % (explicit).", "needs 25 steps",
        ]),
        ("creep", creep(), [
            "like N^{−2.00}, so a digit in time costs 3.2 times",
            "With 40 steps and 128 cells the pressure is known to 0.40 %",
            "in 100 FFT convolutions; with 64 cells the same steps leave 0.80 %",
            # of the two whose steps leave more than twice what the cells do
            "estimate is 2 to 4 times the error",
        ]),
        ("friction", friction(), [
            "is 0.558 p_{H} without friction and 0.800 p_{H} at a coefficient of 0.4",
            # at 0.2 a little below it; Cattaneo's is 0.5
            "it lies at the surface from 0.4 on", "within 0.030 half-widths",
            "to 0.10 % in L1 at nu = 0, and miss 2.0 % of it", "of 7.0 % of the largest",
        ]),
        ("coating", coating(), [
            "At a thickness of 0.1 a the half-width is within 2.0 % of that on the substrate",
            "at 10 a within 5.0 % of that on the coating", "met to 2.0e-04",
        ]),
    ],
    ids=lambda part: part if isinstance(part, str) else "",
)  # fmt: skip
def test_a_finding_says_what_an_effect_does(
    name: str, dataset: xr.Dataset, sentences: list[str]
) -> None:
    [text] = findings(name, dataset)
    for sentence in sentences:
        assert sentence in text


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("wear", wear().isel(steps=[0, 1])), ("wear", wear().isel(scheme=[0])), ("creep", creep().isel(grid=[0])),
        ("friction", friction().isel(poisson_ratio=[1])), ("coating", coating().isel(thickness=[0, 1])),
    ],
)  # fmt: skip
def test_nothing_is_said_of_a_part_that_does_not_show_it(name: str, part: xr.Dataset) -> None:
    assert not findings(name, part)

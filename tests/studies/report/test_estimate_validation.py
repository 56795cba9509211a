from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from studies.report import estimate_validation
from studies.store.netcdf import read


@pytest.fixture
def made_up() -> xr.Dataset:
    """Two paddings at two n, one of which has no n: the same case twice."""
    error = np.array([[-0.1, -0.1], [0.02, 0.01]])
    estimate = np.array([[0.2, 0.2], [0.01, 0.04]])
    data = {}
    for name, (truth, _) in estimate_validation.ESTIMATES.items():
        data[truth], data[name] = error, estimate
        data |= {f"{name}_{cause}": estimate / 3 for cause in estimate_validation.CAUSES}
    dims = ("padding", "images")
    coords = {"padding": ["exact", "circular"], "images": [0, 1]}
    return xr.Dataset({name: (dims, values) for name, values in data.items()}, coords)


def test_one_case_counts_once_at_however_many_points(made_up: xr.Dataset) -> None:
    rows = estimate_validation.table({"one": made_up, "again": made_up}).rows
    assert rows[0][:5] == ("highest pressure", "exact", "1", "100 %", "2")
    assert rows[1][:5] == ("highest pressure", "circular", "2", "50 %", "2.2")


def test_an_estimate_below_its_error_shows_in_the_claim(made_up: xr.Dataset) -> None:
    assert "67 % of 3 cases" in estimate_validation.finding({"one": made_up}).claim


def test_only_sweeps_with_an_estimate_are_compared(small_run: Path, made_up: xr.Dataset) -> None:
    bare = made_up.drop_vars(list(estimate_validation.ESTIMATES))
    sweep = read(small_run / "padding.nc")
    assert list(estimate_validation.sweeps_with_estimates({"bare": bare, "padding": sweep})) == [
        "padding"
    ]
    assert (
        estimate_validation.figure({"padding": sweep}).figure.axes[0].get_title()
        == "highest pressure"
    )

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from studies.report.drawings import trust
from studies.store.netcdf import read
from tests.studies.report.drawings.drawn import labelled, same


@pytest.fixture
def made_up() -> xr.Dataset:
    """Two paddings at two n, one of which has no n: the same case twice."""
    error = np.array([[-0.1, -0.1], [0.02, 0.01]])
    estimate = np.array([[0.2, 0.2], [0.01, 0.04]])
    data = {}
    for name, (truth, _) in trust.ESTIMATES.items():
        data[truth], data[name] = error, estimate
        data |= {f"{name}_{cause}": estimate / 3 for cause in trust.CAUSES}
    dims = ("padding", "images")
    coords = {"padding": ["exact", "circular"], "images": [0, 1]}
    return xr.Dataset({name: (dims, values) for name, values in data.items()}, coords)


def test_one_case_counts_once_at_however_many_points(made_up: xr.Dataset) -> None:
    rows = trust.estimates_table({"one": made_up, "again": made_up}).rows
    assert rows[0][:5] == ("peak pressure", "exact", "1", "100 %", "2")
    assert rows[1][:5] == ("peak pressure", "circular", "2", "50 %", "2.2")


def test_an_error_of_nothing_has_no_ratio(made_up: xr.Dataset) -> None:
    for truth, _ in trust.ESTIMATES.values():
        made_up[truth][1, 1] = 0.0
    rows = trust.estimates_table({"one": made_up}).rows
    assert rows[1][:4] == ("peak pressure", "circular", "1", "0 %")


def test_a_sweep_needs_its_estimates_its_errors_and_its_paddings(made_up: xr.Dataset) -> None:
    names, causes = trust.ESTIMATES, trust.CAUSES
    least = made_up.drop_vars(
        [*(f"{name}_{cause}" for name in names for cause in causes), "images"]
    )
    assert [*trust.sweeps_with_estimates({"least": least})] == ["least"]
    less = least.drop_vars("pressure_error_l1")
    assert not trust.sweeps_with_estimates({"less": less})


def test_an_estimate_below_its_error_shows_in_the_claim(made_up: xr.Dataset) -> None:
    assert "67 % of 3 cases" in trust.estimates_finding({"one": made_up}).claim


def test_only_sweeps_with_an_estimate_are_compared(small_run: Path, made_up: xr.Dataset) -> None:
    bare = made_up.drop_vars(list(trust.ESTIMATES))
    sweep = read(small_run / "padding.nc")
    assert list(trust.sweeps_with_estimates({"bare": bare, "padding": sweep})) == ["padding"]
    assert trust.estimates_figure({"padding": sweep}).figure.axes[0].get_title() == "peak pressure"


def test_the_figure_and_the_table_are_of_bound_over_error_and_what_it_is_made_of(
    made_up: xr.Dataset,
) -> None:
    """One kind of error alone; its bounds are 1, 2, 3 and 12 times the error, and in parts 1 : 2 : 5 of eight."""
    error = np.array([[0.1, -0.2], [0.3, 0.4]])
    bound = abs(error) * [[1, 2], [3, 12]]
    for name, (truth, _) in trust.ESTIMATES.items():
        made_up[truth] = ("padding", "images"), error
        made_up[name] = ("padding", "images"), bound
        for cause, eighths in zip(trust.CAUSES, (1, 2, 5), strict=True):
            made_up[f"{name}_{cause}"] = ("padding", "images"), bound * eighths / 8
    ax = trust.estimates_figure({"one": made_up}).figure.axes[1]
    shown = labelled(ax)
    assert same(shown["exact"], [0.1, 0.2], [0.1, 0.4])
    assert same(shown["circular"], [0.3, 0.4], [0.9, 4.8])
    assert same(shown["estimate = error"], [0.1, 0.4], [0.1, 0.4])
    assert same(shown["5 times the error"], [0.1, 0.4], [0.5, 2.0])
    exact, circular = trust.estimates_table({"one": made_up}).rows[2:]
    # quantiles of 0.9 between two values
    assert exact == ("pressure in L1", "exact", "2", "100 %", "1.5", "1.9", "12 %", "25 %", "62 %")
    assert circular[4:6] == ("7.5", "11")
    said = trust.estimates_finding({"one": made_up})
    assert said.claim == "The error estimate bounds the true error in 100 % of 4 cases."
    assert "peak pressure by a factor of 2.5 and pressure in L1 by a factor of 2.5" in said.measured

"""What the study of estimates says of made-up errors and bounds."""

import numpy as np
import pytest
import xarray as xr

from studies.definitions.accuracy import KINDS, METRICS, UNKNOWN
from studies.report.drawings.accuracy import figure, findings, tables


@pytest.fixture
def made_up() -> xr.Dataset:
    """Four cases of two kinds: ratios 2 and 4, one miss, one without a bound; a gap that is not known."""
    error = np.array([0.01, 0.01, 0.02, 0.03])
    bound = np.array([0.02, 0.04, 0.01, np.inf])
    data = {"kind": ("case", [0, 0, 1, 1]), "silent": ("case", [0, 0, 0, 0])}
    for metric in METRICS:
        data[f"{metric}_error"] = ("case", error)
        data[f"{metric}_bound"] = ("case", bound)
    data["mean_gap_error"] = ("case", np.full(4, UNKNOWN))
    return xr.Dataset(data, {"case": ["a", "b", "c", "d"]})


def test_the_table_counts_by_kind_and_lists_every_miss(made_up: xr.Dataset) -> None:
    by_kind, misses = tables(made_up)
    assert by_kind.rows[0][:5] == (KINDS[0], "2", "100.0 %", "3", "0")
    assert by_kind.rows[1][:5] == (KINDS[1], "2", "50.0 %", "0.5", "1")
    assert [row[:2] for row in misses.rows] == [
        ("c", "pressure in L1"), ("c", "highest pressure"), ("c", "contact area"),
    ]  # fmt: skip


def test_the_finding_says_the_share_that_holds(made_up: xr.Dataset) -> None:
    (finding,) = findings(made_up)
    assert "75.0 % of 4 contacts" in finding.claim
    assert "in the median 2 times too large, 1 without a bound" in finding.measured


def test_the_figure_draws_what_has_a_bound(made_up: xr.Dataset) -> None:
    (drawn,) = figure(made_up)
    assert len(drawn.figure.axes) >= 3
    assert "(1 of the highest pressure)" in drawn.caption

import numpy as np
import pytest
import xarray as xr

from studies.definitions.accuracy import KINDS, METRICS
from studies.registry import load, load_drawing
from studies.report.page import axes_text

DRAWING = load_drawing("accuracy")


@pytest.fixture
def made_up() -> xr.Dataset:
    """Four cases of two kinds: ratios 2 and 4, one miss, one without a bound; a gap that is not known."""
    error = np.array([0.01, 0.01, 0.02, 0.03])
    bound = np.array([0.02, 0.04, 0.01, np.inf])
    data = {
        "kind": ("case", [0, 0, 1, 1]),
        "missing_without_reason": ("case", [0, 0, 0, 0]),
        "use": ("case", [1, 1, 1, 2]),
    }
    for metric in METRICS:
        data[f"{metric}_error"] = ("case", error.copy())
        data[f"{metric}_bound"] = ("case", bound.copy())
    del data["mean_gap_error"]
    return xr.Dataset(data, {"case": ["a", "b", "c", "d"]})


def test_the_table_counts_by_kind_and_lists_every_miss(made_up: xr.Dataset) -> None:
    by_kind, misses = DRAWING.tables(made_up)
    assert by_kind.rows[0][:5] == (KINDS[0], "2", "100.0 %", "3", "0")
    assert by_kind.rows[1][:5] == (KINDS[1], "2", "0.0 %", "0.5", "1")
    assert [row[:2] for row in misses.rows] == [
        ("c", "pressure in L1"), ("c", "peak pressure"), ("c", "contact area"),
    ]  # fmt: skip
    # of more than ten cases the page counts those and their kinds
    many = xr.concat([made_up] * 3, "case").assign_coords(seed=[1])
    assert ": 12 cases of 2 kinds; " in axes_text(load("accuracy"), many)


def test_the_finding_says_the_share_that_holds(made_up: xr.Dataset) -> None:
    (finding,) = DRAWING.findings(made_up)
    assert "of 4 contacts of every kind" in finding.claim
    assert "66.7 % hold where there is one" in finding.claim
    assert "66.7 % / 66.7 % / 66.7 % of 3 contacts (validation)" in finding.measured
    # a bound that is missing is none that holds
    assert "none / none / none of 1 contacts (random)" in finding.measured
    assert "in the median 2 times too large, 1 without a bound" in finding.measured


def test_the_ratio_is_of_errors_that_are_known_and_not_nothing(made_up: xr.Dataset) -> None:
    made_up["contact_area_error"][1], made_up["contact_area_error"][2] = np.nan, 0.0
    made_up["missing_without_reason"][3] = 1
    of_first, of_second = DRAWING.tables(made_up)[0].rows
    # of two areas one is known, whose bound is twice the error; the other kind has an error of nothing and no bound
    assert of_first[8:] == ("100.0 %", "2", "0")
    assert of_second[8:] == ("100.0 %", "none", "1")
    [finding] = DRAWING.findings(made_up)
    assert "contact area: 100.0 % bounded, in the median 2 times too large" in finding.measured
    assert "1 bounds are missing without a reason" in finding.measured
    assert DRAWING.tables(made_up)[1].rows[0] == ("c", "pressure in L1", "0.02", "0.01")


def test_contacts_on_which_margins_are_set_do_not_count_in_the_finding(made_up: xr.Dataset) -> None:
    made_up["use"][2] = 0
    (finding,) = DRAWING.findings(made_up)
    assert "100.0 % hold" in finding.claim
    assert "0.0 % / 0.0 % / 0.0 % of 1 contacts (calibration)" in finding.measured

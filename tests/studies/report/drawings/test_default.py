from typing import Any

import numpy as np
import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.model.outcome import CaseStatus
from studies.report.drawings.default import figures
from studies.report.plots import DOUBTFUL
from tests.studies.report.drawings.drawn import labelled, numbered

LOADS, RMS = [1e4, 2e4, 5e4, 2e5], [1e-7, 2e-7, 3e-7]


def axes_text(axes: dict[str, Any]) -> xr.Dataset:
    """A fraction, a pressure [Pa], an approach [m] and a time [s]; the first case failed."""
    dataset = numbered(axes, "contact_fraction", "peak_pressure", "approach", "solve_time")
    dataset["contact_fraction"] **= 2
    dataset["peak_pressure"] = 1e10 * dataset["peak_pressure"]
    dataset["approach"] = 1e-3 * dataset["approach"]
    for name, units in (("contact_fraction", "1"), ("peak_pressure", "Pa"), ("approach", "m")):
        dataset[name].attrs |= {"units": units, "long_name": name.replace("_", " ")}
    if "load_per_length" in axes:
        dataset["load_per_length"].attrs |= {"units": "N m-1", "long_name": "load, per length"}
    if "rms" in axes:
        dataset["rms"].attrs |= {"units": "m", "long_name": "rms height"}
    status = np.full(tuple(map(len, axes.values())), CaseStatus.OK)
    status.flat[0] = CaseStatus.FAILED
    dataset["case_status"] = tuple(axes), status
    return dataset.assign_attrs(title="Rough contact")


def test_measures_stand_over_the_load_in_units_in_which_they_are_short() -> None:
    dataset = axes_text({"rms": RMS, "load_per_length": LOADS})
    [drawn] = figures(dataset)
    fraction, pressure, approach = drawn.figure.axes
    good = dataset.where(dataset["case_status"] == CaseStatus.OK)
    # N/mm, and nm in the legend; the largest pressure is 24e6 Pa, the largest approach 3.6e-6 m
    for ax, name, unit in (
        (fraction, "contact_fraction", 1.0), (pressure, "peak_pressure", 1e6), (approach, "approach", 1e-6),
    ):  # fmt: skip
        for (x, y), height in zip(labelled(ax).values(), RMS, strict=True):
            assert x == pytest.approx([10, 20, 50, 200])
            np.testing.assert_allclose(y, good[name].sel(rms=height) / unit, rtol=1e-12)
    assert "[MPa]" in pressure.get_ylabel()


def numbered_ok(axes: dict[str, Any], *names: str) -> xr.Dataset:
    """Numbers over axes on which no case failed."""
    dataset = numbered(axes, *names)
    dataset["case_status"] = xr.full_like(dataset[names[0]], CaseStatus.OK)
    return dataset


def test_a_value_without_a_bound_is_hollow_and_a_measure_that_never_changes_is_left_out() -> None:
    dataset = numbered_ok({"angle": [0.0, 1.0, 2.0]}, "peak_pressure", "approach")
    dataset["peak_pressure_bound"] = "angle", [0.1, np.nan, np.nan]
    dataset["approach"] = "angle", 2.0 + 1e-9 * np.arange(3)
    [ax] = figures(dataset)[0].figure.axes
    _, hollow = labelled(ax)[DOUBTFUL["label"]]
    np.testing.assert_array_equal(hollow, [np.nan, *dataset["peak_pressure"].values[1:]])


def test_what_misses_the_accuracy_asked_for_is_hollow_and_the_caption_says_so() -> None:
    dataset = axes_text({"rms": RMS, "load_per_length": LOADS})
    assert "hollow" not in figures(dataset)[0].caption
    above = xr.full_like(dataset["approach"], "half_width", dtype=object)
    dataset["above_request"] = above
    dataset["above_request"][1, 2] = "approach half_width"
    [drawn] = figures(dataset)
    hollow = [labelled(ax).get(DOUBTFUL["label"]) for ax in drawn.figure.axes]
    [(x, y)] = [points for points in hollow if points is not None]  # of one quantity alone
    at = np.flatnonzero(np.isfinite(y))
    assert np.asarray(x)[at] == pytest.approx([LOADS[2] / 1e3])
    assert "hollow" in drawn.caption


def test_a_caption_says_what_has_no_figure() -> None:
    [one] = figures(numbered_ok({"load_per_length": LOADS}, *(f"measure{k}" for k in range(8))))
    assert "--plot draws 2 more, such as measure6" in one.caption
    many = {"load_per_length": LOADS, "rms": np.arange(13.0), "hurst": np.arange(13.0)}
    drawn = figures(numbered_ok(many, "approach"))
    assert len(drawn) == 12
    assert "the first 12 of 13 points" in drawn[0].caption
    [one] = figures(numbered_ok({"load_per_length": LOADS}, "approach"))
    assert "more" not in one.caption


def test_a_median_of_samples_says_of_how_many_it_is() -> None:
    dataset = numbered_ok({"rms": RMS, "seed": [1, 2, 3]}, "approach")
    dataset["approach"][0, 1] = np.nan
    [drawn] = figures(dataset)
    median = labelled(drawn.figure.axes[0])["median of 2 to 3, and their range"][1]
    np.testing.assert_allclose(median, dataset["approach"].median("seed"))


def test_times_are_drawn_where_there_is_nothing_else_and_without_measures_nothing() -> None:
    dataset = axes_text({"load_per_length": LOADS})
    other = dataset.drop_vars(["contact_fraction", "peak_pressure", "approach"])
    assert figures(other)
    with pytest.raises(InvalidInput, match="no measure to draw"):
        figures(other.drop_vars("solve_time"))


def test_the_measures_that_are_asked_for_are_drawn_alone() -> None:
    dataset = axes_text({"load_per_length": LOADS})
    [drawn] = figures(dataset, plot=["approach"])
    assert [ax.get_ylabel() for ax in drawn.figure.axes] == ["approach [µm]"]
    # whole numbers are measures too
    counted = dataset[["case_status"]].assign(count=("load_per_length", [1, 2, 3, 5]))
    assert [drawn.figure.axes[0].get_ylabel() for drawn in figures(counted)] == ["count"]
    with pytest.raises(InvalidInput, match="did you mean 'approach'"):
        figures(dataset, plot=["aproach"])

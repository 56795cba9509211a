from typing import Any

import numpy as np
import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.report.changes import changes

AXES = ("padding", "grid")


def stored(**more: Any) -> xr.Dataset:
    numbers = {
        "l1_error": np.array([[4.0, 2.0, 1.0], [-8.0, 3.0, np.nan]]),
        "width": np.ones((2, 3)),
        "solve_time": np.array([[1.0, 2.0, 4.0], [1.0, 1.0, np.nan]]),
        "iterations": np.full((2, 3), 7.0),
        "pressure_estimate_residual": np.full((2, 3), 1e-9),
    } | more
    data = {name: (AXES, values) for name, values in numbers.items()}
    data["case_status"] = (AXES, np.ones((2, 3), dtype=int))
    data["solver_status"] = (AXES, np.zeros((2, 3), dtype=int))
    coords = {"padding": ["exact", "zero"], "grid": [16, 32, 64]}
    return xr.Dataset(data, coords, {"cpu": "one", "cpu_count": 2})


def test_the_largest_change_relative_to_the_largest_number_comes_first() -> None:
    after = stored(
        l1_error=np.array([[4.0, 2.5, 1.0], [-8.0, 2.9, np.nan]]),
        width=np.array([[1.0, 1.0, 0.8], [1.0, 1.0, 1.0]]),
        iterations=np.full((2, 3), 9.0),
        pressure_estimate_residual=np.full((2, 3), 2e-9),
    )
    said = changes(stored(), after)
    assert said[:3] == [
        "6 points in both, of 6 and 6",
        "width: from 1 to 0.8 at padding exact, grid 64, 0.2 of the largest value",
        # half over the largest in size, 8
        "l1_error: from 2 to 2.5 at padding exact, grid 32, 0.062 of the largest value",
    ]
    assert len(said) == 4


def test_points_that_both_have_are_compared_wherever_they_stand() -> None:
    after = stored().isel(grid=[2, 1]).transpose("grid", "padding")
    said = changes(stored(), after)
    assert said[:2] == ["4 points in both, of 6 and 4", "no measure differs"]
    apart = stored().assign_coords(grid=[1, 2, 3])
    assert changes(stored(), apart) == ["0 points in both, of 6 and 6: no value of grid is in both"]
    with pytest.raises(InvalidInput, match="compare two runs of one study"):
        changes(stored(), stored().rename(grid="cells"))


def test_a_status_that_differs_is_counted_and_a_number_from_nothing_is_endless() -> None:
    after = stored()
    after["solver_status"][0, :2] = 3
    after["case_status"][1, 2] = 2
    before = stored(width=np.zeros((2, 3)), contact_time=np.array([[np.inf, 2, 2], [2, 2, 2]]))
    after["contact_time"] = before["contact_time"].copy()
    after["contact_time"][0, 2] = 3
    said = changes(before, after)
    assert set(said) >= {
        "case_status differs at 1 of 6 points",
        "solver_status differs at 2 of 6 points",
        "width: from 0 to 1 at padding exact, grid 16, inf of the largest value",
        # beside an infinite number, over the largest finite one
        "contact_time: from 2 to 3 at padding exact, grid 64, 0.5 of the largest value",
    }


def test_counts_and_flags_that_differ_are_said_and_a_missing_status_is_none() -> None:
    flags = {"flag_meanings": "right explained wrong"}
    before, after = (stored(layers=np.array([[4, 4, 4], [4, 4, layers]])) for layers in (4, 6))
    for run, verdict in ((before, 0), (after, 2)):
        run["verdict"] = (AXES, np.array([[0, 0, 0], [0, 0, verdict]], dtype=np.int8), flags)
        run["solver_status"] = run["solver_status"].where(run["grid"] < 64)
        run["kind"] = AXES, np.array([["a"] * 3, ["a", "a", "ab"[verdict // 2]]], dtype=object)
    assert changes(before, after)[1:4] == [
        "kind differs at 1 of 6 points",
        "verdict differs at 1 of 6 points",
        "layers: from 4 to 6 at padding zero, grid 64, 0.5 of the largest value",
    ]
    assert changes(before, before)[1] == "no measure differs"


@pytest.mark.parametrize(
    ("of_first", "of_second", "sentence"),
    [
        ([1.0, 2.0], [1.0, 2.5], "profile: from 2 to 2.5 at padding exact, grid 16, x 1, 0.25 of the largest value"),
        ([1.0, 2.0], [1.0, np.nan], "profile is nan at 6 points of one run alone"),
        ([1.0, 2.0], [1.0], "profile is not compared: its values along x do not correspond"),
        ([1.0, 2.0], None, "profile is in the first run alone"),
    ],
)  # fmt: skip
def test_a_measure_along_a_dimension_of_its_own_is_compared(
    of_first: list[float], of_second: list[float] | None, sentence: str
) -> None:
    runs = [stored(), stored()]
    for run, profile in zip(runs, (of_first, of_second), strict=True):
        if profile is not None:
            run["profile"] = (*AXES, "x"), np.tile(np.array(profile), (2, 3, 1))
    assert changes(*runs)[1] == sentence


def test_times_are_compared_by_their_ratio_on_one_processor_alone() -> None:
    slower = stored()
    slower["solve_time"] = slower["solve_time"] * np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 1.0]])
    said = changes(stored(), slower)
    # 1, 2, 2, 3 and 4 times
    assert said[-1] == "solve_time: median ratio of second to first 2 over 5 points (1 to 4)"
    one = changes(stored().isel(grid=[1], padding=[0]), slower.isel(grid=[1], padding=[0]))
    assert one[-1] == "solve_time: median ratio of second to first 2 over 1 point (2 to 2)"
    elsewhere = slower.assign_attrs(cpu_count=4)
    assert changes(stored(), elsewhere)[-1] == "times were taken on different processors and are not compared"
    untimed = slower.drop_vars("solve_time")
    assert changes(stored(), untimed) == ["6 points in both, of 6 and 6", "no measure differs"]

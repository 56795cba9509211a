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
        "case_status": np.ones((2, 3), dtype=int),
        "solver_status": np.zeros((2, 3), dtype=int),
    } | more
    data = {name: ((*AXES, "x")[: np.ndim(values)], values) for name, values in numbers.items()}
    coords = {"padding": ["exact", "zero"], "grid": [16, 32, 64]}
    return xr.Dataset(data, coords, {"cpu": "one", "cpu_count": 2})


def test_the_largest_change_relative_to_the_largest_number_comes_first() -> None:
    after = stored(
        l1_error=np.array([[4.0, 2.5, 1.0], [-8.0, 2.9, np.nan]]),
        width=np.array([[1.0, 1.0, 0.8], [1.0, 1.0, 1.0]]),
        iterations=np.full((2, 3), 9.0),
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
    assert changes(stored(), after)[:2] == ["4 points in both, of 6 and 4", "no measure differs"]
    apart = stored().assign_coords(grid=[1, 2, 3])
    assert changes(stored(), apart) == ["0 points in both, of 6 and 6: no value of grid is in both"]
    with pytest.raises(InvalidInput, match="compare two runs of one study"):
        changes(stored(), stored().rename(grid="cells"))


def test_statuses_texts_and_infinite_numbers_that_differ_are_said() -> None:
    kind = np.array([["a"] * 3] * 2, dtype=object)
    before = stored(width=np.zeros((2, 3)), kind=kind, contact_time=np.array([[np.inf, 2, 2], [2, 2, 2]]))
    after = stored(kind=kind.copy(), contact_time=before["contact_time"].values.copy())
    after["solver_status"][0, :2] = 3
    after["kind"][1, 2] = "b"
    after["contact_time"][0, 2] = 3
    assert set(changes(before, after)) >= {
        "solver_status differs at 2 of 6 points",
        "kind differs at 1 of 6 points",
        "width: from 0 to 1 at padding exact, grid 16, inf of the largest value",
        # beside an infinite number, over the largest finite one
        "contact_time: from 2 to 3 at padding exact, grid 64, 0.5 of the largest value",
    }


@pytest.mark.parametrize(
    ("of_second", "sentence"),
    [
        ([1.0, 2.5], "profile: from 2 to 2.5 at padding exact, grid 16, x 1, 0.25 of the largest value"),
        ([1.0, np.nan], "profile is nan at 6 points of one run alone"),
        ([1.0], "profile is not compared: its values along x do not correspond"),
    ],
)
def test_a_measure_along_a_dimension_of_its_own_is_compared(of_second: list[float], sentence: str) -> None:
    first, second = (stored(profile=np.tile(np.array(row), (2, 3, 1))) for row in ([1.0, 2.0], of_second))
    assert changes(first, second)[1] == sentence
    assert changes(first, stored())[1] == "profile is in the first run alone"


def test_times_are_compared_by_their_ratio_on_one_processor_alone() -> None:
    slower = stored()
    slower["solve_time"] = slower["solve_time"] * np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 1.0]])
    # 1, 2, 2, 3 and 4 times
    assert changes(stored(), slower)[-1] == "solve_time: median ratio of second to first 2 over 5 points (1 to 4)"
    elsewhere = slower.assign_attrs(cpu_count=4)
    assert changes(stored(), elsewhere)[-1] == "times were taken on different processors and are not compared"

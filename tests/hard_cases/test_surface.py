from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from studies.definitions.hard_cases import ROUGH, grid, with_heights
from studies.reference.line_contact import HERTZ_HEIGHT, SCENE
from tests.hard_cases.cases import EXACT

HEIGHTS = ROUGH * HERTZ_HEIGHT


def strided(heights: np.ndarray) -> np.ndarray:
    wide = np.full((48, 36), np.nan)
    wide[::2, ::3] = heights
    return wide[::2, ::3]


def read_only(heights: np.ndarray) -> np.ndarray:
    heights = heights.copy()
    heights.setflags(write=False)
    return heights


def labelled(heights: np.ndarray) -> xr.DataArray:
    return xr.DataArray(heights, dims=("width", "length"))


@pytest.mark.parametrize(
    "form",
    [
        np.asfortranarray, strided, read_only, lambda heights: heights.astype(">f8"),
        np.ma.asarray, labelled,
        lambda heights: labelled(heights).transpose(),
        lambda heights: labelled(heights).chunk({"width": 8, "length": 5}),
        lambda heights: heights.tolist(),
    ],
    ids=["Fortran", "strided", "read-only", "big-endian", "masked", "xarray", "turned", "dask", "list"],
)  # fmt: skip
def test_heights_are_the_same_in_any_form(form: object) -> None:
    plain = cs.solve(with_heights(ROUGH).problem(grid(), EXACT))
    given = form(HEIGHTS)  # type: ignore[operator]
    before = np.array(given)
    scene = replace(SCENE, shapes=(*SCENE.shapes, cs.MeasuredSurface(given)))
    solution = cs.solve(scene.problem(grid(), EXACT))
    np.testing.assert_array_equal(solution.pressure, plain.pressure)
    np.testing.assert_array_equal(np.array(given), before)


@pytest.mark.parametrize("kind", [np.float32, np.int64])
def test_heights_of_another_type_are_the_numbers_they_hold(kind: type) -> None:
    heights = (HEIGHTS / 1e-9).astype(kind)
    assert cs.MeasuredSurface(heights) == cs.MeasuredSurface(heights.astype(float))


def test_an_outlier_is_taken_as_measured() -> None:
    heights = ROUGH.copy()
    heights[12, 6] = 1e6
    solution = cs.solve(with_heights(heights).problem(grid(), EXACT))
    assert solution.status is cs.Status.CONVERGED
    assert np.flatnonzero(solution.pressure).tolist() == [12 * 12 + 6]

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
        strided, read_only, lambda heights: heights.astype(">f8"), np.ma.asarray,
        lambda heights: labelled(heights).transpose(),
        lambda heights: labelled(heights).chunk({"width": 8, "length": 5}),
        lambda heights: heights.tolist(),
    ],
    ids=["strided", "read-only", "big-endian", "masked", "turned", "dask", "list"],
)  # fmt: skip
def test_heights_are_the_same_in_any_form(form: object) -> None:
    plain = cs.solve(with_heights(ROUGH).problem(grid(), EXACT))
    given = form(HEIGHTS)  # type: ignore[operator]
    before = np.array(given)
    scene = replace(SCENE, shapes=(*SCENE.shapes, cs.MeasuredSurface(given)))
    solution = cs.solve(scene.problem(grid(), EXACT))
    np.testing.assert_array_equal(solution.pressure, plain.pressure)
    np.testing.assert_array_equal(np.array(given), before)

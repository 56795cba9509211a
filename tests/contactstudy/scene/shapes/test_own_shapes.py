from collections.abc import Callable
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL

GRID = cs.Grid((48, 12), (3e-4, 1e-4))


@dataclass(frozen=True)
class Own:
    heights: Callable[[cs.Grid], Any]
    curvature: Any = 0.0

    def gap(self, grid: cs.Grid) -> Any:
        return self.heights(grid)


def solved(own: Own) -> cs.Solution:
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01), own))
    return cs.solve(scene.problem(GRID, cs.ExactPeriodicity()))


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("heights", "message"),
    [
        (lambda grid: np.zeros(grid.cells[0]), r"Own\.gap has the shape \(48,\): return heights"),
        (lambda grid: np.zeros(grid.cells).T, r"Own\.gap has the shape \(12, 48\): return heights"),
        (lambda grid: np.zeros((*grid.cells, 1)), r"shape \(48, 12, 1\)"),
        (lambda grid: 1j * np.zeros(grid.cells), r"Own\.gap has values of the type complex128"),
        (lambda _: "flat", r"values of the type <U4"),
        (lambda _: [[1.0], [1.0, 2.0]], r"Own\.gap is \[\[1\.0\], \[1\.0, 2\.0\]\]: return an array"),
        (lambda grid: np.where(grid.x > 0, 0, nan)[:, None], r"is not finite at 24 points"),
        (lambda grid: np.full(grid.cells, np.inf), r"is not finite at 576 points"),
        (lambda grid: np.ma.masked_less(grid.x, 0)[:, None], r"is not finite at 24 points"),
    ],
)  # fmt: skip
def test_what_is_no_height_is_refused(heights: Callable[[cs.Grid], Any], message: str) -> None:
    with pytest.raises(cs.InvalidInput, match=message):
        solved(Own(heights))


@pytest.mark.parametrize("curvature", [nan, 1j, None, "flat"])
def test_a_curvature_that_is_no_number_is_refused(curvature: Any) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Scene\.shapes\[1\]\.curvature is "):
        solved(Own(lambda grid: np.zeros(grid.cells), curvature))


def test_nested_lists_of_heights_are_heights() -> None:
    flat = Own(lambda grid: [[0.0] * grid.cells[1]] * grid.cells[0])
    assert solved(flat).status is cs.Status.CONVERGED

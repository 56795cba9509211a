"""What the shapes of a scene are together."""

from math import inf
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.source import ShapesSource, ends_along, sized

GRID = cs.Grid((8, 6), (2.0, 3.0))
WAVE, LONG = cs.Waviness(1e-6, across=0.5), cs.Waviness(2e-6, across=0.9, along=1.5)


class Unknown:
    """A shape that names no scales."""

    curvature = 0.0

    def gap(self, grid: cs.Grid) -> np.ndarray:
        return 0 * grid.x[:, None] + 3.0


def source(*shapes: Any) -> ShapesSource:
    return ShapesSource(shapes, ends_along=False, make=lambda grid: grid)  # type: ignore[arg-type,return-value]


def test_the_finest_of_all_counts_and_heights_add_up() -> None:
    both = source(WAVE, LONG)
    assert both.finest == (0.5, 1.5)
    assert both.names_scales
    np.testing.assert_allclose(both.gap(GRID), WAVE.gap(GRID) + LONG.gap(GRID))
    mixed = source(WAVE, Unknown())
    assert mixed.finest == (0.5, inf)
    assert not mixed.names_scales
    # no larger than it must be
    assert mixed.gap(GRID).shape == (8, 1)
    assert source().finest == (inf, inf)
    assert source().gap(GRID).tolist() == [[0.0]] * 8
    assert both.problem(GRID) is GRID


@pytest.mark.parametrize(
    ("length", "ends"), [(2.9, True), (3.0, True), (3.0 * (1 + 1e-10), True), (3.01, False)]
)
def test_a_roller_ends_in_the_period_that_holds_it(length: float, ends: bool) -> None:  # noqa: FBT001
    assert ends_along((WAVE, cs.FiniteLength(length)), GRID) == ends
    assert not ends_along((WAVE, Unknown()), GRID)  # type: ignore[arg-type]


def test_heights_given_cell_for_cell_get_the_grid_s_extent() -> None:
    surface = cs.MeasuredSurface(np.eye(8, 6))
    first, second = sized((surface, WAVE), GRID)
    assert first.extent == (2.0, 3.0)  # type: ignore[attr-defined]
    assert second is WAVE

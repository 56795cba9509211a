from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.shapes.moving_shape import MovingShape

GRID = cs.Grid((16, 3), (4.0, 3.0))


def measured(heights: np.ndarray) -> MovingShape:
    shape: Any = SimpleNamespace(seam=None, length_scales=cs.LengthScales(), gap=lambda _: heights)
    return MovingShape(shape)


def test_measured_heights_move_to_larger_x_and_come_in_again_at_the_other_end() -> None:
    heights = np.random.default_rng(5).standard_normal(GRID.cells)
    moved = measured(heights).gap_after(GRID, 2 * GRID.cell_size[0])
    np.testing.assert_allclose(moved, np.roll(heights, 2, axis=0), rtol=0, atol=1e-13)
    assert measured(heights).body == 0


def test_between_cells_measured_heights_are_cubic_splines() -> None:
    """Of a wave with the angle t from cell to cell, B-splines at integers and half-way between them."""
    t = 2 * np.pi * 3 / 16
    wave = np.cos(t * np.arange(16))[:, None] * np.ones(3)
    moved = measured(wave).gap_after(GRID, GRID.cell_size[0] / 2)
    factor = (23 * np.cos(t / 2) + np.cos(3 * t / 2)) / 24 / ((2 + np.cos(t)) / 3)
    expected = factor * np.cos(t * (np.arange(16) - 0.5))
    assert moved == pytest.approx(expected[:, None] * np.ones(3), abs=1e-13)

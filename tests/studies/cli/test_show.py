"""Edges of the cells that are drawn in three dimensions."""

import numpy as np
import pytest

from studies.cli.show import _edges


def test_edges_lie_half_a_cell_beside_the_centres() -> None:
    assert _edges(np.array([1.0, 3.0, 5.0])) == pytest.approx([0, 2, 4, 6])
    assert _edges(np.array([-1.0, 0.0])) == pytest.approx([-1.5, -0.5, 0.5])


def test_one_cell_is_as_wide_as_its_place_or_a_micrometre() -> None:
    assert _edges(np.array([4.0])) == pytest.approx([-2, 2])
    assert _edges(np.array([0.0])) == pytest.approx([-5e-7, 5e-7])

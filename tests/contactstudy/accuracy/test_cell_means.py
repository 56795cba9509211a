"""Means on other cells, by hand."""

import numpy as np
import pytest

from contactstudy.domain.grid import on_cells


def test_means_on_fewer_and_on_more_cells() -> None:
    field = np.array([[1.0], [2.0], [4.0], [5.0]])
    assert on_cells(field, (2, 1)).ravel() == pytest.approx([1.5, 4.5])
    assert on_cells(field, (8, 1)).ravel() == pytest.approx([1, 1, 2, 2, 4, 4, 5, 5])
    # thirds of four cells: 1 and a third of 2; two thirds of 2 and of 4; a third of 4 and 5
    thirds = np.array([1 + 2 / 3, (2 + 4) * 2 / 3, 4 / 3 + 5]) / (4 / 3)
    assert on_cells(field, (3, 1)).ravel() == pytest.approx(thirds)
    assert on_cells(field, (4, 1)) is field

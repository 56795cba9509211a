"""Products and sums of fields, by hand."""

import numpy as np
import pytest

from contactstudy.domain.devices.arrays import inner, mean_over, product, total

A = np.array([[1.0, -2.0, 3.0], [0.5, 4.0, -1.0]])
B = np.array([[2.0, 5.0, -1.0], [8.0, 0.25, 3.0]])


def test_sums_are_over_all_cells() -> None:
    assert inner(A, B) == 2 - 10 - 3 + 4 + 1 - 3
    assert total(A) == 5.5
    # more cells than are summed at once
    many = np.arange(2048.0).reshape(32, 64)
    assert inner(many, many) == 2047 * 2048 * 4095 / 6
    assert total(many) == 2047 * 1024


def test_a_mean_is_over_the_cells_that_are_chosen() -> None:
    cells = np.array([[1.0, 0, 1], [0, 0, 1]])
    assert mean_over(cells, A * cells) == 1


def test_a_product_is_that_of_matrices() -> None:
    assert product(A, B.T) == pytest.approx(np.array([[-11, 16.5], [22, 2]]))

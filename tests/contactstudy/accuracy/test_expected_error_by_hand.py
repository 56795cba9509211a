"""The law of a smooth contact's error by its factors and powers."""

from math import inf, pi, sqrt

import pytest

from contactstudy.accuracy.contact_edge import worst_edge_error
from contactstudy.accuracy.expected_error import smooth_l1


def test_the_pressure_errs_by_both_edges_and_the_square_of_the_cell() -> None:
    law = 2 * sqrt(2) * worst_edge_error() / (pi / 2) * 0.1**1.5 + 0.1 * 0.1**2
    assert smooth_l1(0.1) == pytest.approx(law)
    assert smooth_l1(1e101) == inf

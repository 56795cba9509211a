"""The uncertainty of a contact area, counted by hand."""

import math

import numpy as np
import pytest

from contactstudy.accuracy.contact_edge import EDGE_RANGE, edge_position
from contactstudy.accuracy.discretisation import ALL, EACH, HALF, contact_area

OPEN, CLOSED = (False, False), (True, True)
RISING = [0.0, 1.0, 2.0, 3.0, 4.0, 3.5, 2.5, 1.5, 0.0]  # two ends, 7 cells that touch


def relative(cells: float, touching: int) -> float:
    """Over the area that may be left."""
    return cells / (touching - cells)


def beyond(last: float, inner: float) -> float:
    """How much of the last cell the contact leaves free."""
    return 0.5 - float(edge_position(np.array([last]), np.array([inner]))[0])


def test_both_ends_of_a_row_add_up_with_their_signs() -> None:
    assert (ALL, EACH, HALF) == (0.1, 0.35, 0.65)
    ends = beyond(1.0, 2.0) + beyond(1.5, 2.5)
    expected = relative(abs(ends) + 0.1 * 2 + 0.35 * 2**0.5, 7)
    assert contact_area(np.array([RISING]).T, OPEN) == pytest.approx(expected, rel=1e-12)
    # the grid's own edge ends nothing
    cut = relative(abs(beyond(1.5, 2.5)) + 0.1 + 0.35, 7)
    assert contact_area(np.array([RISING[1:]]).T, OPEN) == pytest.approx(cut, rel=1e-12)
    wrapped = np.roll(RISING, 5)
    assert contact_area(wrapped[:, None], CLOSED) == pytest.approx(expected, rel=1e-12)


def test_the_axis_that_tells_more_counts() -> None:
    """Three rows beside each other: six ends along them; across, where each row is as its neighbour, none."""
    three = np.repeat(np.array([RISING]), 3, axis=0)
    ends = 3 * (beyond(1.0, 2.0) + beyond(1.5, 2.5))
    expected = relative(abs(ends) + 0.1 * 6 + 0.35 * 6**0.5, 21)
    assert contact_area(three, OPEN) == pytest.approx(expected, rel=1e-12)
    assert contact_area(three.T, OPEN) == pytest.approx(expected, rel=1e-12)


def test_a_plateau_may_end_anywhere_in_its_last_cell() -> None:
    flat = np.array([[0.0, 2.0, 2.0, 2.0, 2.0, 2.0, 0.0]]).T
    assert contact_area(flat, OPEN) == pytest.approx(relative(2 * 0.65, 5), rel=1e-12)


def test_cells_that_touch_alone_end_in_the_middle_of_what_can_be() -> None:
    """Four far apart among a wide contact: each has two ends."""
    row = np.zeros(60)
    row[[2, 4, 6, 8]] = 1.0
    row[12:50] = 3.0
    single = 8 * (0.5 - sum(EDGE_RANGE) / 2)
    expected = relative(abs(single) + 0.1 * 8 + 0.35 * 8**0.5 + 2 * 0.65, 42)
    assert contact_area(row[:, None], OPEN) == pytest.approx(expected, rel=1e-12)


def test_where_no_area_may_be_left_the_error_has_no_bound() -> None:
    assert contact_area(np.array([[0.0, 1.0, 0.0]]).T, OPEN) == math.inf

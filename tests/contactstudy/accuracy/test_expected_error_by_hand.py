"""The law of a smooth contact's error by its factors and powers."""

from math import inf, pi, sqrt

import pytest

import contactstudy as cs
from contactstudy.accuracy.contact_edge import worst_edge_error
from contactstudy.accuracy.expected_error import Edges, HertzianContact, Metric, smooth_l1

# A half-width of 2, cells of a tenth of it.
CONTACT, GRID, EXACT = HertzianContact(2.0), cs.Grid((24, 24), (4.8, 4.8)), cs.ExactPeriodicity()


def parts(
    metric: Metric, edges: Edges = Edges.AS_SOLVED, *, cells: int = 24, tolerance: float = 1e-8,
    padding: cs.Padding = EXACT,
) -> tuple[float, float]:  # fmt: skip
    grid = cs.Grid((cells, 24), (4.8, 4.8))
    found = CONTACT.error(metric, edges, grid, padding, tolerance)
    return found.discretisation, found.residual


def test_the_peak_errs_by_the_parabola_the_mean_and_the_edges() -> None:
    assert parts(Metric.PEAK_PRESSURE) == pytest.approx(((1 / 8 - 1 / 24 + 1 / 16) / 100, 8e-8))


def test_the_half_width_errs_by_the_cube_of_the_cell_where_24_cells_touch() -> None:
    assert parts(Metric.HALF_WIDTH) == pytest.approx((0.1, 60e-8))
    # 24 cells in contact on 28.8 of 2.4 half-widths
    assert parts(Metric.HALF_WIDTH, cells=29) == pytest.approx((0.05 * (2.4 / 29) ** 3, 60e-8))
    assert parts(Metric.HALF_WIDTH, cells=28)[0] == pytest.approx(2.4 / 28)
    windowed = parts(Metric.HALF_WIDTH, cells=48, padding=cs.Superposition(1))
    assert windowed[0] == pytest.approx(0.05)


def test_the_pressure_errs_by_both_edges_and_a_corrected_one_by_the_square_of_the_cell() -> None:
    law = 2 * sqrt(2) * worst_edge_error() / (pi / 2) * 0.1**1.5 + 0.1 * 0.1**2
    assert smooth_l1(0.1) == pytest.approx(law)
    assert parts(Metric.L1) == pytest.approx((law, 20e-8))
    # too few cells in contact to be corrected
    assert parts(Metric.L1, Edges.CORRECTED) == pytest.approx((law, 20e-8))
    assert parts(Metric.L1, Edges.CORRECTED, cells=48) == pytest.approx((0.1 * 0.05**2, 80e-8))


def test_a_tolerance_that_does_not_tell_which_cells_touch_promises_nothing() -> None:
    largest = 1e-3 * 0.1**1.5
    assert parts(Metric.L1, tolerance=0.99 * largest)[1] == pytest.approx(20 * 0.99 * largest)
    assert parts(Metric.L1, tolerance=1.01 * largest)[1] == inf
    assert smooth_l1(1e101) == inf

"""The error by images left out of a pressure whose half-width is known: two rows half a cell from the axis."""

from math import log, pi, sqrt

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.truncation import truncation

FREE = cs.ZeroPadding()


def pressed(rows: int = 4, along: object = 1.0) -> tuple[np.ndarray, cs.Grid]:
    """Cells of 1 m, of which two across bear; twice the root mean square of their places is 1 m."""
    pressure = np.zeros((8, rows))
    pressure[3:5] = along
    return pressure, cs.Grid((8, rows), (8.0, float(rows)))


def narrower(*reaches: float) -> float:
    """A half-width of 1 m: ``1 + a^2 / (4 D^2)`` of the mean of the inverse squares, as the root."""
    return sqrt(1 + np.mean([1 / reach**2 for reach in reaches]) / 4) - 1


@pytest.mark.parametrize(
    ("padding", "rows", "reaches"),
    [
        # an even number of cells lies half a cell further on one side
        (cs.CircularSuperposition(1), 4, (6.5, 5.5)),
        (cs.CircularSuperposition(1), 3, (4.5,)),
        (cs.CircularSuperposition(6), 4, (26.5, 25.5)),
        (cs.DuplicatedPadding(), 4, (4.5, 3.5)),
    ],
    ids=str,
)
def test_a_window_about_the_observer_narrows_the_contact_alone(
    padding: cs.Padding, rows: int, reaches: tuple[float, ...]
) -> None:
    pressure, grid = pressed(rows)
    peak, l1 = truncation(pressure, grid, (FREE, padding))
    assert peak == pytest.approx(narrower(*reaches), rel=1e-9)
    assert l1 == pytest.approx(4 / pi * narrower(*reaches), rel=1e-9)
    # axes may be swapped
    turned = cs.Grid(grid.cells[::-1], grid.extent[::-1])
    assert truncation(pressure.T, turned, (padding, FREE)) == pytest.approx((peak, l1))


def kink(odd: int) -> float:
    """Of a row so many half cells from the end, of four; a period of 4 m and three periods."""
    return 1 + 2 / pi / 4 * log(4 / odd) / 9


def test_a_window_about_the_domain_raises_its_ends_too() -> None:
    shape = np.array([kink(1), kink(3), kink(3), kink(1)])
    mean = 0.5 * 0.25**0.7 / 9
    for along, risen in ((shape, kink(1)), (1.0, kink(3)), ([0.5, 1, 1, 0.5], kink(3))):
        pressure, grid = pressed(4, along)
        peak, l1 = truncation(pressure, grid, (FREE, cs.Superposition(1)))
        assert peak == pytest.approx((1 + narrower(6.0)) * risen - 1, rel=1e-9)
        assert l1 == pytest.approx(4 / pi * narrower(6.0) + mean, rel=1e-9)


def test_without_images_the_load_at_the_ends_tells() -> None:
    pressure, grid = pressed(4, [2.0, 1.0, 1.0, 2.0])
    peak, l1 = truncation(pressure, grid, (FREE, FREE))
    # two for one and a half in the mean, and all a third astray; a reach of half a period
    assert peak == pytest.approx((1 + narrower(2.0)) * 4 / 3 - 1)
    assert l1 == pytest.approx(4 / pi * narrower(2.0) + 1 / 3)
    low, _ = truncation(pressed(4, [1.0, 2.0, 2.0, 1.0])[0], grid, (FREE, FREE))
    assert low == pytest.approx(narrower(2.0))
    inside, _ = pressed(4, [0.0, 2.0, 1.0, 0.0])
    assert truncation(inside, grid, (FREE, FREE)) == (0.0, 0.0)
    assert truncation(pressure, grid, (FREE, cs.ExactPeriodicity())) == (0.0, 0.0)
    one_end, _ = pressed(4, [0.0, 2.0, 1.0, 1.0])
    assert truncation(one_end, grid, (FREE, FREE))[0] > 0

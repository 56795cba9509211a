"""The discrete edge law, against a half-line of cells summed one by one and against its own far field."""

import numpy as np
import pytest

from contactstudy.accuracy.contact_edge import (
    MODES,
    modes,
    offset,
    powers,
)


def logarithm(steps: np.ndarray) -> np.ndarray:
    """``-int ln|x| dx`` over the unit cell at a whole number of steps."""
    ends = np.stack([steps - 0.5, steps + 0.5])
    low, high = ends * (1 - np.log(np.abs(ends)))
    return np.asarray(high - low)


def test_cells_under_the_first_mode_s_derivative_stay_level() -> None:
    """Its jump at the edge aside, the half-line of loads w moves the touching cells 1, 2 ... not at all.

    w falls like j^-3/2 and a step of the logarithm like 1/j, so the sum cut off at n is out by n^-3/2.
    """
    n = 4000
    w = np.diff(modes(n)[:, 0], prepend=0.0)
    i = np.arange(1, 6)[:, None]
    steps = i - np.arange(n)
    slope = ((logarithm(steps) - logarithm(steps + 1)) * w).sum(axis=1)
    np.testing.assert_allclose(slope, 0, rtol=0, atol=n**-1.5)
    # and it is not that nothing moves: outside the contact the gap opens
    outside = ((logarithm(steps - 7) - logarithm(steps - 6)) * w).sum(axis=1)
    assert np.abs(outside).min() > 100 * n**-1.5


@pytest.mark.parametrize("mode", [1, 2, 3, 4])
def test_modes_tend_to_their_powers(mode: int) -> None:
    """Cells lie p''/24 below the continuous pressure; what is left falls like d^-5/2, times d^(mode - 2).

    A logarithm goes with it, which over these d looks like less than half a power.
    """
    d = np.array([20.0, 40.0, 80.0]) + offset()
    q = np.arange(MODES + 1)[:, None] - 1.5
    amplitude = powers()[:, mode - 1]
    continuous = amplitude @ (d**q - q * (q - 1) * d ** (q - 2) / 24)
    left = np.abs(modes(81)[[20, 40, 80], mode - 1] - continuous)
    rate = max(mode, 2) - 4.5
    assert left[0] < d[0] ** rate
    assert np.polyfit(np.log(d), np.log(left), 1)[0] < rate + 0.5


LAST, INNER = np.array([0.3, 0.9, 1.4, 2.0]), np.array([1.0, 1.5, 2.0, 2.5])

import mpmath as mp
import numpy as np
import pytest
from numpy.testing import assert_array_equal
from numpy.typing import ArrayLike

from contactstudy.elasticity.kernels.displacement_periodic import (
    FOURIER_END,
    FOURIER_START,
    boussinesq_cell_periodic,
)
from tests.contactstudy.elasticity.kernels.test_cell import (
    EXACT,
    TOLERANCE_DIGITS,
    corners,
    love,
)
from tests.fifty_digits import over_decades, stored

TAIL_IMAGES, TAIL_TERMS = 9, 12  # the judge's own: what it leaves out is below 1e-18
with mp.workdps(TOLERANCE_DIGITS):
    MIDPOINT_WEIGHTS = [(n, mp.bernpoly(n, mp.mpf(1) / 2) / (n * (n - 1))) for n in range(2, 2 * TAIL_TERMS + 1, 2)]


def love_summed(x: mp.mpf, y: mp.mpf) -> mp.mpf:
    """Integral of ``love`` over y > 0."""
    sideways = x * y * mp.asinh(y / abs(x)) if x else mp.mpf(0)
    return sideways + y * y / 2 * mp.asinh(x / y) - x * mp.hypot(x, y) / 2


def love_derivatives(x: mp.mpf, y: mp.mpf) -> mp.mpf:
    """Odd derivatives of ``love`` along y > 0, times the Euler-Maclaurin weights of the midpoint rule."""
    # Taylor coefficients about y: of 1/r (Legendre), of -x / (y r), and so of asinh(x / y), the slope
    square = x * x + y * y
    before, reciprocal, slope = mp.mpf(0), 1 / mp.sqrt(square), mp.mpf(0)
    taylor = [mp.asinh(x / y)]
    for n in range(2 * TAIL_TERMS - 2):
        slope = (-x * reciprocal - slope) / y
        taylor.append(slope / (n + 1))
        following = -((2 * n + 1) * y * reciprocal + n * before) / ((n + 1) * square)
        before, reciprocal = reciprocal, following
    return mp.fsum(weight * taylor[n - 2] for n, weight in MIDPOINT_WEIGHTS)


@stored
def judged_lattice(*arguments: float) -> mp.mpf:
    """Images summed one by one and the rest as an integral and its Euler-Maclaurin corrections.

    Takes none of the ways of the code: no zeta function, no Bessel function, no quadrature.
    """
    with mp.workdps(TOLERANCE_DIGITS):
        x, y, dx, dy, period = (mp.mpf(a) for a in arguments)
        y -= mp.nint(y / period) * period
        x, y, dx, dy = (a / period for a in (x, y, dx, dy))
        images = range(-TAIL_IMAGES, TAIL_IMAGES + 1)
        total = mp.fsum(corners(love, x, y + m, dx, dy) for m in images)
        right, left = (e * mp.log(abs(e)) if e else 0 for e in (x + dx / 2, x - dx / 2))
        total += 2 * dy * (dx - (right - left))
        for side in (1, -1):
            beyond = side * y + TAIL_IMAGES + 0.5
            total -= corners(love_summed, x, beyond, dx, dy)
            total -= corners(love_derivatives, x, beyond, dx, dy)
        return period * (total - 2 * dx * dy * mp.log(period))


def lattice_error(x: ArrayLike, y: ArrayLike, dx: ArrayLike, dy: ArrayLike, period: ArrayLike) -> float:
    """Largest error of ``boussinesq_cell_periodic`` in units of max(|S|, dx dy / period)."""
    points = list(np.broadcast(x, y, dx, dy, period))
    found = boussinesq_cell_periodic(x, y, dx, dy, period).ravel()
    judged = [judged_lattice(*p) for p in points]
    error = np.array([float(f - j) for f, j in zip(found, judged, strict=True)])
    fraction = np.array([dx * dy / period for _, _, dx, dy, period in points])
    return float((np.abs(error) / np.maximum(np.abs(np.array(judged, float)), fraction)).max())


# (dx, dy) in periods
CELLS = [
    (1e-6, 1e-6), (1e-6, 1.0), (0.01, 0.02), (0.3, 0.7), (1.0, 1.0), (1.001, 1e-3), (30.0, 1e-2), (1e6, 1.0),
]  # fmt: skip


@pytest.mark.parametrize(
    ("across", "width", "length"),
    [
        ((-7, 0), (-6, 0), (-6, 0)), ((-1, 1), (-6, 0), (-6, 0)), ((0, 4), (-6, 0), (-6, 0)),
        ((-3, 4), (0, 3), (-6, 0)), ((-3, 6), (3, 6), (-6, 0)), ((-7, 4), (-6, 3), (0, 0)),
    ],
    ids=["near", "handover", "far", "wide", "very wide", "one per period"],
)  # fmt: skip
def test_lattice_is_exact(across: tuple[int, int], width: tuple[int, int], length: tuple[int, int]) -> None:
    rng = np.random.default_rng(4)
    x, dx, dy = (over_decades(rng, *ends, 20) for ends in (across, width, length))
    y, period = rng.random(20) - 0.5, over_decades(rng, -3, 3, 20)
    assert lattice_error(x * period, y * period, dx * period, dy * period, period) < EXACT


@pytest.mark.parametrize(("dx", "dy"), CELLS)
def test_lattice_is_exact_on_edges_and_corners(dx: float, dy: float) -> None:
    x = np.array([0, 0.5, 0.5 + 1e-9, 2.5])[:, None] * dx
    y = np.array([0, 0.5 * dy, 0.3])
    assert lattice_error(x, y, dx, dy, 1.0) < EXACT


@pytest.mark.parametrize(("width", "length"), [((-6, 0), (-6, 0)), ((-6, 0), (0, 0)), ((0, 3), (-6, 0))])
def test_lattice_is_exact_beside_edges_and_corners(width: tuple[int, int], length: tuple[int, int]) -> None:
    """Off the grid and of no special period: to round a place there costs a thin cell up to 1e-9."""
    rng = np.random.default_rng(7)
    period, dx, dy = (over_decades(rng, *ends, 15) for ends in ((-3, 3), width, length))
    dx, dy = dx * period, dy * period
    away = over_decades(rng, -16, 0, 30).reshape(2, 15) * rng.choice([-1, 1], (2, 15))
    beside, inside = away * np.minimum(dx, dy), rng.random(15) - 0.5
    assert lattice_error(dx / 2 + beside[0], inside * dy, dx, dy, period) < EXACT
    assert lattice_error(inside * dx, dy / 2 + beside[1], dx, dy, period) < EXACT
    assert lattice_error(dx / 2 + beside[0], dy / 2 + beside[1], dx, dy, period) < EXACT


@pytest.mark.parametrize("dx", [1.1, 1.7, 3.7, 1100.0])
def test_no_seam_of_a_wide_cell_is_seen(dx: float) -> None:
    parts = np.array([0, 1 / 4, 1 / 6, 1 / 10, 1 / 14])
    assert lattice_error(parts[:, None] * dx, [0.0, 0.5e-6], dx, 1e-6, 1.0) < EXACT


@pytest.mark.parametrize(("dx", "dy"), CELLS)
def test_forms_of_the_lattice_meet(dx: float, dy: float) -> None:
    """Each form is exact up to where it hands over to the next: an end of the cell at these places."""
    ends = np.array([FOURIER_START, FOURIER_END, -FOURIER_END])
    x = np.abs(ends[:, None] * (1 + np.array([-1e-12, 1e-12])) + dx / 2)
    assert lattice_error(x.reshape(-1, 1), np.array([0.0, 0.5 * dy]), dx, dy, 1.0) < EXACT


def test_forms_of_the_lattice_meet_at_a_cell_as_wide_as_the_period() -> None:
    dx = np.array([np.nextafter(1, 0), 1.0, np.nextafter(1, 2)])
    x, y = np.array([0, 0.3, 0.5, 1.0, 3.0])[:, None, None], np.array([0, 0.4])[:, None]
    assert lattice_error(x, y, dx, 0.1, 1.0) < EXACT


@pytest.mark.parametrize("dy", [1e-6, 1e-3, 0.3])
def test_lattice_is_exact_many_periods_away(dy: float) -> None:
    periods = np.array([-1e5, -7, 1, 2, 1000])[:, None]
    y = (periods + np.array([-1.5 * dy, -1e-7, 0, dy / 2, 0.5])) * 1.1
    assert lattice_error(1e-6, y.ravel(), 1e-5, dy, 1.1) < EXACT


@pytest.mark.parametrize(("dx", "dy"), CELLS)
def test_lattice_is_even_and_repeats_to_the_last_bit(dx: float, dy: float) -> None:
    # binary fractions, so that whole periods can be added without rounding
    x, y = np.array([0, 0.125, 0.75, 8])[:, None], np.array([0, 2**-20, 0.25, 0.4375, 0.5])
    expected = boussinesq_cell_periodic(x, y, dx, dy, 1.0)
    for same in ((-x, y), (x, 1 - y), (-x, y - 4096)):
        assert_array_equal(boussinesq_cell_periodic(*same, dx, dy, 1.0), expected)

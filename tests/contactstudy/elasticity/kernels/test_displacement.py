"""Displacement by one cell, a row of cells and a lattice of them, beside fifty digits."""

from collections.abc import Callable

import mpmath as mp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike

from contactstudy.elasticity.kernels.displacement import (
    FAR_DISTANCE,
    FOURIER_END,
    FOURIER_START,
    NEAR_DISTANCE,
    boussinesq_cell,
    boussinesq_cell_doubly_periodic,
    boussinesq_cell_periodic,
)

Corner = Callable[[mp.mpf, mp.mpf], mp.mpf]

EPS = float(np.finfo(np.float64).eps)
EXACT = 1e-13  # what the docstrings promise
TOLERANCE_DIGITS = 50  # of the judge: Love's formula loses up to 22 at 1e8 cells of aspect 1e3
TAIL_IMAGES, TAIL_TERMS = 9, 12  # the judge's own: what it leaves out is below 1e-18
with mp.workdps(TOLERANCE_DIGITS):
    MIDPOINT_WEIGHTS = [(n, mp.bernpoly(n, mp.mpf(1) / 2) / (n * (n - 1))) for n in range(2, 2 * TAIL_TERMS + 1, 2)]


def love(x: mp.mpf, y: mp.mpf) -> mp.mpf:
    """Love (1929): one corner of the integral of 1/r."""
    return x * mp.asinh(y / abs(x)) + y * mp.asinh(x / abs(y)) if x and y else mp.mpf(0)


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


def over_decades(rng: np.random.Generator, low: float, high: float, size: int) -> np.ndarray:
    """Numbers from ``10**low`` to ``10**high``, as many in each octave, the same on every processor."""
    octaves = [int(decade * np.log2(10)) for decade in (low, high)]
    return np.ldexp(1 + rng.random(size), rng.integers(octaves[0], max(octaves[1], octaves[0] + 1), size))


def corners(f: Corner, x: mp.mpf, y: mp.mpf, dx: mp.mpf, dy: mp.mpf) -> mp.mpf:
    right, left, upper, lower = x + dx / 2, x - dx / 2, y + dy / 2, y - dy / 2
    return f(right, upper) - f(left, upper) - f(right, lower) + f(left, lower)


def judged_cell(*arguments: float) -> mp.mpf:
    with mp.workdps(TOLERANCE_DIGITS):
        return corners(love, *(mp.mpf(a) for a in arguments))


def judged_lattice(*arguments: float) -> mp.mpf:
    """A row: images summed one by one and the rest as an integral and its Euler-Maclaurin corrections.

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


def judged_double_lattice(x: float, y: float, dx: float, dy: float, width: float, period: float) -> mp.mpf:
    """Rows one by one, and the logarithms of all others as an integral of Gamma functions."""
    rows = int(np.ceil(7 * period / width)) + 1  # exp(-14 pi) is left
    with mp.workdps(TOLERANCE_DIGITS):
        x, width = mp.mpf(x), mp.mpf(width)

        def others(u: mp.mpf) -> mp.mpf:
            return mp.loggamma(rows + 1 + u / width) + mp.loggamma(rows + 1 - u / width)

        total = mp.fsum(judged_lattice(x + m * width, y, dx, dy, period) for m in range(-rows, rows + 1))
        mean = mp.quad(others, [x - dx / 2, x + dx / 2]) / dx
        shift = (2 * rows + 1) * mp.log(width) - mp.log(2 * mp.pi)
        return total + 2 * mp.mpf(dx) * dy / period * (shift + mean)


def error(kernel: Callable[..., np.ndarray], judged: Callable[..., mp.mpf], *places: ArrayLike) -> float:
    """Largest error of a kernel relative to the larger of the judged value and the cell over its last argument."""
    points = list(np.broadcast(*places))
    exact = [judged(*point) for point in points]
    off = np.array([float(kernel(*point).item() - e) for point, e in zip(points, exact, strict=True)])
    fraction = [dx * dy / min(periods) if periods else 0.0 for _, _, dx, dy, *periods in points]
    return float((np.abs(off) / np.maximum(np.abs(np.array(exact, float)), fraction)).max())


def cell_error(*places: ArrayLike) -> float:
    return error(boussinesq_cell, judged_cell, *places)


def row_error(*places: ArrayLike) -> float:
    return error(boussinesq_cell_periodic, judged_lattice, *places)


ASPECTS = [1e-3, 0.0307, 1 / 3, 1.0, np.pi, 1e3]
# steps off the centre: on, beside and along the edges and corners, and across the joins of the zones
STEPS = np.array(
    [0, 1e-20, 1e-8, 0.25, 0.5 - 1e-16, 0.5, 0.5 + 1e-16, 0.5 - 1e-6, 0.5 + 1e-6, 1, 1.5]
    + [np.nextafter(zone, side) for zone in (NEAR_DISTANCE, 40.0) for side in (0, zone, np.inf)]
    + [3, 1e4, 1e8]
)


def test_a_cell_is_exact_at_any_distance_and_aspect() -> None:
    rng = np.random.default_rng(1)
    steps_x, steps_y, dy = (over_decades(rng, *ends, 1000) for ends in ((-3, 8), (-3, 8), (-3, 3)))
    assert cell_error(steps_x, steps_y * dy, 1.0, dy) < EXACT


@pytest.mark.parametrize("aspect", ASPECTS)
def test_a_cell_is_exact_on_edges_and_corners_and_where_zones_join_and_even_to_the_last_bit(aspect: float) -> None:
    x, y = STEPS[:, None], STEPS[None] * aspect
    assert cell_error(x, y, 1.0, aspect) < EXACT
    assert_array_equal(boussinesq_cell(-x, -y, 1.0, aspect), boussinesq_cell(x, y, 1.0, aspect))
    for begin in (2 * NEAR_DISTANCE, FAR_DISTANCE):
        ends = np.array([0, 1 - 1e-9, 1 - EPS, 1 + EPS, 1 + 1e-9, 2]) * begin
        away = float(mp.hypot(0.5, aspect / 2)) * ends[:, None]
        cosines = np.array([float(mp.cospi(mp.mpf(k) / 16)) for k in range(9)])
        assert cell_error(away * cosines, away * cosines[::-1], 1.0, aspect) < EXACT


# (dx, dy) in periods
CELLS = [
    (1e-6, 1e-6), (1e-6, 1.0), (0.01, 0.02), (0.3, 0.7), (1.0, 1.0), (1.001, 1e-3), (30.0, 1e-2), (1e6, 1.0),
]  # fmt: skip


@pytest.mark.parametrize(
    ("across", "width", "length"),
    [
        ((-7, 0), (-6, 0), (-6, 0)), ((-1, 1), (-6, 0), (-6, 0)), ((0, 4), (-6, 0), (-6, 0)),
        ((-3, 4), (0, 3), (-6, 0)), ((-7, 4), (-6, 3), (0, 0)),
    ],
    ids=["near", "handover", "far", "wide", "one per period"],
)  # fmt: skip
def test_a_row_is_exact(across: tuple[int, int], width: tuple[int, int], length: tuple[int, int]) -> None:
    rng = np.random.default_rng(4)
    x, dx, dy = (over_decades(rng, *ends, 20) for ends in (across, width, length))
    y, period = rng.random(20) - 0.5, over_decades(rng, -3, 3, 20)
    assert row_error(x * period, y * period, dx * period, dy * period, period) < EXACT


@pytest.mark.parametrize(("dx", "dy"), CELLS)
def test_a_row_is_exact_on_edges_and_corners_and_where_its_forms_meet(dx: float, dy: float) -> None:
    """Each form is exact up to where it hands over to the next: an end of the cell at these places.

    A row is even and repeats to the last bit.
    """
    on_edges = np.array([0, 0.5, 0.5 + 1e-9, 2.5])[:, None] * dx
    assert row_error(on_edges, np.array([0, 0.5 * dy, 0.3]), dx, dy, 1.0) < EXACT
    ends = np.array([FOURIER_START, FOURIER_END, -FOURIER_END])
    x = np.abs(ends[:, None] * (1 + np.array([-1e-12, 1e-12])) + dx / 2)
    assert row_error(x.reshape(-1, 1), np.array([0.0, 0.5 * dy]), dx, dy, 1.0) < EXACT
    x, y = np.array([[0.125], [8.0]]), np.array([2**-20, 0.4375])  # to which whole periods add without rounding
    expected = boussinesq_cell_periodic(x, y, dx, dy, 1.0)
    assert_array_equal(boussinesq_cell_periodic(-x, 1 - y, dx, dy, 1.0), expected)
    assert_array_equal(boussinesq_cell_periodic(x, y - 4096, dx, dy, 1.0), expected)


@pytest.mark.parametrize(("width", "length"), [((-6, 0), (-6, 0)), ((-6, 0), (0, 0)), ((0, 3), (-6, 0))])
def test_a_row_is_exact_beside_edges_and_corners(width: tuple[int, int], length: tuple[int, int]) -> None:
    """Off the grid and of no special period: to round a place there costs a thin cell up to 1e-9."""
    rng = np.random.default_rng(7)
    period, dx, dy = (over_decades(rng, *ends, 15) for ends in ((-3, 3), width, length))
    dx, dy = dx * period, dy * period
    away = over_decades(rng, -16, 0, 30).reshape(2, 15) * rng.choice([-1, 1], (2, 15))
    beside, inside = away * np.minimum(dx, dy), rng.random(15) - 0.5
    for x, y in (
        (dx / 2 + beside[0], inside * dy),
        (inside * dx, dy / 2 + beside[1]),
        (dx / 2 + beside[0], dy / 2 + beside[1]),
    ):
        assert row_error(x, y, dx, dy, period) < EXACT


@pytest.mark.parametrize("dx", [1.1, 1.7, 3.7, 1100.0])
def test_no_seam_of_a_wide_cell_is_seen(dx: float) -> None:
    parts = np.array([0, 1 / 4, 1 / 6, 1 / 10, 1 / 14])
    assert row_error(parts[:, None] * dx, [0.0, 0.5e-6], dx, 1e-6, 1.0) < EXACT


@pytest.mark.parametrize(("nx", "ny"), [(1, 3), (300, 200), (8, 1)])
@pytest.mark.parametrize(("width", "period"), [(1.2, 0.8), (3.0, 0.05), (900.0, 700.0)])
def test_a_lattice_is_exact_and_repeats(width: float, period: float, nx: int, ny: int) -> None:
    cell = width / nx, period / ny, width, period
    x, y = np.array([0, 0.5, 0.21, 0.5]) * width, np.array([0, 0.1, 0.37, 0.5]) * period
    assert error(boussinesq_cell_doubly_periodic, judged_double_lattice, x, y, *cell) < EXACT
    computed = boussinesq_cell_doubly_periodic(x, y, *cell)
    assert_allclose(boussinesq_cell_doubly_periodic(-x - 2 * width, y - period, *cell), computed, rtol=1e-12)

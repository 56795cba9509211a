from collections.abc import Callable

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike

from contactstudy.elasticity.kernels.displacement_cell import (
    FAR_DISTANCE,
    MIDDLE_DISTANCE,
    NEAR_DISTANCE,
    boussinesq_cell,
)
from tests.fifty_digits import over_decades, stored

Corner = Callable[[mp.mpf, mp.mpf], mp.mpf]

EPS = float(np.finfo(np.float64).eps)
EXACT = 1e-13  # what the docstrings promise
TOLERANCE_DIGITS = 50  # of the judge: Love's formula loses up to 22 at 1e8 cells of aspect 1e3

offsets = st.floats(-100, 100)
lengths = st.floats(0.03, 30)


def love(x: mp.mpf, y: mp.mpf) -> mp.mpf:
    """Love (1929): one corner of the integral of 1/r."""
    return x * mp.asinh(y / abs(x)) + y * mp.asinh(x / abs(y)) if x and y else mp.mpf(0)


def corners(f: Corner, x: mp.mpf, y: mp.mpf, dx: mp.mpf, dy: mp.mpf) -> mp.mpf:
    right, left, upper, lower = x + dx / 2, x - dx / 2, y + dy / 2, y - dy / 2
    return f(right, upper) - f(left, upper) - f(right, lower) + f(left, lower)


@stored
def judged_cell(*arguments: float) -> mp.mpf:
    with mp.workdps(TOLERANCE_DIGITS):
        return corners(love, *(mp.mpf(a) for a in arguments))


def cell_error(x: ArrayLike, y: ArrayLike, dx: ArrayLike, dy: ArrayLike) -> float:
    """Largest relative error of ``boussinesq_cell``."""
    points = list(np.broadcast(x, y, dx, dy))
    found = boussinesq_cell(x, y, dx, dy).ravel()
    relative = [float(f / judged_cell(*p) - 1) for f, p in zip(found, points, strict=True)]
    return float(np.abs(relative).max())


ASPECTS = [1e-3, 0.0307, 1 / 3, 1.0, np.pi, 1e3]
# steps off the centre: on, beside and along the edges and corners, and across the joins of the zones
STEPS = np.array(
    [0, 1e-20, 1e-8, 0.25, 0.5 - 1e-16, 0.5, 0.5 + 1e-16, 0.5 - 1e-6, 0.5 + 1e-6, 1, 1.5]
    + [np.nextafter(zone, side) for zone in (NEAR_DISTANCE, 40.0) for side in (0, zone, np.inf)]
    + [3, 1e4, 1e8]
)


def test_coefficient_is_exact_at_any_distance_and_aspect() -> None:
    rng = np.random.default_rng(1)
    steps_x, steps_y, dy = (over_decades(rng, *ends, 1000) for ends in ((-3, 8), (-3, 8), (-3, 3)))
    assert cell_error(steps_x, steps_y * dy, 1.0, dy) < EXACT


@pytest.mark.parametrize("steps", [3.0, 50.0])
def test_coefficient_is_exact_off_the_grid(steps: float) -> None:
    rng = np.random.default_rng(2)
    dy = over_decades(rng, -3, 3, 500)
    x, y = steps * (2 * rng.random((2, 500)) - 1)
    assert cell_error(x, y * dy, 1.0, dy) < EXACT


@pytest.mark.parametrize("aspect", ASPECTS)
def test_coefficient_is_exact_on_edges_and_corners_and_between_zones(aspect: float) -> None:
    assert cell_error(STEPS[:, None], STEPS[None] * aspect, 1.0, aspect) < EXACT


@pytest.mark.cases(100)
@pytest.mark.parametrize("aspect", ASPECTS)
@pytest.mark.parametrize("begin", [MIDDLE_DISTANCE, FAR_DISTANCE])
def test_coefficient_is_exact_where_multipoles_begin(begin: float, aspect: float) -> None:
    ends = np.array([0, 1 - 1e-9, 1 - EPS, 1 + EPS, 1 + 1e-9, 2]) * begin
    away = float(mp.hypot(0.5, aspect / 2)) * ends[:, None]
    cosines = np.array([float(mp.cospi(mp.mpf(k) / 16)) for k in range(9)])
    assert cell_error(away * cosines, away * cosines[::-1], 1.0, aspect) < 16 * EPS


@pytest.mark.parametrize("aspect", ASPECTS)
def test_coefficient_is_even_to_the_last_bit(aspect: float) -> None:
    x, y = STEPS[:, None], STEPS[None] * aspect
    expected = boussinesq_cell(x, y, 1.0, aspect)
    for mirrored in ((-x, y), (x, -y), (-x, -y)):
        assert_array_equal(boussinesq_cell(*mirrored, 1.0, aspect), expected)


@given(offsets, offsets, lengths, lengths, st.integers(-300, 300))
def test_coefficient_is_a_length(x: float, y: float, dx: float, dy: float, power: int) -> None:
    # a power of two rounds nothing
    x, y = (np.round(a, 3) for a in (x, y))
    scaled = boussinesq_cell(*(np.ldexp(a, power) for a in (x, y, dx, dy)))
    assert_allclose(scaled, np.ldexp(boussinesq_cell(x, y, dx, dy), power), rtol=EPS)

"""The coefficients of a cell, against 50 digits and against what they must obey."""

import json
from collections.abc import Callable
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike, NDArray

from contactstudy.elasticity.kernels.displacement_cell import (
    FAR_DISTANCE,
    MIDDLE_DISTANCE,
    NEAR_DISTANCE,
    boussinesq_cell,
)
from tests.fifty_digits import stored

Array = NDArray[np.float64]
Corner = Callable[[mp.mpf, mp.mpf], mp.mpf]

REFERENCE = json.loads(
    (Path(__file__).parents[3] / "reference/influence_coefficients.json").read_text(
        encoding="utf-8"
    )
)
EPS = float(np.finfo(np.float64).eps)
EXACT = 1e-13  # what the docstrings promise
TOLERANCE_DIGITS = 50  # of the judge: Love's formula loses up to 22 at 1e8 cells of aspect 1e3

offsets = st.floats(-100, 100)
lengths = st.floats(0.03, 30)


# --- the judge -------------------------------------------------------------------------------------


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


def column(table: str, name: str) -> Array:
    return np.array([float(row[name]) for row in REFERENCE[table]])


# --- the cell --------------------------------------------------------------------------------------

ASPECTS = [1e-3, 0.0307, 1 / 3, 1.0, np.pi, 1e3]
# steps off the centre: on, beside and along the edges and corners, and across the joins of the zones
STEPS = np.array(
    [0, 1e-20, 1e-8, 0.25, 0.5 - 1e-16, 0.5, 0.5 + 1e-16, 0.5 - 1e-6, 0.5 + 1e-6, 1, 1.5]
    + [np.nextafter(zone, side) for zone in (NEAR_DISTANCE, 40.0) for side in (0, zone, np.inf)]
    + [3, 1e4, 1e8]
)


def test_cell_has_its_reference_values() -> None:
    found = boussinesq_cell(*(column("love", name) for name in ("x", "y", "dx", "dy")))
    assert_allclose(found, column("love", "I"), rtol=EXACT)


def test_coefficient_is_exact_at_any_distance_and_aspect() -> None:
    rng = np.random.default_rng(1)
    steps_x, steps_y, dy = (10 ** rng.uniform(*ends, 1000) for ends in ((-3, 8), (-3, 8), (-3, 3)))
    assert cell_error(steps_x, steps_y * dy, 1.0, dy) < EXACT


@pytest.mark.parametrize("steps", [3.0, 50.0])
def test_coefficient_is_exact_off_the_grid(steps: float) -> None:
    rng = np.random.default_rng(2)
    dy = 10 ** rng.uniform(-3, 3, 500)
    x, y = rng.uniform(-steps, steps, (2, 500))
    assert cell_error(x, y * dy, 1.0, dy) < EXACT


@pytest.mark.parametrize("aspect", ASPECTS)
def test_coefficient_is_exact_on_edges_and_corners_and_between_zones(aspect: float) -> None:
    assert cell_error(STEPS[:, None], STEPS[None] * aspect, 1.0, aspect) < EXACT


@pytest.mark.parametrize("aspect", ASPECTS)
@pytest.mark.parametrize("begin", [MIDDLE_DISTANCE, FAR_DISTANCE])
def test_coefficient_is_exact_where_multipoles_begin(begin: float, aspect: float) -> None:
    ends = np.array([0, 1 - 1e-9, 1 - EPS, 1 + EPS, 1 + 1e-9, 2]) * begin
    away = np.hypot(0.5, aspect / 2) * ends[:, None]
    angle = np.linspace(0, np.pi / 2, 9)
    assert cell_error(away * np.cos(angle), away * np.sin(angle), 1.0, aspect) < 16 * EPS


@pytest.mark.parametrize("aspect", [2**-10, 0.25, 1.0, 2**10])
@pytest.mark.parametrize(("parts_x", "parts_y"), [(1, 2), (2, 1), (4, 8), (32, 2)])
def test_parts_of_a_cell_add_up_to_it(parts_x: int, parts_y: int, aspect: float) -> None:
    # binary fractions all: a gap of one rounding between parts would show
    steps = np.array([0, 0.25, 0.5, 0.5625, 1, 1.5, 2.5, 3, 40, 1e4, 1e8])
    x, y = steps[:, None, None, None], steps[:, None, None] * aspect
    dx, dy = 1 / parts_x, aspect / parts_y
    centres_x = (np.arange(parts_x)[:, None] - (parts_x - 1) / 2) * dx
    centres_y = (np.arange(parts_y) - (parts_y - 1) / 2) * dy
    parts = boussinesq_cell(x + centres_x, y + centres_y, dx, dy).sum(axis=(2, 3))
    assert_allclose(parts, boussinesq_cell(x, y, 1.0, aspect)[..., 0, 0], rtol=32 * EPS)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_far_cell_is_a_point(aspect: float) -> None:
    angle = np.linspace(0, np.pi, 13)
    distance = np.geomspace(4, 1e8, 50)[:, None] * np.hypot(1, aspect)
    x, y = distance * np.cos(angle), distance * np.sin(angle)
    departure = boussinesq_cell(x, y, 1.0, aspect) * distance / aspect - 1
    # the second moments of the cell alone would give half this bound
    assert (np.abs(departure) <= (1 + aspect**2) / (6 * distance**2) + 8 * EPS).all()


@pytest.mark.parametrize("aspect", ASPECTS)
def test_coefficient_falls_along_every_ray(aspect: float) -> None:
    """As it must for a convex cell with a centre (Anderson 1955); no zone sticks out."""
    away = np.geomspace(1e-3, 1e3, 5000)[:, None]
    angle = np.linspace(0, np.pi / 2, 9)
    found = boussinesq_cell(away * np.cos(angle), aspect * away * np.sin(angle), 1.0, aspect)
    # 0.3 % apart, the coefficients differ by 1e-6 (about the centre) or more of themselves
    assert (np.diff(found, axis=0) < 0).all()
    assert (found[0] < boussinesq_cell(0.0, 0.0, 1.0, aspect)).all()


@pytest.mark.parametrize("aspect", ASPECTS)
def test_coefficient_is_even_to_the_last_bit(aspect: float) -> None:
    x, y = STEPS[:, None], STEPS[None] * aspect
    expected = boussinesq_cell(x, y, 1.0, aspect)
    for mirrored in ((-x, y), (x, -y), (-x, -y)):
        assert_array_equal(boussinesq_cell(*mirrored, 1.0, aspect), expected)


@given(offsets, offsets, lengths, lengths)
def test_axes_may_swap(x: float, y: float, dx: float, dy: float) -> None:
    swapped = boussinesq_cell(y, x, dy, dx)
    assert_allclose(swapped, boussinesq_cell(x, y, dx, dy), rtol=32 * EPS)


@given(offsets, offsets, lengths, lengths, st.integers(-300, 300))
def test_coefficient_is_a_length(x: float, y: float, dx: float, dy: float, power: int) -> None:
    # a power of two rounds nothing
    x, y = (np.round(a, 3) for a in (x, y))
    scaled = boussinesq_cell(*(np.ldexp(a, power) for a in (x, y, dx, dy)))
    assert_allclose(scaled, np.ldexp(boussinesq_cell(x, y, dx, dy), power), rtol=EPS)

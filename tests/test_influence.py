"""The coefficients of a cell, alone and repeated, against 50 digits and against what they must obey."""

import json
from collections.abc import Callable
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import dblquad, quad

from contactstudy.influence import (
    FAR,
    FOURIER_END,
    HANDOVER,
    NEAR,
    boussinesq_cell,
    boussinesq_cell_periodic,
)

Array = NDArray[np.float64]
Corner = Callable[[mp.mpf, mp.mpf], mp.mpf]

REFERENCE = json.loads(
    (Path(__file__).parent / "reference/influence_coefficients.json").read_text()
)
EPS = float(np.finfo(np.float64).eps)
EXACT = 1e-13  # what the docstrings promise
DIGITS = 50  # of the judge: Love's formula loses up to 22 at 1e8 cells of aspect 1e3
TAIL_IMAGES, TAIL_TERMS = 9, 12  # the judge's own: what it leaves out is below 1e-18
with mp.workdps(DIGITS):
    MIDPOINT_WEIGHTS = [
        (n, mp.bernpoly(n, mp.mpf(1) / 2) / (n * (n - 1))) for n in range(2, 2 * TAIL_TERMS + 1, 2)
    ]

offsets = st.floats(-100, 100)
lengths = st.floats(0.03, 30)
fractions = st.floats(1e-3, 1)


# --- the judge -------------------------------------------------------------------------------------


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


def corners(f: Corner, x: mp.mpf, y: mp.mpf, dx: mp.mpf, dy: mp.mpf) -> mp.mpf:
    right, left, upper, lower = x + dx / 2, x - dx / 2, y + dy / 2, y - dy / 2
    return f(right, upper) - f(left, upper) - f(right, lower) + f(left, lower)


def judged_cell(*arguments: float) -> mp.mpf:
    with mp.workdps(DIGITS):
        return corners(love, *(mp.mpf(a) for a in arguments))


def judged_lattice(*arguments: float) -> mp.mpf:
    """Images summed one by one and the rest as an integral and its Euler-Maclaurin corrections.

    Takes none of the ways of the code: no zeta function, no Bessel function, no quadrature.
    """
    with mp.workdps(DIGITS):
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


def cell_error(x: ArrayLike, y: ArrayLike, dx: ArrayLike, dy: ArrayLike) -> float:
    """Largest relative error of ``boussinesq_cell``."""
    points = list(np.broadcast(x, y, dx, dy))
    found = boussinesq_cell(x, y, dx, dy).ravel()
    relative = [float(f / judged_cell(*p) - 1) for f, p in zip(found, points, strict=True)]
    return float(np.abs(relative).max())


def lattice_error(
    x: ArrayLike, y: ArrayLike, dx: ArrayLike, dy: ArrayLike, period: ArrayLike
) -> float:
    """Largest error of ``boussinesq_cell_periodic`` in units of max(|S|, dx dy / period)."""
    points = list(np.broadcast(x, y, dx, dy, period))
    found = boussinesq_cell_periodic(x, y, dx, dy, period).ravel()
    judged = [judged_lattice(*p) for p in points]
    error = np.array([float(f - j) for f, j in zip(found, judged, strict=True)])
    share = np.array([dx * dy / period for _, _, dx, dy, period in points])
    return float((np.abs(error) / np.maximum(np.abs(np.array(judged, float)), share)).max())


def column(table: str, name: str) -> Array:
    return np.array([float(row[name]) for row in REFERENCE[table]])


# --- one cell --------------------------------------------------------------------------------------

ASPECTS = [1e-3, 0.0307, 1 / 3, 1.0, np.pi, 1e3]
# steps off the centre: on, beside and along the edges and corners, and across the joins of the zones
STEPS = np.array(
    [0, 1e-20, 1e-8, 0.25, 0.5 - 1e-16, 0.5, 0.5 + 1e-16, 0.5 - 1e-6, 0.5 + 1e-6, 1, 1.5]
    + [np.nextafter(zone, side) for zone in (NEAR, FAR) for side in (0, zone, np.inf)]
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


@pytest.mark.parametrize(("x", "y"), [(0.9, 0.0), (0.6, 0.8), (-2.0, 3.0), (30.0, -40.0)])
def test_coefficient_is_the_integral_of_one_over_r(x: float, y: float) -> None:
    integral, _ = dblquad(
        lambda t, s: 1 / np.hypot(s, t), x - 0.5, x + 0.5, y - 0.3, y + 0.3, epsabs=0, epsrel=1e-11
    )
    assert_allclose(boussinesq_cell(x, y, 1.0, 0.6), integral, rtol=1e-11)


@pytest.mark.parametrize(("x", "y"), [(0.0, 0.0), (0.2, -0.1), (0.45, 0.29)])
def test_coefficient_inside_is_the_mean_distance_of_the_rim(x: float, y: float) -> None:
    """In polar coordinates about the observer the integrand is one, up to the rim."""

    def rim(angle: float) -> float:
        across, along = np.cos(angle), np.sin(angle)
        return min(
            (0.5 - np.sign(across) * x) / abs(across) if across else np.inf,
            (0.3 - np.sign(along) * y) / abs(along) if along else np.inf,
        )

    corner_angles = np.sort([np.arctan2(b - y, a - x) for a in (-0.5, 0.5) for b in (-0.3, 0.3)])
    pieces = zip(corner_angles, [*corner_angles[1:], corner_angles[0] + 2 * np.pi], strict=True)
    integral = sum(quad(rim, *piece, epsabs=0, epsrel=1e-12)[0] for piece in pieces)
    assert_allclose(boussinesq_cell(x, y, 1.0, 0.6), integral, rtol=1e-11)


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


def test_cell_arguments_broadcast() -> None:
    rng = np.random.default_rng(3)
    x, y = rng.normal(0, 30, (4, 1, 1)), rng.normal(0, 30, (5, 1))
    dx, dy = rng.uniform(0.1, 9, 3), rng.uniform(0.1, 9, (4, 5, 1))
    found = boussinesq_cell(x, y, dx, dy)
    assert found.shape == (4, 5, 3)
    for at in np.ndindex(found.shape):
        one = (float(a[at]) for a in np.broadcast_arrays(x, y, dx, dy))
        alone = boussinesq_cell(*one)
        assert alone.shape == ()
        assert_allclose(found[at], alone, rtol=4 * EPS)


@pytest.mark.parametrize("shape", [(0,), (0, 3), (3, 0)])
def test_no_offsets_have_no_coefficients(shape: tuple[int, ...]) -> None:
    nowhere = np.empty(shape)
    assert boussinesq_cell(nowhere, 0.0, 1.0, 1.0).shape == shape
    assert boussinesq_cell_periodic(nowhere, 0.0, 1.0, 1.0, 2.0).shape == shape
    assert boussinesq_cell_periodic(0.0, nowhere, 1.0, 1.0, 2.0).shape == shape


def test_no_number_in_is_no_number_out() -> None:
    x, y = np.array([np.nan, 0.0, np.nan]), np.array([0.0, np.nan, np.nan])
    assert np.isnan(boussinesq_cell(x, y, 1.0, 1.0)).all()
    assert np.isnan(boussinesq_cell_periodic(x, y, 1.0, 1.0, 2.0)).all()


# --- the repeated cell -----------------------------------------------------------------------------

# (dx, dy) in periods
CELLS = [
    (1e-6, 1e-6),
    (1e-6, 1.0),
    (0.01, 0.02),
    (0.3, 0.7),
    (1.0, 1.0),
    (1.001, 1e-3),
    (30.0, 1e-2),
    (1e6, 1.0),
]
PERIODS = [0.013, 1.0, 1700.0]


def test_lattice_has_its_reference_values() -> None:
    found = boussinesq_cell_periodic(*(column("lattice", k) for k in ("x", "y", "dx", "dy", "L")))
    expected = column("lattice", "S")
    share = column("lattice", "dx") * column("lattice", "dy") / column("lattice", "L")
    assert (np.abs(found - expected) <= EXACT * np.maximum(np.abs(expected), share)).all()


@pytest.mark.parametrize(
    ("across", "width", "length"),
    [
        ((-7, 0), (-6, 0), (-6, 0)),
        ((-1, 1), (-6, 0), (-6, 0)),
        ((0, 4), (-6, 0), (-6, 0)),
        ((-3, 4), (0, 3), (-6, 0)),
        ((-3, 6), (3, 6), (-6, 0)),
        ((-7, 4), (-6, 3), (0, 0)),
    ],
    ids=["near", "handover", "far", "wide", "very wide", "one per period"],
)
def test_lattice_is_exact(
    across: tuple[int, int], width: tuple[int, int], length: tuple[int, int]
) -> None:
    rng = np.random.default_rng(4)
    x, dx, dy = (10 ** rng.uniform(*ends, 20) for ends in (across, width, length))
    y, period = rng.uniform(-0.5, 0.5, 20), 10 ** rng.uniform(-3, 3, 20)
    assert lattice_error(x * period, y * period, dx * period, dy * period, period) < EXACT


@pytest.mark.parametrize(("dx", "dy"), CELLS)
def test_lattice_is_exact_on_edges_and_corners(dx: float, dy: float) -> None:
    x = np.array([0, 0.5, 0.5 + 1e-9, 2.5])[:, None] * dx
    y = np.array([0, 0.5 * dy, 0.3])
    assert lattice_error(x, y, dx, dy, 1.0) < EXACT


@pytest.mark.parametrize(
    ("width", "length"), [((-6, 0), (-6, 0)), ((-6, 0), (0, 0)), ((0, 3), (-6, 0))]
)
def test_lattice_is_exact_beside_edges_and_corners(
    width: tuple[int, int], length: tuple[int, int]
) -> None:
    """Off the grid and of no special period: to round a place there costs a thin cell up to 1e-9."""
    rng = np.random.default_rng(7)
    period, dx, dy = (10 ** rng.uniform(*ends, 15) for ends in ((-3, 3), width, length))
    dx, dy = dx * period, dy * period
    beside, inside = (
        10 ** rng.uniform(-16, 0, (2, 15)) * rng.choice([-1, 1], (2, 15)) * np.minimum(dx, dy),
        rng.uniform(-0.5, 0.5, 15),
    )
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
    ends = np.array([HANDOVER, FOURIER_END, -FOURIER_END])
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


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("dx", [1e-6, 0.01, 1.0, 40.0])
def test_one_cell_per_period_is_plane_strain(dx: float, period: float) -> None:
    """It varies along x alone: the logarithm, averaged over the width of the cell."""
    x = np.array([0, 0.3, 0.499, 0.501, 0.7, 3, 1e4])[:, None] * max(dx, 1.0)
    y = np.array([0, 0.1, 0.5, 0.77])
    right, left = x + dx / 2, x - dx / 2
    # taken relative to x where that is far, or the difference would cancel
    datum = np.maximum(x, dx)
    ends = right * np.log(right / datum) - left * np.log(np.abs(left / datum))
    expected = -2 * (ends - dx + dx * np.log(datum * period)) * period
    found = boussinesq_cell_periodic(x * period, y * period, dx * period, period, period)
    # ends - dx cancels down to dx (dx / x)^2 / 12 of x
    rounding = 8 * EPS * (datum + dx * (1 + np.abs(np.log(datum * period)))) * period
    assert (np.abs(found - expected) <= rounding + EXACT * dx * period).all()
    assert (found == found[:, :1]).all()


@pytest.mark.parametrize("cells", [2, 3, 64])
@pytest.mark.parametrize("dx", [1e-4, 0.2, 5.0])
def test_cells_of_a_period_add_up_to_plane_strain(dx: float, cells: int) -> None:
    x, y = np.array([0, 0.1, 0.5, 0.7, 2, 5.9, 80])[:, None], (np.arange(cells) + 0.3) / cells
    parts = boussinesq_cell_periodic(x, y, dx, 1 / cells, 1.0).sum(axis=1)
    whole = boussinesq_cell_periodic(x[:, 0], 0.0, dx, 1.0, 1.0)
    assert_allclose(parts, whole, rtol=EXACT, atol=EXACT * dx)


@pytest.mark.parametrize("parts", [2, 25])
@pytest.mark.parametrize("dx", [1e-3, 1.0, 4.0, 1e4])
def test_strips_of_a_wide_cell_add_up_to_it(dx: float, parts: int) -> None:
    x, y = np.array([0, 0.3, 0.5, 0.6, 3])[:, None, None] * dx, np.array([0, 0.1, 0.5])[:, None]
    centres = (np.arange(parts) - (parts - 1) / 2) * dx / parts
    strips = boussinesq_cell_periodic(x + centres, y, dx / parts, 0.2, 1.0).sum(axis=2)
    whole = boussinesq_cell_periodic(x[..., 0], y[:, 0], dx, 0.2, 1.0)
    assert_allclose(strips, whole, rtol=EXACT, atol=EXACT * dx * 0.2)


@pytest.mark.parametrize("times", [2, 5])
@pytest.mark.parametrize(("dx", "dy"), CELLS[2:])
def test_lattice_is_made_of_sparser_lattices(dx: float, dy: float, times: int) -> None:
    """What is Fourier series for the one is a sum of images for the others."""
    x, y = np.array([0, 0.4, 0.9, 2, 8])[:, None, None], np.array([0, 0.2, 0.5])[:, None]
    shifts = np.arange(times)
    sparse = boussinesq_cell_periodic(x, y + shifts, dx, dy, float(times)).sum(axis=2)
    dense = boussinesq_cell_periodic(x[..., 0], y[:, 0], dx, dy, 1.0)
    assert_allclose(sparse, dense, rtol=EXACT, atol=EXACT * dx * dy)


@settings(deadline=None, max_examples=20)
@given(offsets, offsets, lengths, fractions, lengths, st.floats(1e-6, 1e6))
def test_lattice_scales_but_for_its_logarithm(
    x: float, y: float, dx: float, share: float, period: float, scale: float
) -> None:
    lengths = np.array([x, y, dx, share * period, period])
    found = boussinesq_cell_periodic(*(lengths * scale)) / scale
    unit = lengths[2] * lengths[3] / period
    expected = boussinesq_cell_periodic(*lengths) - 2 * unit * np.log(scale)
    # scaling rounds y, by as much of a cell as there are cells up to it
    moved = EPS * max(abs(y), period) / min(dx, lengths[3])
    largest = max(unit * (1 + 2 * abs(np.log(scale))), abs(expected), abs(found))
    assert abs(found - expected) <= (EXACT + 8 * moved) * largest


@pytest.mark.parametrize(("dx", "dy"), CELLS)
def test_distant_lattice_is_a_line(dx: float, dy: float) -> None:
    x, y = np.array([10.0, 1e2, 1e4, 1e6])[:, None] * (1 + dx), np.array([0, 0.3, 0.5])
    found = boussinesq_cell_periodic(x, y, dx, dy, 1.0)
    # the mean of -2 ln over the width is larger by its second moment, dx^2 / 12 x^2; the harmonics
    # are below exp(-20 pi)
    departure = found / (dx * dy) + 2 * np.log(x)
    moment = dx**2 / (12 * x**2)
    assert (np.abs(departure - moment) <= moment * (dx / x) ** 2 + 16 * EPS * np.log(x)).all()


# (x, y, dx, dy) in periods. Near y = 0.29 at x = 0 the leading error of the truncation changes sign.
TRUNCATED = [
    (0, 0, 0.01, 0.01),
    (0, 0.1, 0.05, 0.02),
    (0, 0.5, 0.01, 0.01),
    (0.4, 0.2, 0.1, 0.1),
    (0.7, 0.0, 0.3, 0.25),
    (2.0, 0.5, 0.1, 0.01),
    (9.0, 0.3, 0.1, 0.1),
    (0.6, 0.0, 0.1, 1.0),
]


@pytest.mark.parametrize("case", TRUNCATED)
def test_images_one_by_one_approach_the_lattice_without_turning_back(
    case: tuple[float, float, float, float],
) -> None:
    images = np.arange(1, 10_001)
    period = 1.3
    x, y, dx, dy = (a * period for a in case)
    pairs = sum(boussinesq_cell(x, y + side * images * period, dx, dy) for side in (1, -1))
    total = boussinesq_cell(x, y, dx, dy) + np.cumsum(pairs)
    unit = 2 * dx * dy / period
    truncated = total - unit * np.log((2 * images + 1) * period)
    error = np.abs(truncated - boussinesq_cell_periodic(x, y, dx, dy, period))
    rounding = 4 * EPS * (total + unit * np.log((2 * images + 1) * period))
    assert (np.diff(error) < rounding[1:]).all()
    assert (np.diff(error[:1000]) < 0).all()
    # of second order: what is left is moments of the images, over the square of their number
    last = error[[-5000, -1]] * images[[-5000, -1]] ** 2
    assert_allclose(last[1], last[0], rtol=0.01)


OFFSETS_X = [0.0, 0.3, -0.8, 2.0, 7.5]  # in the range of each form
OFFSETS_Y = [-2.2, 0.0, 0.4, 1.7]
CHOICES = (OFFSETS_X, OFFSETS_Y, [0.1, 0.9, 4.0], [0.1, 0.8], [1.0, 1.2])


@pytest.mark.parametrize(
    "shapes",
    [
        ((), (), (), (), ()),
        ((4,), (), (), (), ()),
        ((), (4,), (), (), ()),
        ((4,), (4,), (), (), ()),
        ((1,), (1,), (), (), ()),
        ((3, 1), (2,), (), (), ()),
        ((3, 1), (1, 2), (), (), ()),
        ((2,), (3, 1), (), (), ()),
        ((3, 2), (3, 2), (), (), ()),
        ((2, 3), (3,), (), (), ()),
        ((3, 1), (3, 2), (), (), ()),
        ((2, 1, 1), (2, 2), (), (), ()),
        ((2, 2, 1), (2,), (), (), ()),
        ((2, 1, 2), (2, 1), (), (), ()),
        ((5,), (5,), (1, 1), (), (1,)),
        ((), (), (3,), (), ()),
        ((5,), (), (), (5,), ()),
        ((4,), (4,), (4,), (4,), (4,)),
        ((3, 1), (1, 2), (3, 1), (2,), ()),
        ((2, 1, 1, 1), (1, 1), (2, 1, 1), (2, 1), (2,)),
    ],
)
def test_lattice_arguments_broadcast(shapes: tuple[tuple[int, ...], ...]) -> None:
    rng = np.random.default_rng(6)
    arguments = [np.asarray(rng.choice(c, s)) for c, s in zip(CHOICES, shapes, strict=True)]
    found = boussinesq_cell_periodic(*arguments)
    assert found.shape == np.broadcast_shapes(*shapes)
    # the same operations in another order of the sums
    rounding = 16 * EPS * np.maximum(np.abs(found), arguments[2] * arguments[3] / arguments[4])
    for at, one in zip(np.ndindex(found.shape), np.broadcast(*arguments), strict=True):
        assert abs(found[at] - boussinesq_cell_periodic(*one)) <= rounding[at]

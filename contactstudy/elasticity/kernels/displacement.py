"""Displacement under uniform pressure on a rectangular cell of a half-space: the cell alone, in a row, in a lattice.

A pressure p on the cell displaces the surface by ``I p / (pi E*)``, where the influence coefficient ``I`` is a length:
the integral of 1 / r over the cell. It is found to 13 digits at any distance, so that its differences keep digits.
Offsets x across and y along count from the centre of the cell; dx and dy are its sides.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.polynomial.polynomial import polypow, polyval
from numpy.typing import ArrayLike, NDArray
from scipy.special import binom, digamma, gammaln, k0, xlog1py, zeta

from contactstudy.domain.grid import Array, matrix_product

# Beyond FAR_DISTANCE half-diagonals d of a cell, so many multipole moments leave at most 32^-10 / 11 ~ 8e-17, with the
# mean 1/11 of (s / d)^10 over a narrow cell.
FAR_DISTANCE, MOMENTS = 32.0, 5
# Beyond NEAR_DISTANCE cells a line's field is analytic in a Bernstein ellipse of rho >= 9.9, so that 8 Gauss
# points leave rho^-16 ~ 1e-16.
NEAR_DISTANCE, NEAR_POINTS = 2.5, 8
# Numbers in one array operation over lines or images: for few cells the overhead of a call exceeds its work, and larger
# arrays leave the processor's cache.
BATCH = 2**13


def boussinesq_cell(x: ArrayLike, y: ArrayLike, dx: float, dy: float) -> Array:
    """Return the integral of 1/r over a rectangular cell: ``pi E*`` times displacement over pressure.

    The relative error is below 1e-13 at any distance up to 1e150 cells and for ``dx / dy`` from 1e-3 to 1e3. The result
    is even in `x` and `y` to the last bit.

    Source: Love (1929). His difference of four corner terms loses ``(r / dx)^2`` units in the last place. Here the
    integral is taken edge by edge near the cell; then by Gauss points along the axis of the larger offset, each a line
    in closed form, all of one sign; and far away as multipoles.

    Parameters
    ----------
    x, y
        Offsets from the centre of the cell.
    dx, dy
        Sides of the cell.

    Returns
    -------
    Array
        The integral. Offsets broadcast; lengths are in one unit, and the result is in that unit.
    """
    x, y = (np.abs(np.asarray(a, dtype=np.float64)) for a in (x, y))
    half_x, half_y = dx / 2, dy / 2
    diagonal = np.hypot(half_x, half_y)
    across, along = (x / diagonal) ** 2, (y / diagonal) ** 2
    anisotropy = float((half_x / diagonal) ** 2 - (half_y / diagonal) ** 2)
    square = np.asarray(across + along)
    close = square < FAR_DISTANCE**2
    # Close to the cell the value is replaced below and only has to be finite. Operations are in place, since
    # allocating arrays as large as a grid takes longer than the arithmetic.
    inverse = np.reciprocal(np.maximum(square, FAR_DISTANCE**2, out=square), out=square)
    cosine = np.asarray(across - along)
    cosine *= inverse
    result: Array = np.empty(close.shape)
    if not close.all():
        result = multipoles(cosine, inverse, anisotropy)
        result *= 4 * half_x * (half_y / diagonal)
    if close.any():
        x, y = np.broadcast_arrays(x, y)
        result[close] = _near(x[close], y[close], half_x, half_y)
    return result


def multipoles(c: Array, q: Array, e: float) -> Array:
    """Return the mean of ``1 / |r - s|`` over the points s of a cell, times its half-diagonal d.

    ``c = cos 2 theta`` for the direction theta of the field point r, ``q = (d / r)^2``, and the anisotropy of the cell
    ``e = (dx^2 - dy^2) / (dx^2 + dy^2)``. The mean is ``sqrt(q)`` times the sum over k of ``q^k`` times the moments
    ``< (s / d)^2k P_2k(cos(r, s)) >``, with Legendre's polynomials P and the mean <> over the cell.
    """
    total, moment, moments = np.zeros_like(q), np.empty_like(q), np.asarray(polyval(e, _moments()))
    for k in range(MOMENTS - 1, -1, -1):
        total *= q
        moment[...] = moments[k, k]
        for coefficient in moments[k, :k][::-1]:
            moment *= c
            moment += coefficient
        total += moment
    total *= np.sqrt(q, out=moment)
    return total


@cache
def _moments() -> Array:
    """Return the coefficients (n, k, m) of ``c^m e^n`` in ``< (s / d)^2k P_2k(cos(r, s)) >``, see :func:`multipoles`.

    P_2k is a sum over m of ``cos 2 m (theta - phi)``, phi the direction of s, whose factors are those of
    ``((1 - z) (1 - 1 / z))^(-1/2)`` in powers of z. Averaged over the cell, ``s^2k cos 2 m phi`` is a polynomial in the
    squares of its half-sides, which are ``(1 + e) / 2`` and ``(1 - e) / 2`` in units of d^2.
    """
    root = binom(2 * np.arange(2 * MOMENTS), np.arange(2 * MOMENTS)) / 4.0 ** np.arange(2 * MOMENTS)
    moments = np.zeros((MOMENTS, MOMENTS, MOMENTS))
    for k in range(MOMENTS):
        sides = [np.convolve(polypow([1, 1], i), polypow([1, -1], k - i)) for i in range(k + 1)]
        i = np.arange(k + 1)
        means = np.array(sides) / (2.0**k * (2 * i + 1) * (2 * (k - i) + 1))[:, None]
        moment = np.zeros((k + 1, k + 1))
        for m in range(k + 1):
            wave = binom(2 * m, 2 * i[: m + 1]) * (-1.0) ** (m - i[: m + 1])
            factor = (2 if m else 1) * root[k - m] * root[k + m]
            in_c = np.polynomial.chebyshev.cheb2poly([0] * m + [factor])
            moment[: m + 1] += np.outer(in_c, np.convolve(wave, polypow([1, 1], k - m)) @ means)
        moments[: k + 1, k, : k + 1] = moment.T
    return moments


def _near(x: Array, y: Array, half_x: float, half_y: float) -> Array:
    """Return the integral of 1/r over a cell at offsets (n,) that are too near for an expansion in multipoles.

    `half_x` and `half_y` are half its sides.
    """
    across, along = x / half_x, y / half_y
    near = np.maximum(across, along) < 2 * NEAR_DISTANCE
    result = np.empty(x.shape)
    result[near] = _edges(x[near], y[near], half_x, half_y)
    if not near.all():
        u, v, wide = x[~near], y[~near], across[~near] >= along[~near]
        ordered = (np.where(wide, *pair) for pair in ((u, v), (v, u), (half_x, half_y), (half_y, half_x)))
        result[~near] = _lines(*ordered)
    return result


def segment_integral(x: Array, y: Array, half: Array) -> Array:
    """Return the integral of 1/r along a segment of half-length `half`, from a point at `x` > 0 aside and `y` along it.

    Arguments broadcast, `y` is at least 0.
    """
    x, y, half = np.broadcast_arrays(x, y, half)
    result, within = np.empty(x.shape), y < 2 * half
    # The first form loses digits outside the segment, the second inside.
    u, v, h = x[within], y[within], half[within]
    result[within] = np.arcsinh((v + h) / u) - np.arcsinh((v - h) / u)
    u, v, h = x[~within], y[~within], half[~within]
    # 2 artanh(2 h / ends), at a quarter of that function's time
    ends = np.hypot(u, v + h) + np.hypot(u, v - h)
    result[~within] = np.log1p(4 * h / (ends - 2 * h))
    return result


def _edges(x: Array, y: Array, half_x: float, half_y: float) -> Array:
    """Return the integral of 1/r over a cell by its four edges, by the divergence theorem on ``(x, y) / r``."""
    outward = np.stack([x + half_x, y + half_y, half_x - x, half_y - y])
    along, half = np.stack([y, x, y, x]), np.array([half_y, half_x, half_y, half_x])[:, None]
    # An edge contributes nothing to points on its line; any nonzero distance avoids a division by zero.
    aside = np.where(outward == 0, 1.0, np.abs(outward))
    return np.asarray((outward * segment_integral(aside, along, half)).sum(axis=0))


def _lines(x: Array, y: Array, half_x: Array, half_y: Array) -> Array:
    """Return the integral of 1/r over a cell by Gauss points across it, each a line along it."""
    nodes, weights = np.array(mean_gauss_rule(NEAR_POINTS)).T[:, :, None]
    total = np.zeros(x.shape)
    count = max(1, BATCH // max(x.size, 1))
    for start in range(0, NEAR_POINTS, count):
        part = slice(start, start + count)
        lines = segment_integral(x + nodes[part] * half_x, y, half_y)
        total += (weights[part] * lines).sum(axis=0)
    return 2 * half_x * total


@cache
def mean_gauss_rule(points: int) -> tuple[tuple[float, float], ...]:
    """Return Gauss-Legendre nodes on (-1, 1) with weights that add up to one."""
    nodes, weights = leggauss(points)
    return tuple(zip(nodes.tolist(), (weights / 2).tolist(), strict=True))


# Distances from the axis in periods: from FOURIER_START on the Fourier series along y replaces the sum over images,
# with 13 terms there, since exp(-13 pi) ~ 1e-18 is left; beyond FOURIER_END only its mean, a logarithm, remains.
FOURIER_START, FOURIER_END, FOURIER_TERMS = 0.5, 6.0, 13
# Beyond this K0 is below 1e-18.
NEGLIGIBLE_K0 = 40.0
# Images are summed one by one up to the distance from the origin to the farthest point and corner over this ratio. The
# multipoles of further ones then fall by a factor of 0.46^-2 = 4.7 from one to the next. Ratios from 0.23 to 0.92 take
# up to 1.3 times as long for the same digits.
IMAGE_RATIO = 0.46
# Relative error of a quadrature by Gauss points, and of a truncated series of multipoles.
QUADRATURE_ERROR = 1e-17


def boussinesq_cell_periodic(x: ArrayLike, y: ArrayLike, dx: float, dy: float, period: float) -> Array:
    """Return the integral of 1/r over a cell repeated infinitely along y, less its divergent rigid-body motion.

    ``S = lim_M [ sum_{|m| <= M} I(x, y + m L) - (2 dx dy / L) ln((2 M + 1) L) ]`` with I that of
    ``boussinesq_cell``. Its mean over a period is ``-(2 dx dy / L) mean ln |x|``. The error is
    below 1e-13 of ``max(|S|, dx dy / period)``; the result is even in `x` and `y`.

    Source: near the axis, images summed one by one, and all further ones as multipoles, whose sums are zeta functions;
    Fourier series in Bessel functions K0 (Lekner 1991, eq. for a line of charges) away from it.

    Parameters
    ----------
    x, y
        Offsets from the centre of a cell: every x with every y.
    dx, dy
        Sides of the cell, ``dy <= period``.
    period
        Distance L between images along y.

    Returns
    -------
    Array
        The sum S (x, y). Lengths are in one unit, and the result is in that unit.
    """
    x, y = column_and_row(x, y)
    # fmod is exact; rounding a quotient y / period would move the field point by many cells, where these are smallest
    x, y = np.abs(x), np.fmod(np.abs(y), period)
    y = np.minimum(y, period - y)
    if dy == period:  # nothing varies along y: plane strain
        return np.asarray(_log_mean(x, dx / 2) * (-2 * dx * dy / period) * np.ones_like(y))
    result = np.empty((x.size, y.size))
    inner = (x.ravel() - dx / 2) / period
    beyond, near = inner >= FOURIER_END, inner < FOURIER_START
    forms: dict[Callable[[Array, Array, float, float, float], Array], NDArray[np.bool_]] = {
        # -2 ln |x|, averaged over a cell that does not reach the axis
        lambda x, y, half_x, *_: -2 * _log_mean(x, half_x) * np.ones_like(y): beyond,
        _fourier: ~beyond & ~near,
        _images: near,
    }
    for form, rows in forms.items():
        if rows.any():
            result[rows] = form(x[rows], y, dx / 2, dy / 2, period)
    result *= dx * dy / period
    return result


def column_and_row(x: ArrayLike, y: ArrayLike) -> tuple[Array, Array]:
    """Return `x` as a column and `y` as a row, both of floats."""
    column, row = (np.asarray(a, dtype=np.float64) for a in (x, y))
    return column.reshape(-1, 1), row.reshape(1, -1)


def _images(x: Array, y: Array, half_x: float, half_y: float, period: float) -> Array:
    """Return the sum S of :func:`boussinesq_cell_periodic` over ``dx dy / period`` near the axis, shape (x, y).

    `x` (n, 1) and `y` (1, m) are at least 0, `half_x` and `half_y` half the sides of the cell. The nearest images are
    summed one by one, and all further ones together as multipoles.
    """
    across, along = (float(np.fmax.reduce(a, axis=None, initial=0.0)) for a in (x + half_x, y))
    reach = np.hypot(across, along + half_y) / period
    images = max(1, int(np.ceil(reach / IMAGE_RATIO)) - 1)
    total: Array = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    # not in periods: that rounding would move the edges of the cells
    places = y + (np.arange(-images, images + 1) * period).reshape(-1, *[1] * y.ndim)
    count = max(1, BATCH // max(total.size, 1))
    for start in range(0, len(places), count):
        part = places[start : start + count]
        total += boussinesq_cell(x, part, 2 * half_x, 2 * half_y).sum(axis=0)
    total *= period / (4 * half_x * half_y)
    terms = int(np.log(QUADRATURE_ERROR) / (2 * np.log(reach / (images + 1)))) + 1
    powers_x = even_powers(x / period, half_x / period, images, terms)
    powers_y = even_powers(y / period, half_y / period, images, terms).T
    total += matrix_product(powers_x, matrix_product(further_images(images, terms), powers_y))
    total -= 2 * np.log(2 * period)
    return total


def even_powers(x: Array, half: float, images: int, terms: int) -> Array:
    """Return ``1, x^2, x^4 ...`` averaged over segments of half-length `half` about each x, shape (x, terms).

    Lengths are in periods. `images` on each side, and the origin, are summed one by one; the next ones are at a
    distance at which the rule for the average is exact to rounding.
    """
    # smallest distance between the ends of a cell and the further images, in half-lengths
    nodes, weights = np.array(gauss_points(images / half)).T
    squares = (x.reshape(-1, 1) + half * nodes) ** 2
    powers = np.vander(squares.ravel(), terms, increasing=True)
    return np.asarray(np.einsum("p,xpt->xt", weights, powers.reshape(*squares.shape, terms)))


@cache
def further_images(images: int, terms: int) -> Array:
    """Return the coefficients (k, n) of ``x^2k y^2n`` in the sum of 1 / r over images beyond `images` on each side.

    Lengths are in periods. Two images that are m away on either side make ``2 sum_l r^2l P_2l(y / r) / m^(2l + 1)``,
    with l = k + n.
    """
    k = np.arange(terms)
    order = k[:, None] + k
    sums = zeta(2 * order + 1, images + 1)
    sums[0, 0] = -digamma(images + 1)  # without its divergent part
    return np.where(order < terms, 2 * binom(-0.5, k)[:, None] * binom(2 * order, 2 * k) * sums, 0)


def gauss_points(away: float) -> tuple[tuple[float, float], ...]:
    """Return Gauss points and weights on a segment for a field that is singular `away` half-lengths from its middle.

    Their error is `QUADRATURE_ERROR`.
    """
    # n points leave rho^-2n of a field that is analytic in the Bernstein ellipse with cosh ln rho = away
    return mean_gauss_rule(1 + int(np.log(QUADRATURE_ERROR) / (-2 * np.arccosh(away))))


def _fourier(x: Array, y: Array, half_x: float, half_y: float, period: float) -> Array:
    """Return the sum S of :func:`boussinesq_cell_periodic` over ``dx dy / period`` away from the axis, shape (x, y).

    It is the plane-strain logarithm and harmonics of the period, which decay like exp(-2 pi j x / L).
    """
    across = harmonics_across(x, half_x, period)
    total = matrix_product(across, harmonics_along(y, half_y, period, across.shape[1]))
    total -= 2 * _log_mean(x, half_x)
    return total


def harmonics_across(x: Array, half_x: float, period: float) -> Array:
    """Return ``4 K0(2 pi j x / L)`` averaged over a segment about each x, shape (x, j = 1, 2 ...)."""
    # fewer harmonics are left farther from the axis
    inner = float(np.fmin.reduce((x - half_x) / period, axis=None, initial=FOURIER_END))
    wave = 2 * np.pi / period * np.arange(1, int(np.ceil(FOURIER_TERMS * FOURIER_START / inner)) + 1)
    away = float(np.fmin.reduce(x / half_x, axis=None, initial=np.inf))
    nodes, weights = np.array(gauss_points(away)).T
    places = x.reshape(-1, 1) + half_x * nodes
    argument = places[:, :, None] * wave
    decaying = argument < NEGLIGIBLE_K0
    waves = np.zeros(argument.shape)
    waves[decaying] = k0(argument[decaying])
    return np.asarray(np.einsum("p,xpj->xj", 4 * weights, waves))


def harmonics_along(y: Array, half_y: float, period: float, count: int) -> Array:
    """Return ``cos(2 pi j y / L)`` averaged over a segment about each y, shape (j = 1, 2 ... count, y)."""
    j = np.arange(1, count + 1)[:, None]
    waves = np.cos(2 * np.pi / period * j * y.ravel())
    return np.asarray(waves * np.sinc(2 * j * half_y / period))


def _log_mean(x: Array, half: float) -> Array:
    """Return the mean of ``ln |x|`` over a segment of half-length `half` whose centre is ``x >= 0`` away."""
    mean, aside = np.empty(x.shape), x >= half
    # Neither end cancels the other, for a narrow segment (t -> 0) or one next to the axis (1).
    t = half / x[aside]
    ends = (1 + t) * np.log1p(t) - xlog1py(1 - t, -t)
    mean[aside] = np.log(x[aside]) - 1 + ends / (2 * t)
    t = x[~aside] / half
    mean[~aside] = np.log(half) - 1 + ((1 + t) * np.log1p(t) + (1 - t) * np.log1p(-t)) / 2
    return mean


def boussinesq_cell_doubly_periodic(
    x: ArrayLike, y: ArrayLike, dx: float, dy: float, width: float, period: float
) -> Array:
    """Return the integral of 1/r over a cell repeated along x and y, less its mean over both periods.

    The error is below 1e-13 of ``max(|S|, dx dy / min(width, period))``. Source: the rows of
    ``boussinesq_cell_periodic``, whose harmonics vanish within a few of their periods and
    whose logarithms together are that of a line load of period W = `width`, ``-2 ln |2 sin(pi x / W)|`` (Johnson 1985,
    sect. 13.2).

    Parameters
    ----------
    x, y
        Offsets from the centre of a cell: every x with every y.
    dx, dy
        Sides of the cell, ``dx <= width`` and ``dy <= period``.
    width, period
        Distances between images along x and y.

    Returns
    -------
    Array
        The sum S (x, y). Lengths are in one unit, and the result is in that unit.
    """
    if period > width:  # the harmonics of the shorter period vanish sooner
        return boussinesq_cell_doubly_periodic(y, x, dy, dx, period, width).T
    x, y = column_and_row(x, y)
    folded = np.fmod(np.abs(x), width)
    x = np.asarray(np.minimum(folded, width - folded))
    total = boussinesq_cell_periodic(x - width, y, dx, dy, period)
    total += boussinesq_cell_periodic(x, y, dx, dy, period)
    total += dx * dy / period * _further_rows(x, y, dx, dy, width, period)
    return total


def _further_rows(x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
    """Return the sum (x, y) of all rows except those at 0 and at the `width`, over ``dx dy / period``.

    No cell of these rows reaches the field points, which are `x` (n, 1) from 0 to half the width and `y` (1, m).
    """
    # further rows are more than FOURIER_END periods from any cell, where only the logarithms remain
    rows = int(np.ceil(FOURIER_END * period / width)) + 1
    waves = [
        harmonics_across(side * x + m * width, dx / 2, period)
        for m in range(rows, 0, -1)
        for side in (1, -1)
        if (m, side) != (1, -1)
    ]
    across = np.zeros((x.size, max(wave.shape[1] for wave in waves)))
    for wave in waves:
        across[:, : wave.shape[1]] += wave
    along = harmonics_along(y, dy / 2, period, across.shape[1])
    total = matrix_product(across, along)
    # ln |x (W - x)| less ln |2 sin(pi x / W)|, with W the width, by the sine's product
    logarithms = 2 * np.log(width) - np.log(2 * np.pi)
    for node, weight in gauss_points(2 * width / dx):
        t = (x + node * dx / 2) / width
        logarithms = logarithms + weight * (gammaln(1 + t) + gammaln(2 - t))
    total += 2 * logarithms
    return total

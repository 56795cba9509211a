"""Displacement under a cell repeated along one axis or both, summed over all images."""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import binom, digamma, gammaln, k0, xlog1py, zeta

from contactstudy.domain.fields import Array, matrix_product
from contactstudy.elasticity.kernels.displacement_cell import BATCH, boussinesq_cell, mean_gauss_rule

# Distances in periods: from FOURIER_START the Fourier series replaces the sum over images (its 13 terms end at
# exp(-13 pi) ~ 1e-18); beyond FOURIER_END only its logarithm remains.
FOURIER_START, FOURIER_END, FOURIER_TERMS = 0.5, 6.0, 13
# Beyond this K0 is below 1e-18.
NEGLIGIBLE_K0 = 40.0
# Largest distance from the axis to field point and cell over that to the images that are not summed one by one: their
# multipoles then fall by a factor of 4.7 from one to the next.
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
    """Return the sum S of :func:`boussinesq_cell_periodic` near the axis.

    The nearest images are summed one by one, and all further ones together as multipoles.
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
    """Return ``1, x^2, x^4 ...`` averaged over segments about each x, in periods, shape (x, terms)."""
    # smallest distance between the ends of a cell and the further images, in half-lengths
    nodes, weights = np.array(gauss_points(images / half)).T
    squares = (x.reshape(-1, 1) + half * nodes) ** 2
    powers = np.vander(squares.ravel(), terms, increasing=True)
    return np.asarray(np.einsum("p,xpt->xt", weights, powers.reshape(*squares.shape, terms)))


@cache
def further_images(images: int, terms: int) -> Array:
    """Return the coefficients (k, n) of ``x^2k y^2n`` in the sum of 1 / r over all images except the nearest.

    Two that are m away on either side make ``2 sum_l r^2l P_2l(y / r) / m^(2l + 1)``, with l = k + n.
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
    """Return the sum S of :func:`boussinesq_cell_periodic` away from the axis.

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
    """Return the sum over all rows except the rows at 0 and at the `width`, in units of ``dx dy / period``.

    No cell of these rows reaches the axis.
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

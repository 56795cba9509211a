"""Displacement of an elastic half-space under uniform pressure on one rectangular cell, stable at every distance.

A pressure p on the cell displaces the surface by ``I p / (pi E*)``, where the influence coefficient ``I`` is a length.
"""

from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.polynomial.polynomial import polypow, polyval
from numpy.typing import ArrayLike
from scipy.special import binom

from contactstudy.domain.fields import Array

# Beyond FAR_DISTANCE half-diagonals of a cell, four multipole moments leave at most 64^-8 / 9 ~ 4e-16; beyond
# MIDDLE_DISTANCE, eight leave 10^-16 / 17.
FAR_DISTANCE, FAR_MOMENTS = 64.0, 4
MIDDLE_DISTANCE, MIDDLE_MOMENTS = 10.0, 8
# Beyond NEAR_DISTANCE cells a line's field is analytic in a Bernstein ellipse of rho >= 9.9, so that 8 Gauss
# points leave rho^-16 ~ 1e-16.
NEAR_DISTANCE, NEAR_POINTS = 2.5, 8
# Numbers in one array operation over lines or images: for few cells the overhead of a call exceeds its work.
BATCH = 2**13


def boussinesq_cell(x: ArrayLike, y: ArrayLike, dx: float, dy: float) -> Array:
    """Return the integral of 1/r over a rectangular cell: ``pi E*`` times displacement over pressure.

    The relative error is below 1e-13 at any distance up to 1e150 cells and for ``dx / dy`` from 1e-3 to 1e3. The result
    is even in `x` and `y` to the last bit.

    Source: Love (1929). His difference of four corner terms loses ``(r / dx)^2`` units in the last place; here it is
    taken edge by edge near the cell, then as Gauss points (in the direction of the larger offset) of lines in closed
    form, all of one sign, and far away as multipoles.

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
        result = multipoles(cosine, inverse, anisotropy, FAR_MOMENTS)
        result *= 4 * half_x * (half_y / diagonal)
    if close.any():
        x, y = np.broadcast_arrays(x, y)
        result[close] = _near_and_middle(x[close], y[close], half_x, half_y)
    return result


def multipoles(c: Array, q: Array, e: float, terms: int) -> Array:
    """Return the mean of ``1 / |r - s|`` over the points s of a cell, in the unit of its half-diagonal d.

    ``c = cos 2 theta`` for the direction of r, ``q = (d / r)^2``, ``e = (dx^2 - dy^2) / (dx^2 + dy^2)``. It is
    ``sqrt(q)`` times the sum of ``q^k < (s / d)^2k P_2k(cos(r, s)) >``.
    """
    total, moment = np.zeros_like(q), np.empty_like(q)
    for polynomial in reversed(_moments_of_cell(terms, e)):
        total *= q
        moment[...] = polynomial[-1]
        for coefficient in polynomial[-2::-1]:
            moment *= c
            moment += coefficient
        total += moment
    total *= np.sqrt(q, out=moment)
    return total


@cache
def _moments(terms: int) -> Array:
    """Return the coefficients (n, k, m) of ``c^m e^n`` in ``< (s / d)^2k P_2k(cos(r, s)) >``, see :func:`multipoles`.

    P_2k is a sum of ``cos 2 m (theta - phi)``, phi the direction of s, whose factors are those of
    ``((1 - z) (1 - 1 / z))^(-1/2)``. Averaged over the cell, ``s^2k cos 2 m phi`` is a polynomial in the squares of its
    half-sides, which are ``(1 + e) / 2`` and ``(1 - e) / 2``.
    """
    root = binom(2 * np.arange(2 * terms), np.arange(2 * terms)) / 4.0 ** np.arange(2 * terms)
    moments = np.zeros((terms, terms, terms))
    for k in range(terms):
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


@lru_cache(maxsize=8)
def _moments_of_cell(terms: int, e: float) -> list[list[Any]]:
    """Return the coefficients (k, m) of ``c^m`` in the moments of a cell of anisotropy `e`, see :func:`multipoles`."""
    moments = np.asarray(polyval(e, _moments(terms)))
    return [list(moments[k, : k + 1]) for k in range(terms)]


def _near_and_middle(x: Array, y: Array, half_x: float, half_y: float) -> Array:
    """Return the integral of 1/r over cells that are too near, or too long, for an expansion in four multipoles."""
    across, along = x / half_x, y / half_y
    near = np.maximum(across, along) < 2 * NEAR_DISTANCE
    diagonal = np.hypot(half_x, half_y)
    square = (x / diagonal) ** 2 + (y / diagonal) ** 2
    beyond = ~near & (square >= MIDDLE_DISTANCE**2)
    between = ~(near | beyond)
    result = np.empty(x.shape)
    result[near] = _edges(x[near], y[near], half_x, half_y)
    if beyond.any():
        q = 1 / square[beyond]
        c = ((x[beyond] / diagonal) ** 2 - (y[beyond] / diagonal) ** 2) * q
        e = float((half_x / diagonal) ** 2 - (half_y / diagonal) ** 2)
        result[beyond] = 4 * half_x * (half_y / diagonal) * multipoles(c, q, e, MIDDLE_MOMENTS)
    if between.any():
        u, v, wide = x[between], y[between], across[between] >= along[between]
        ordered = (np.where(wide, *pair) for pair in ((u, v), (v, u), (half_x, half_y), (half_y, half_x)))
        result[between] = _lines(*ordered)
    return result


def segment_integral(x: Array, y: Array, half: Array) -> Array:
    """Return the integral of 1/r along a segment of half-length `half`, at `x` aside and `y` along its axis."""
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
    """Return the integral of 1/r over a cell by its four edges (divergence theorem on ``(x, y) / r``)."""
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

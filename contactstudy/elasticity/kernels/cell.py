"""Influence coefficients of a rectangular cell on an elastic half-space, stable at every distance.

A uniform pressure p on one cell moves the surface of the half-space by ``I p / (pi E*)``, where ``I``
is a length.
"""

from functools import cache

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike

from contactstudy.domain.devices.arrays import Array

# Beyond MULTIPOLES half-diagonals of a cell, four moments leave at most 64^-8 / 9 ~ 4e-16.
MULTIPOLES = 64.0
# Beyond NEAR cells a line's field is analytic in a Bernstein ellipse of rho >= 9.9, so that 8 Gauss
# points leave rho^-16 ~ 1e-16; beyond FAR cells rho >= 160 and 4 points do.
NEAR, FAR = 2.5, 40.0
NEAR_POINTS, FAR_POINTS = 8, 4


def boussinesq_cell(x: ArrayLike, y: ArrayLike, dx: ArrayLike, dy: ArrayLike) -> Array:
    """Integral of 1/r over a ``dx * dy`` cell whose centre is ``(x, y)`` away; all arguments broadcast.

    Lengths in one common unit, the result in that unit. Relative error below 1e-13 at any distance up
    to 1e150 cells and for ``dx / dy`` from 1e-3 to 1e3; even in ``x`` and ``y`` to the last bit.

    Source: Love (1929). His difference of four corner terms loses ``(r / dx)^2`` units in the last
    place; here it is taken edge by edge near the cell, then as Gauss points (in the direction of the
    larger offset) of lines in closed form, all of one sign, and far away as multipoles.
    """
    x, y, dx, dy = (np.abs(np.asarray(a, dtype=np.float64)) for a in (x, y, dx, dy))
    half_x, half_y = dx / 2, dy / 2
    diagonal = np.hypot(half_x, half_y)
    across, along = (x / diagonal) ** 2, (y / diagonal) ** 2
    square = np.asarray(across + along)
    close = square < MULTIPOLES**2
    # Close to the cell, where this is replaced, it need only be finite. In place: anew, arrays as large
    # as a grid cost more than what is done with them.
    inverse = np.reciprocal(np.maximum(square, MULTIPOLES**2, out=square), out=square)
    cosine = np.asarray(across - along)
    cosine *= inverse
    result = multipoles(cosine, inverse, (half_x / diagonal) ** 2 - (half_y / diagonal) ** 2)
    result *= 4 * half_x * (half_y / diagonal)
    if close.any():
        sides = np.broadcast_arrays(x, y, half_x, half_y)
        result[close] = _close(*(a[close] for a in sides))
    return result


def multipoles(c: Array, q: Array, e: Array) -> Array:
    """Mean of ``1 / |r - s|`` over the points s of a cell, in the unit of its half-diagonal d.

    ``c = cos 2 theta`` for the direction of r, ``q = (d / r)^2``, ``e = (dx^2 - dy^2) / (dx^2 + dy^2)``:
    ``sqrt(q)`` times the sum of ``q^k < (s / d)^2k P_2k(cos(r, s)) >``.
    """
    ee = e * e
    moments = (
        (1.0,),
        (1 / 12, e / 4),
        ((28 - 67 * ee) / 480, e / 16, 7 * (4 * ee - 1) / 96),
        (
            (18 - 37 * ee) / 896,
            7 * e * (4 - 7 * ee) / 128,
            3 * (4 * ee - 1) / 128,
            33 * e * (2 * ee - 1) / 128,
        ),
    )
    total, moment = np.zeros_like(q), np.empty_like(q)
    for polynomial in reversed(moments):
        total *= q
        moment[...] = polynomial[-1]
        for coefficient in polynomial[-2::-1]:
            moment *= c
            moment += coefficient
        total += moment
    total *= np.sqrt(q, out=moment)
    return total


def _close(x: Array, y: Array, half_x: Array, half_y: Array) -> Array:
    """The cell seen from near by, or along a side so long that it is not seen as a point."""
    across, along = x / half_x, y / half_y
    steps = np.maximum(across, along)
    near, far = steps < 2 * NEAR, steps >= 2 * FAR
    result = np.empty(x.shape)
    result[near] = _edges(x[near], y[near], half_x[near], half_y[near])
    for zone, points in ((~near & ~far, NEAR_POINTS), (far, FAR_POINTS)):
        wide = zone & (across >= along)
        result[wide] = _lines(x[wide], y[wide], half_x[wide], half_y[wide], points)
        long = zone & ~wide
        result[long] = _lines(y[long], x[long], half_y[long], half_x[long], points)
    return result


def line(x: Array, y: Array, half: Array) -> Array:
    """Integral of 1/r along a segment of half-length ``half``, ``x`` aside and ``y`` along its axis."""
    # Seen from outside the first form cancels, from inside the second.
    within = y < 2 * half
    result = np.empty(x.shape)
    u, v, h = x[within], y[within], half[within]
    result[within] = np.arcsinh((v + h) / u) - np.arcsinh((v - h) / u)
    u, v, h = x[~within], y[~within], half[~within]
    # 2 artanh(2 h / ends), at a quarter of that function's time
    ends = np.hypot(u, v + h) + np.hypot(u, v - h)
    result[~within] = np.log1p(4 * h / (ends - 2 * h))
    return result


def _edges(x: Array, y: Array, half_x: Array, half_y: Array) -> Array:
    """The four edges of the cell, each times its distance (divergence theorem on ``(x, y) / r``)."""
    total = np.zeros(x.shape)
    for u, v, half_u, half_v in ((x, y, half_x, half_y), (y, x, half_y, half_x)):
        for outward in (1, -1):
            distance = u + outward * half_u
            # An edge seen from its own line has no share; any distance but zero stands in for it.
            aside = np.where(distance == 0, 1.0, np.abs(distance))
            total += outward * distance * line(aside, v, half_v)
    return total


def _lines(x: Array, y: Array, half_x: Array, half_y: Array, points: int) -> Array:
    """Gauss points across the cell, each a line along it."""
    total = np.zeros(x.shape)
    for node, weight in gauss(points):
        total += weight * line(x + node * half_x, y, half_y)
    return 2 * half_x * total


@cache
def gauss(points: int) -> tuple[tuple[float, float], ...]:
    """Gauss-Legendre nodes on (-1, 1) with weights that add up to one."""
    nodes, weights = leggauss(points)
    return tuple(zip(nodes.tolist(), (weights / 2).tolist(), strict=True))

"""Potential of a cell buried below the surface: of one cell, of a row, of a lattice of periodic images."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import k0

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement_cell import (
    NEAR_DISTANCE,
    NEAR_POINTS,
    mean_gauss_rule,
    segment_integral,
)
from contactstudy.elasticity.kernels.displacement_periodic import (
    FOURIER_END,
    FOURIER_START,
    FOURIER_TERMS,
    IMAGE_RATIO,
    QUADRATURE_ERROR,
    STRIPS,
    STRIPS_END,
    even_powers,
    further_images,
    harmonics_along,
)

# Beyond FAR_DISTANCE cells a line's field is analytic in a Bernstein ellipse of rho >= 160: 4 Gauss points suffice.
FAR_DISTANCE, FAR_POINTS = 40.0, 4
# Waves of a periodic logarithm that are summed; of more, near a shallow axis, the nearest zeros are split off, and
# SMOOTH_POINTS Gauss points leave 5.8^-48 of the rest.
MAX_SERIES_WAVES, SMOOTH_POINTS = 200, 24


def buried_cell(x: ArrayLike, y: ArrayLike, dx: float, dy: float, depth: float) -> Array:
    """Return the integral of ``1 / sqrt(r^2 + depth^2)`` over a rectangular cell: its potential at a depth.

    The error is below 1e-14 of the result at the origin, and below 1e-14 of the result itself beyond the cell.

    Parameters
    ----------
    x, y
        Offsets from the centre of the cell, which broadcast.
    dx, dy
        Sides of the cell; lengths are in one unit, and the result is in that unit.
    depth
        Distance below the surface, above zero.
    """
    x, y = np.broadcast_arrays(*(np.abs(np.asarray(a, dtype=np.float64)) for a in (x, y)))
    half_x, half_y = dx / 2, dy / 2
    steps_x = np.maximum(x, depth) / half_x
    steps_y = np.maximum(y, depth) / half_y
    steps = np.maximum(steps_x, steps_y)
    result = np.empty(x.shape)
    near = steps < 2 * NEAR_DISTANCE
    result[near] = _corners(x[near], y[near], half_x, half_y, depth)
    middle = ~near & (steps < 2 * FAR_DISTANCE)
    for zone, points in ((middle, NEAR_POINTS), (~near & ~middle, FAR_POINTS)):
        wide = zone & (steps_x >= steps_y)
        result[wide] = _lines(x[wide], y[wide], half_x, half_y, depth, points)
        long = zone & ~wide
        result[long] = _lines(y[long], x[long], half_y, half_x, depth, points)
    return result


def _lines(x: Array, y: Array, half_x: float, half_y: float, depth: float, points: int) -> Array:
    """Return the integral over a cell by Gauss `points` across it, each a line along it."""
    total = np.zeros(x.shape)
    for node, weight in mean_gauss_rule(points):
        aside = np.hypot(x + node * half_x, depth)
        total += weight * segment_integral(aside, y, np.full(y.shape, half_y))
    return 2 * half_x * total


def _corners(x: Array, y: Array, half_x: float, half_y: float, depth: float) -> Array:
    """Return the integral over a cell by its four edges.

    ``(x, y) / (r + depth)``, r the distance from the mirror source, has this divergence.
    """
    total = np.zeros(x.shape)
    for u, v, half_u, half_v in ((x, y, half_x, half_y), (y, x, half_y, half_x)):
        for outward in (1, -1):
            distance = u + outward * half_u
            side = segment_integral(np.hypot(distance, depth), v, np.full(v.shape, half_v))
            total += outward * distance * side
            for end in (1, -1):
                w = v + end * half_v
                square = distance**2 + w**2
                r = np.sqrt(square + depth**2)
                # atan(w / d) - atan(depth w / (d r)), as one angle
                angle = np.arctan2(
                    distance * w * square / (r + depth), distance**2 * r + depth * w**2
                )
                total -= outward * end * depth * angle
    return total


def buried_row(x: Array, y: Array, dx: float, dy: float, period: float, depth: float) -> Array:
    """Return :func:`buried_cell` repeated with `period` along y, less its divergent shift; x is a column and y a row.

    The mean over a period is ``-(dx dy / L) mean ln(x^2 + depth^2)``. Source: that of
    :func:`~contactstudy.kernels.boussinesq_cell_periodic`, with the distance from the axis in place of x.
    """
    across, along = np.abs(x).ravel(), np.fmod(np.abs(y.ravel()), period)
    along = np.minimum(along, period - along)
    mean = -(dx * dy / period) * log_mean(across, dx / 2, depth)
    return mean[:, None] + buried_harmonics(across, along, dx, dy, period, depth)


def buried_harmonics(
    x: Array, y: Array, dx: float, dy: float, period: float, depth: float
) -> Array:
    """Return the part of :func:`buried_row` that varies along y (x, y).

    `x` and `y` are flat, x at least 0 and y up to half a period.
    """
    result = np.zeros((x.size, y.size))
    if dy == period:
        return result
    inner = np.hypot(np.maximum(x - dx / 2, 0), depth) / period
    varies = inner < FOURIER_END
    if dx > period:
        breakpoints = np.linspace(-STRIPS_END, STRIPS_END, STRIPS + 1) * period
        for row in np.flatnonzero(varies):
            for start, end in pairwise(breakpoints.tolist()):
                low, high = max(x[row] - dx / 2, start), min(x[row] + dx / 2, end)
                if low < high:
                    middle = np.array([abs(low + high) / 2])
                    result[row] += buried_harmonics(middle, y, high - low, dy, period, depth)[0]
        return result
    forms: dict[Callable[..., Array], NDArray[np.bool_]] = {
        _fourier: varies & (inner >= FOURIER_START),
        _images: varies & (inner < FOURIER_START),
    }
    for form, rows in forms.items():
        if rows.any():
            result[rows] = form(x[rows], y, dx, dy, period, depth)
    return result


def _fourier(x: Array, y: Array, dx: float, dy: float, period: float, depth: float) -> Array:
    """Return the part that varies along y, by its harmonics, away from the axis."""
    inner = float(np.hypot(np.maximum(x - dx / 2, 0), depth).min()) / period
    count = int(np.ceil(FOURIER_TERMS * FOURIER_START / inner))
    wave = 2 * np.pi / period * np.arange(1, count + 1)
    across = np.zeros((x.size, count))
    for node, weight in _points(x, dx / 2, depth):
        across += 4 * weight * k0(np.multiply.outer(np.hypot(x + node * dx / 2, depth), wave))
    along = harmonics_along(y, dy / 2, period, count)
    return np.asarray(across @ along * (dx * dy / period))


def _images(x: Array, y: Array, dx: float, dy: float, period: float, depth: float) -> Array:
    """Return the part that varies along y near the axis: images one by one, and further ones as multipoles."""
    farthest = float(np.hypot(x + dx / 2, depth).max())
    reach = float(np.hypot(farthest, y.max(initial=0.0) + dy / 2)) / period
    images = max(1, int(np.ceil(reach / IMAGE_RATIO)) - 1)
    total = np.zeros((x.size, y.size))
    for m in range(-images, images + 1):
        total += buried_cell(x[:, None], y + m * period, dx, dy, depth)
    terms = int(np.log(QUADRATURE_ERROR) / (2 * np.log(reach / (images + 1)))) + 1
    halves = np.array([dx, dy]) / (2 * period)
    powers_x = even_powers(x / period, halves[0], images, terms, depth / period)
    powers_y = even_powers(y / period, halves[1], images, terms)
    further = powers_x @ further_images(images, terms) @ powers_y.T - 2 * np.log(2 * period)
    further += log_mean(x, dx / 2, depth)[:, None]
    return np.asarray(total + further * (dx * dy / period))


def buried_lattice(
    x: Array, y: Array, dx: float, dy: float, width: float, period: float, depth: float
) -> Array:
    """Return :func:`buried_cell` repeated along both axes, counted from its mean; x is a column and y a row."""
    if period > width:
        swapped = y.reshape(-1, 1), x.reshape(1, -1)
        return buried_lattice(*swapped, dy, dx, period, width, depth).T
    across, along = (np.fmod(np.abs(a.ravel()), length) for a, length in ((x, width), (y, period)))
    across, along = np.minimum(across, width - across), np.minimum(along, period - along)
    total = -(dx * dy / period) * _log_mean_periodic(across, dx / 2, depth, width)[:, None]
    rows = int(np.ceil(FOURIER_END * period / width)) + 1
    for m in range(-rows, rows + 1):
        distance = np.abs(across + m * width)
        total = total + buried_harmonics(distance, along, dx, dy, period, depth)
    return np.asarray(total)


def log_mean(x: Array, half: float, depth: float) -> Array:
    """Return the mean of ``ln(x^2 + depth^2)`` over segments of half-length `half` about each x."""
    result = np.empty(x.shape)
    near = np.hypot(x, depth) < 3 * half
    if not near.all():
        far = x[~near]
        result[~near] = sum(
            weight * np.log((far + node * half) ** 2 + depth**2)
            for node, weight in _points(np.array([3 * half]), half, 0.0)
        )
    upper, lower = (_log_integral(x[near] + end * half, depth) for end in (1, -1))
    result[near] = (upper - lower) / (2 * half)
    return result


def _log_integral(x: Array, depth: float) -> Array:
    """Return the integral of ``ln(x^2 + depth^2)`` over x from 0."""
    return np.asarray(x * np.log(x * x + depth**2) - 2 * x + 2 * depth * np.arctan(x / depth))


def _log_mean_periodic(x: Array, half: float, depth: float, width: float) -> Array:
    """Return the mean of ``ln |2 sin(pi (x + i depth) / W)|^2`` over segments of half-length `half` about each x.

    Its mean over a period W is left out; x is up to half of it (Johnson 1985, sect. 13.2).
    """
    waves = int(np.ceil(-np.log(QUADRATURE_ERROR) / (2 * np.pi * depth / width)))
    if waves <= MAX_SERIES_WAVES:
        k = np.arange(1, waves + 1)
        strength = 2 / k * np.exp(-2 * np.pi * k * depth / width) * np.sinc(2 * k * half / width)
        return np.asarray(-np.cos(np.multiply.outer(x, 2 * np.pi * k / width)) @ strength)
    near = log_mean(x, half, depth) + log_mean(width - x, half, depth)
    near += log_mean(width + x, half, depth)
    # the sine without its nearest zeros is smooth: the next ones lie two widths away
    smooth = np.zeros(x.shape)
    for node, weight in mean_gauss_rule(SMOOTH_POINTS):
        w = (x + node * half + 1j * depth) / width
        smooth += weight * 2 * np.log(np.abs(2 * np.sin(np.pi * w) / (w * (1 - w) * (1 + w))))
    return np.asarray(near + smooth - 6 * np.log(width) - 2 * np.pi * depth / width)


def _points(x: Array, half: float, depth: float) -> tuple[tuple[float, float], ...]:
    """Return Gauss points on segments for a field that is singular at ``+-i depth`` from the axis."""
    away = (x + 1j * depth) / half
    radius = np.abs(away + np.sqrt(away - 1) * np.sqrt(away + 1)).min()
    return mean_gauss_rule(1 + int(np.log(QUADRATURE_ERROR) / (-2 * np.log(radius))))

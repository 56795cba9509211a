"""Short-ranged remainder of a layer's displacement under a loaded cell."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.special import j0, j1, k0, k1

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement_cell import mean_gauss_rule
from contactstudy.elasticity.kernels.displacement_periodic import QUADRATURE_ERROR
from contactstudy.elasticity.kernels.layer.response import LayerResponse, composite
from contactstudy.elasticity.kernels.traction import SWAPPED

# Values in one array operation, so that work arrays stay small.
VALUES_AT_ONCE = 1 << 20
# The tables' pieces are [0, 1], [1, 2], [2, 4] ... thicknesses: singularities at two thicknesses and, of
# the far form, at zero lie outside a Bernstein ellipse of rho = 5.8.
CHEBYSHEV_POINTS = 22
# R is below 2e-14 of its largest beyond this k, and exp(-x) is neglected beyond this x.
LAST_WAVE, NEGLIGIBLE_EXPONENT = 20.0, 42.0
# Remainders, in the order of those of a response.
PRESSED, ALONG, COUPLING, ACROSS = range(4)


def remainder_cell(
    response: LayerResponse, name: str, thickness: float, x: Array, y: Array, dx: float, dy: float
) -> Array:
    """Return the displacement by the remainder R of a layer's `response`, integrated over a cell of sides `dx`, `dy`.

    With s the distance and k the wave number, in thicknesses, the integrand is, by `name` as in
    :class:`~contactstudy.elasticity.coating.CoatingCoefficients`:

    - "z": ``int R J0(k s) dk`` of pressure;
    - "x": ``-(d/dx) int R J0(k s) / k dk`` of the coupling;
    - "xx": ``int T J0(k s) dk - (d/dx)^2 int (L - T) J0(k s) / k^2 dk`` of shear along and across the wave;
    - "xy": ``-(d/dx) (d/dy) int (L - T) J0(k s) / k^2 dk``; "y" and "yy" are those with the axes exchanged.

    The offsets `x` and `y` broadcast; functions of x or of y alone are evaluated once for each value, so these should be
    few or form a grid. All lengths are in one unit, and so is the result. The integral is one along the edges of the
    cell, each by Gauss points on pieces that grow with their distance from the field point.
    """
    x, y = (np.asarray(a, dtype=np.float64) for a in (x, y))
    shape = np.broadcast_shapes(x.shape, y.shape)
    xs, at_x = np.unique(np.abs(x), return_inverse=True)
    ys, at_y = np.unique(np.abs(y), return_inverse=True)
    across, along = (
        CellEdges(xs / thickness, dx / thickness),
        CellEdges(ys / thickness, dy / thickness),
    )
    corners = quadrant(response, name, across.unique_edges, along.unique_edges)
    # a corner is even along an axis along which the field is odd
    odd_x, odd_y = (name.count(axis) % 2 for axis in "xy")
    cells = along.difference(across.difference(corners, odd_x).T, odd_y).T * thickness
    at_x, at_y = at_x.reshape(x.shape), at_y.reshape(y.shape)
    sign = (np.sign(x) if odd_x else 1) * (np.sign(y) if odd_y else 1)
    return np.asarray(sign * cells[at_x, at_y]).reshape(shape)


class RadialTable:
    """Table of a radial field by the remainder R of a :class:`LayerResponse`, filled as it is used.

    The field is ``(1 / s) int R(k) J1(k s) / k dk``: times the distance s, in thicknesses, it is the radial field with
    the divergence ``int R(k) J0(k s) dk``. Of the coupling it is ``int R(k) J0(k s) / k dk``.
    """

    def __init__(self, response: LayerResponse, number: int) -> None:
        self.response, self.number = response, number
        self._pieces: dict[int, Array] = {}

    def __call__(self, s: Array) -> Array:
        """Return the field at distances `s`."""
        # frexp: s in [2^(e-1), 2^e)
        piece = np.maximum(np.frexp(s)[1], 0)
        result = np.empty(s.shape)
        for number in np.unique(piece).tolist():
            start, end = (0.0, 1.0) if number == 0 else (2.0 ** (number - 1), 2.0**number)
            if number not in self._pieces:
                nodes = chebyshev.chebpts1(CHEBYSHEV_POINTS)
                values = self._field_at((start + end) / 2 + (end - start) / 2 * nodes)
                self._pieces[number] = chebyshev.chebfit(nodes, values, CHEBYSHEV_POINTS - 1)
            chosen = piece == number
            local = (2 * s[chosen] - start - end) / (end - start)
            result[chosen] = chebyshev.chebval(local, self._pieces[number])
        return result

    def _field_at(self, s: Array) -> Array:
        """Return the field at distances `s` in order, by quadrature over k."""
        response, coupled = self.response, self.number == COUPLING
        if s[0] >= NEGLIGIBLE_EXPONENT / response.pole_distance_from_real_axis:
            # along the imaginary axis, where J0 and J1 decay as K0 and K1; the neglected part is below rounding
            tau, weight = self._imaginary(float(s[0]))
            remainder = response.remainders(1j * tau)[self.number]
            slope = response.slopes[self.number]
            if coupled:  # the slope's part is known: it is singular at zero
                odd = (np.imag(remainder) / tau - slope) * weight
                return np.asarray(slope / s + 2 / np.pi * k0(np.multiply.outer(s, tau)) @ odd)
            far = k1(np.multiply.outer(s, tau)) @ (np.real(remainder) / tau * weight)
            return np.asarray((slope / s - 2 / np.pi * far) / s)
        k, weight = self._real(float(s[-1]))
        integrand = np.real(response.remainders(k)[self.number]) / k * weight
        if coupled:
            return np.asarray(j0(np.multiply.outer(s, k)) @ integrand)
        return np.asarray(j1(np.multiply.outer(s, k)) @ integrand / s)

    def _real(self, s: float) -> tuple[Array, Array]:
        """Return Gauss points and weights for integrals over k of a field that oscillates with ``k s``."""
        longest = min(0.5, 4 * np.pi / max(s, 1.0))
        ends = [0.0, min(self.response.pole_distance_from_zero, longest)]
        while ends[-1] < LAST_WAVE:
            ends.append(ends[-1] + min(ends[-1], longest))
        return composite(np.array(ends))

    def _imaginary(self, s: float) -> tuple[Array, Array]:
        """Return Gauss points and weights for integrals over tau of a field that decays like ``exp(-s tau)``."""
        end = min(self.response.pole_distance_from_real_axis, NEGLIGIBLE_EXPONENT / s)
        start = 1e-3 * min(self.response.pole_distance_from_zero, 1 / s)
        count = int(np.ceil(np.log2(end / start)))
        return composite(np.concatenate([[0.0], np.geomspace(start, end, count + 1)]))


@lru_cache(maxsize=128)
def radial_table(response: LayerResponse, number: int) -> RadialTable:
    """Return the table of one stack of materials, by the number of the remainder."""
    return RadialTable(response, number)


class CellEdges:
    """The two edges of each cell along one axis, with equal ones listed once in `unique_edges`."""

    def __init__(self, centres: Array, size: float) -> None:
        ends = np.concatenate([centres + size / 2, centres - size / 2])
        self.unique_edges, self._which = unique_within_rounding(np.abs(ends))
        self._sign = np.sign(ends)

    def difference(self, values: Array, even: int = 0) -> Array:
        """Return the difference of a function, given at `unique_edges` (edges, ...), between edges of each cell.

        The function is odd, or `even`.
        """
        upper, lower = np.split(values[self._which] * (1 if even else self._sign[:, None]), 2)
        return np.asarray(upper - lower)


def unique_within_rounding(values: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return the values that differ by more than rounding, in order, and the index among them of each value."""
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    is_new = np.diff(ordered, prepend=-np.inf) > 64 * np.finfo(np.float64).eps * ordered[-1]
    which = np.empty(values.size, dtype=np.intp)
    which[order] = np.cumsum(is_new) - 1
    return ordered[is_new], which


def quadrant(response: LayerResponse, name: str, x: Array, y: Array) -> Array:
    """Return the integral of :func:`remainder_cell` up to each corner (x, y), of at least 0 thicknesses.

    It is that over the rectangle from the field point, but for terms that corners of a cell have in common.
    """
    if name in ("y", "yy"):
        return quadrant(response, SWAPPED[name], y, x).T
    if name == "x":
        return -_along_edges(radial_table(response, COUPLING), x, y)
    transverse = 1 / (1 - response.poisson_ratios[0])  # over the same compliance as the others
    if name == "xy":
        along, across = (radial_table(response, number) for number in (ALONG, ACROSS))
        return _along_edges(lambda s: along(s) - transverse * across(s), x, y, power=1)
    on_x, on_y, weight = (PRESSED, PRESSED, 1.0) if name == "z" else (ALONG, ACROSS, transverse)
    first = x[:, None] * _along_edges(radial_table(response, on_x), x, y)
    second = weight * y[:, None] * _along_edges(radial_table(response, on_y), y, x)
    return np.asarray(first + second.T)


def _along_edges(
    field: Callable[[Array], Array], aside: Array, ends: Array, power: int = 0
) -> Array:
    """Return ``int_0^t t'^power field(sqrt(d^2 + t'^2)) dt'`` for distances d `aside` and t in `ends` (aside, ends).

    Both are in order.
    """
    scale = float(np.hypot(aside[0], 2.0))
    breakpoints, positions = _breakpoints(ends, scale)
    middle, half = (breakpoints[1:] + breakpoints[:-1]) / 2, np.diff(breakpoints) / 2
    away = (middle + 1j * scale) / half
    radius = np.log(np.abs(away + np.sqrt(away - 1) * np.sqrt(away + 1)))
    counts = np.ceil(np.log(QUADRATURE_ERROR) / (-2 * radius)).astype(int)
    pieces = np.empty((aside.size, half.size))
    for count in np.unique(counts).tolist():
        nodes, weights = np.array(mean_gauss_rule(count)).T
        chosen = np.flatnonzero(counts == count)
        along = middle[chosen, None] + half[chosen, None] * nodes
        square, factor = along**2, along**power
        step = max(1, VALUES_AT_ONCE // square.size)
        for start in range(0, aside.size, step):
            rows = slice(start, start + step)
            distance = np.sqrt(square + (aside[rows] ** 2)[:, None, None])
            pieces[rows, chosen] = ((field(distance) * factor) @ weights) * (2 * half[chosen])
    summed = np.concatenate([np.zeros((aside.size, 1)), np.cumsum(pieces, axis=1)], axis=1)
    return np.asarray(summed[:, positions])


def _breakpoints(ends: Array, scale: float) -> tuple[Array, NDArray[np.intp]]:
    """Return ends of pieces from zero on, among them all of `ends`, and the indices of these.

    No piece is longer than its distance from the field point, or than `scale` next to it.
    """
    farthest = max(float(ends[-1]), scale)
    growing = scale * 2.0 ** np.arange(np.ceil(np.log2(farthest / scale)))
    after = np.searchsorted(ends, growing)
    before = np.where(after > 0, ends[np.maximum(after - 1, 0)], 0.0)
    gap = ends[np.minimum(after, ends.size - 1)] - before
    useful = growing[(gap > growing / 2) & (after < ends.size)]
    breakpoints = np.unique(np.concatenate([[0.0], ends, useful]))
    return breakpoints, np.searchsorted(breakpoints, ends)

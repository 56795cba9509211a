"""Short-ranged remainder of a layer's displacement under a loaded cell."""

from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.special import j1, k1

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement_cell import mean_gauss_rule
from contactstudy.elasticity.kernels.displacement_periodic import QUADRATURE_ERROR
from contactstudy.elasticity.kernels.layer.response import LayerResponse, composite

# Values in one array operation, so that work arrays stay small.
VALUES_AT_ONCE = 1 << 20
# The tables' pieces are [0, 1], [1, 2], [2, 4] ... thicknesses: singularities at two thicknesses and, of
# the far form, at zero lie outside a Bernstein ellipse of rho = 5.8.
CHEBYSHEV_POINTS = 22
# R is below 2e-14 of its largest beyond this k, and exp(-x) is neglected beyond this x.
LAST_WAVE, NEGLIGIBLE_EXPONENT = 20.0, 42.0


def remainder_cell(
    response: LayerResponse, thickness: float, x: Array, y: Array, dx: float, dy: float
) -> Array:
    """Return the integral of ``g(r / h) / h`` over a rectangular cell of sides `dx` and `dy`.

    With ``g(s) = int R(k) J0(k s) dk`` it is the displacement by the remainder R of a layer's `response` to pressure, h
    the `thickness`. The offsets `x` and `y` broadcast; functions of x or of y alone are evaluated once for each value,
    so these should be few or form a grid. All lengths are in one unit, and so is the result. Source: the radial field
    whose divergence is g, integrated along the four edges of the cell, each by Gauss points on pieces that grow with
    their distance from the field point.
    """
    x, y = (np.asarray(a, dtype=np.float64) for a in (x, y))
    shape = np.broadcast_shapes(x.shape, y.shape)
    xs, at_x = np.unique(np.abs(x), return_inverse=True)
    ys, at_y = np.unique(np.abs(y), return_inverse=True)
    across, along = (
        CellEdges(xs / thickness, dx / thickness),
        CellEdges(ys / thickness, dy / thickness),
    )
    corners = quadrant(radial_table(response), across.unique_edges, along.unique_edges)
    cells = along.difference(across.difference(corners).T).T * thickness
    at_x, at_y = at_x.reshape(x.shape), at_y.reshape(y.shape)
    return np.asarray(cells[at_x, at_y]).reshape(shape)


class RadialTable:
    """Table of ``(1 / s) int R(k) J1(k s) / k dk``, with R the remainder of a :class:`LayerResponse` under pressure.

    Times the distance s, in thicknesses, it is the radial field with the divergence ``int R(k) J0(k s) dk``. The table
    is filled as it is used.
    """

    def __init__(self, response: LayerResponse) -> None:
        self.response = response
        self._pieces: dict[int, Array] = {}

    def __call__(self, s: Array) -> Array:
        """Return the field over the distance, at distances `s`."""
        # frexp: s in [2^(e-1), 2^e)
        piece = np.maximum(np.frexp(s)[1], 0)
        result = np.empty(s.shape)
        for number in np.unique(piece).tolist():
            start, end = (0.0, 1.0) if number == 0 else (2.0 ** (number - 1), 2.0**number)
            if number not in self._pieces:
                nodes = chebyshev.chebpts1(CHEBYSHEV_POINTS)
                values = self._edge_at((start + end) / 2 + (end - start) / 2 * nodes)
                self._pieces[number] = chebyshev.chebfit(nodes, values, CHEBYSHEV_POINTS - 1)
            chosen = piece == number
            local = (2 * s[chosen] - start - end) / (end - start)
            result[chosen] = chebyshev.chebval(local, self._pieces[number])
        return result

    def _edge_at(self, s: Array) -> Array:
        """Return the field over the distance at distances `s` in order, by quadrature over k."""
        response = self.response
        if s[0] >= NEGLIGIBLE_EXPONENT / response.pole_distance_from_real_axis:
            # along the imaginary axis, where J1 decays as K1; the neglected part is below rounding
            tau, weight = self._imaginary(float(s[0]))
            even = np.real(response.remainder(1j * tau)) / tau
            far = k1(np.multiply.outer(s, tau)) @ (even * weight)
            return np.asarray((response.slope / s - 2 / np.pi * far) / s)
        k, weight = self._real(float(s[-1]))
        integrand = np.real(response.remainder(k)) / k * weight
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


@lru_cache(maxsize=32)
def radial_table(response: LayerResponse) -> RadialTable:
    """Return the table of one stack of materials."""
    return RadialTable(response)


class CellEdges:
    """The two edges of each cell along one axis, with equal ones listed once in `unique_edges`."""

    def __init__(self, centres: Array, size: float) -> None:
        ends = np.concatenate([centres + size / 2, centres - size / 2])
        self.unique_edges, self._which = unique_within_rounding(np.abs(ends))
        self._sign = np.sign(ends)

    def difference(self, values: Array) -> Array:
        """Return the difference of an odd function, given at `unique_edges` (edges, ...), between edges of each cell."""
        upper, lower = np.split(values[self._which] * self._sign[:, None], 2)
        return np.asarray(upper - lower)


def unique_within_rounding(values: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return the values that differ by more than rounding, in order, and the index among them of each value."""
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    is_new = np.diff(ordered, prepend=-np.inf) > 64 * np.finfo(np.float64).eps * ordered[-1]
    which = np.empty(values.size, dtype=np.intp)
    which[order] = np.cumsum(is_new) - 1
    return ordered[is_new], which


def quadrant(table: RadialTable, x: Array, y: Array) -> Array:
    """Return the integral of ``g`` over rectangles from the field point to each (x, y), of at least 0 thicknesses."""
    across = x[:, None] * _along_edges(table, x, y)
    along = y[:, None] * _along_edges(table, y, x)
    return np.asarray(across + along.T)


def _along_edges(table: RadialTable, aside: Array, ends: Array) -> Array:
    """Return ``int_0^t table(sqrt(d^2 + t'^2)) dt'`` for all distances d `aside` and all t in `ends` (aside, ends).

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
        square = (middle[chosen, None] + half[chosen, None] * nodes) ** 2
        step = max(1, VALUES_AT_ONCE // square.size)
        for start in range(0, aside.size, step):
            rows = slice(start, start + step)
            distance = np.sqrt(square + (aside[rows] ** 2)[:, None, None])
            pieces[rows, chosen] = (table(distance) @ weights) * (2 * half[chosen])
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

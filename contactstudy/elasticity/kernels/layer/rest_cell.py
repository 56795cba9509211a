"""The layer's rest under one loaded cell."""

from functools import cache

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.kernels.layer.frf import LayerResponse
from contactstudy.elasticity.kernels.layer.tables import RestInSpace, rest_in_space

# Gauss points leave this share of what they integrate.
ROUNDING = 1e-17
# Values at a time, so that work arrays stay small.
AT_ONCE = 1 << 20


def rest_cell(
    response: LayerResponse, thickness: float, x: Array, y: Array, dx: float, dy: float
) -> Array:
    """Integral of ``g(r / h) / h``, ``g(s) = int R(k) J0(k s) dk``, over a cell ``(x, y)`` away; x and y broadcast.

    Lengths in one common unit, the result in that unit, for any thickness h. What depends on x and on y
    alone is found once for each of their values, so x and y should be few or form a grid.

    Source: the radial field with this divergence, integrated along the four edges of the cell, each by
    Gauss points on pieces that grow with their distance from the observer.
    """
    x, y = (np.asarray(a, dtype=np.float64) for a in (x, y))
    shape = np.broadcast_shapes(x.shape, y.shape)
    xs, at_x = np.unique(np.abs(x), return_inverse=True)
    ys, at_y = np.unique(np.abs(y), return_inverse=True)
    sides = [_Edges(xs / thickness, dx / thickness), _Edges(ys / thickness, dy / thickness)]
    corners = quadrant(rest_in_space(response), sides[0].levels, sides[1].levels)
    cells = sides[1].difference(sides[0].difference(corners).T).T * thickness
    at_x, at_y = at_x.reshape(x.shape), at_y.reshape(y.shape)
    return np.asarray(cells[at_x, at_y]).reshape(shape)


class _Edges:
    """The two edges of each cell along one axis, equal ones once."""

    def __init__(self, centres: Array, size: float) -> None:
        ends = np.concatenate([centres + size / 2, centres - size / 2])
        self.levels, self._which = levels(np.abs(ends))
        self._sign = np.sign(ends)

    def difference(self, values: Array) -> Array:
        """An odd function of the edges, given at ``levels`` along the first axis, between each two edges."""
        upper, lower = np.split(values[self._which] * self._sign[:, None], 2)
        return np.asarray(upper - lower)


def levels(values: Array) -> tuple[Array, NDArray[np.intp]]:
    """Values that differ by more than rounding, in order, and which of them each is."""
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    apart = np.diff(ordered, prepend=-np.inf) > 64 * np.finfo(np.float64).eps * ordered[-1]
    which = np.empty(values.size, dtype=np.intp)
    which[order] = np.cumsum(apart) - 1
    return ordered[apart], which


def quadrant(table: RestInSpace, x: Array, y: Array) -> Array:
    """Integral of ``g`` over rectangles from the observer to each (x, y), both from 0 on in thicknesses."""
    across = x[:, None] * _along_edges(table, x, y)
    along = y[:, None] * _along_edges(table, y, x)
    return np.asarray(across + along.T)


def _along_edges(table: RestInSpace, aside: Array, ends: Array) -> Array:
    """``int_0^t edge(sqrt(d^2 + t'^2)) dt'`` for all distances d ``aside`` and all t in ``ends``, both in order."""
    scale = float(np.hypot(aside[0], 2.0))
    marks, wanted = _marks(ends, scale)
    middle, half = (marks[1:] + marks[:-1]) / 2, np.diff(marks) / 2
    away = (middle + 1j * scale) / half
    radius = np.log(np.abs(away + np.sqrt(away - 1) * np.sqrt(away + 1)))
    counts = np.ceil(np.log(ROUNDING) / (-2 * radius)).astype(int)
    pieces = np.empty((aside.size, half.size))
    for count in np.unique(counts).tolist():
        nodes, weights = _gauss(count)
        chosen = np.flatnonzero(counts == count)
        square = (middle[chosen, None] + half[chosen, None] * nodes) ** 2
        step = max(1, AT_ONCE // square.size)
        for start in range(0, aside.size, step):
            rows = slice(start, start + step)
            distance = np.sqrt(square + (aside[rows] ** 2)[:, None, None])
            pieces[rows, chosen] = (table.edge(distance) @ weights) * half[chosen]
    summed = np.concatenate([np.zeros((aside.size, 1)), np.cumsum(pieces, axis=1)], axis=1)
    return np.asarray(summed[:, wanted])


def _marks(ends: Array, scale: float) -> tuple[Array, NDArray[np.intp]]:
    """Ends of pieces from zero on, among them all of ``ends``, and where these are.

    None is longer than its distance from the observer, or than ``scale`` next to it.
    """
    farthest = max(float(ends[-1]), scale)
    growing = scale * 2.0 ** np.arange(np.ceil(np.log2(farthest / scale)))
    after = np.searchsorted(ends, growing)
    before = np.where(after > 0, ends[np.maximum(after - 1, 0)], 0.0)
    gap = ends[np.minimum(after, ends.size - 1)] - before
    useful = growing[(gap > growing / 2) & (after < ends.size)]
    marks = np.unique(np.concatenate([[0.0], ends, useful]))
    return marks, np.searchsorted(marks, ends)


@cache
def _gauss(points: int) -> tuple[Array, Array]:
    nodes, weights = leggauss(points)
    return nodes, weights

"""Short-ranged remainder of a layer's displacement under a loaded cell."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement_cell import mean_gauss_rule
from contactstudy.elasticity.kernels.displacement_periodic import QUADRATURE_ERROR
from contactstudy.elasticity.kernels.layer.response import (
    LayerResponse,
    RemainderTables,
    remainder_tables,
)

# Values in one array operation, so that work arrays stay small.
VALUES_AT_ONCE = 1 << 20


@dataclass(frozen=True)
class LayerRemainder:
    """Influence coefficients of the short-ranged remainder R(k) of a :class:`LayerResponse`.

    They are integrals over a cell of ``g(r / h) / h`` with ``g(s) = int R(k) J0(k s) dk``.

    Parameters
    ----------
    response
        Response of the layer to a wave of pressure, which gives R.
    thickness
        Thickness h of the layer. All lengths are in one unit, and so are the results.
    """

    response: LayerResponse
    thickness: float

    @property
    def tables(self) -> RemainderTables:
        """Tables of R in space."""
        return remainder_tables(self.response)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the integral over a rectangular cell of sides `dx` and `dy`; the offsets `x` and `y` broadcast.

        Functions of x or of y alone are evaluated once for each value, so these should be few or form a grid. Source:
        the radial field whose divergence is g, integrated along the four edges of the cell, each by Gauss points on
        pieces that grow with their distance from the field point.
        """
        x, y = (np.asarray(a, dtype=np.float64) for a in (x, y))
        shape = np.broadcast_shapes(x.shape, y.shape)
        xs, at_x = np.unique(np.abs(x), return_inverse=True)
        ys, at_y = np.unique(np.abs(y), return_inverse=True)
        across = CellEdges(xs / self.thickness, dx / self.thickness)
        along = CellEdges(ys / self.thickness, dy / self.thickness)
        corners = quadrant(self.tables, across.unique_edges, along.unique_edges)
        cells = along.difference(across.difference(corners).T).T * self.thickness
        at_x, at_y = at_x.reshape(x.shape), at_y.reshape(y.shape)
        return np.asarray(cells[at_x, at_y]).reshape(shape)


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


def quadrant(table: RemainderTables, x: Array, y: Array) -> Array:
    """Return the integral of ``g`` over rectangles from the field point to each (x, y), of at least 0 thicknesses."""
    across = x[:, None] * _along_edges(table, x, y)
    along = y[:, None] * _along_edges(table, y, x)
    return np.asarray(across + along.T)


def _along_edges(table: RemainderTables, aside: Array, ends: Array) -> Array:
    """Return ``int_0^t edge(sqrt(d^2 + t'^2)) dt'`` for all distances d `aside` and all t in `ends` (aside, ends).

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
            pieces[rows, chosen] = (table.edge(distance) @ weights) * (2 * half[chosen])
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

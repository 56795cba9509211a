"""Short-ranged remainder of a layer's displacement under a loaded cell: alone, in a row, in a lattice."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.special import binom, digamma, zeta

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.displacement_cell import mean_gauss_rule
from contactstudy.elasticity.kernels.displacement_periodic import QUADRATURE_ERROR
from contactstudy.elasticity.kernels.layer.response import (
    LAST_WAVE,
    LayerResponse,
    RemainderTables,
    remainder_tables,
)
from contactstudy.elasticity.kernels.stress_periodic import chebyshev_interpolation

# Values in one array operation, so that work arrays stay small.
VALUES_AT_ONCE = 1 << 20
# exp(-NEGLIGIBLE_DECAY) is below rounding. Harmonics of the period decay like exp(-2 pi x / L): VARYING_PERIODS from a
# cell nothing varies along the length.
NEGLIGIBLE_DECAY, VARYING_PERIODS = 37.0, 6.0
# Evaluations of the response that a Fourier series may take; beyond them images are summed in space. TERM_COST is the
# cost of a term of a sum over waves in evaluations.
MAX_EVALUATIONS, TERM_COST = 5e6, 0.02
# Distance, times that of the singularity of R nearest to zero, beyond which three powers of the distance suffice.
FAR_FIELD_DISTANCE = 100.0
# Images that are interpolated lie a period or more beyond the interval of half a period on either side: SMOOTH_POINTS
# Chebyshev points leave 5.8^-24 along it. The far field begins at twice the distance across: TAIL_TERMS leave 4^-14.
SMOOTH_POINTS, TAIL_TERMS, IMAGES_AT_ONCE = 24, 14, 64
# Waves that a Fourier series of both axes may take, and that of strips; beyond them images are summed in space.
MAX_LATTICE_WAVES, MAX_STRIP_WAVES = 4e6, 3000


@dataclass(frozen=True)
class LayerRemainder:
    """Influence coefficients of the short-ranged remainder R(k) of a :class:`LayerResponse`.

    They are integrals over a cell of ``g(r / h) / h`` with ``g(s) = int R(k) J0(k s) dk``. Since g is short-ranged, sums
    over images converge.

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

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return :meth:`cell` repeated with `period` along y; x is a column and y a row, of any sign.

        The mean along the length is :meth:`strip`; the part that varies along it is :meth:`harmonics`.
        """
        across, along = np.abs(x).ravel(), y.ravel()
        mean = self.strip(across, dx) * (dy / period)
        return mean[:, None] + self.harmonics(across, along, dx, dy, period)

    def strip(self, x: Array, dx: float) -> Array:
        """Return the integral over a strip of width `dx`, infinite along y: a function of one distance."""
        upper, lower = ((x + side * dx / 2) / self.thickness for side in (1, -1))
        return np.asarray(
            2 * self.thickness * (self.tables.strip(upper) - self.tables.strip(lower))
        )

    def harmonics(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the part of :meth:`row` that varies along y (x, y): all but its mean over the period.

        It is a Fourier series where the layer is thick, and a sum over images where it is thin; both are exact. `x` and
        `y` are flat, x at least 0.
        """
        result = np.zeros((x.size, y.size))
        near = np.flatnonzero(x - dx / 2 < VARYING_PERIODS * period)
        if dy == period or not near.size:
            return result
        if dx > 2 * VARYING_PERIODS * period:  # beyond that, a cell adds nothing that varies
            end = VARYING_PERIODS * period
            for n in near.tolist():
                low, high = max(x[n] - dx / 2, -end), min(x[n] + dx / 2, end)
                middle = np.array([abs(low + high) / 2])
                result[n] = self.harmonics(middle, y, high - low, dy, period)[0]
            return result
        row = RemainderRow(self, dx, dy, period)
        form = (
            row.series if row.series_cost(float(x[near].max())) <= MAX_EVALUATIONS else row.images
        )
        result[near] = form(x[near], y)
        return result

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """Return :meth:`cell` repeated with `width` along x and `period` along y, less its mean.

        x is a column and y a row. It is a Fourier series where the layer is thick. Where it is thin, it is summed over
        rows of the shorter period: the part that varies along them vanishes within a few of their periods, and their
        mean is :meth:`strips`.
        """
        largest = LAST_WAVE / self.thickness / (2 * np.pi)
        waves = int(largest * width), int(largest * period)
        if waves[0] * waves[1] <= MAX_LATTICE_WAVES:
            return self._series(x.ravel(), y.ravel(), (dx, dy), (width, period), waves)
        if period > width:
            return self.lattice(y.reshape(-1, 1), x.reshape(1, -1), dy, dx, period, width).T
        across, along = np.abs(np.fmod(x.ravel(), width)), y.ravel()
        rows = int(np.ceil(VARYING_PERIODS * period / width)) + 1
        shifts = width * np.arange(-rows, rows + 1.0)
        distances = np.abs(across + shifts[:, None])
        varying = self.harmonics(distances.ravel(), along, dx, dy, period)
        mean = self.strips(across, dx, width) * (dy / period)
        return np.asarray(mean[:, None] + varying.reshape(*distances.shape, along.size).sum(axis=0))

    def _series(
        self,
        x: Array,
        y: Array,
        cell: tuple[float, float],
        periods: tuple[float, float],
        waves: tuple[int, int],
    ) -> Array:
        """Return :meth:`lattice` (x, y) by its Fourier series with that many `waves` along each axis."""
        q, fields = [], []
        for offset, size, period, count in zip((x, y), cell, periods, waves, strict=True):
            q.append(2 * np.pi / period * np.arange(count + 1))
            weight = 2 * size / period * np.sinc(q[-1] * size / (2 * np.pi))
            weight[0] /= 2
            fields.append(np.cos(np.multiply.outer(offset, q[-1])) * weight)
        wave = np.hypot(q[0][:, None], q[1])
        within = (wave > 0) & (wave * self.thickness < LAST_WAVE)
        response = np.real(self.response.remainder(wave[within] * self.thickness))
        spectrum = np.zeros(wave.shape)
        spectrum[within] = 2 * np.pi * response / wave[within]
        return np.asarray(fields[0] @ spectrum @ fields[1].T)

    def strips(self, x: Array, dx: float, width: float) -> Array:
        """Return :meth:`strip` repeated with `width` along x, less its mean."""
        h = self.thickness
        waves = int(LAST_WAVE / h * width / (2 * np.pi))
        if waves <= MAX_STRIP_WAVES:
            q = 2 * np.pi / width * np.arange(1, waves + 1)
            integrand = np.real(self.response.remainder(q * h)) / q * np.sinc(q * dx / (2 * np.pi))
            return np.asarray(
                np.cos(np.multiply.outer(x, q)) @ integrand * (4 * np.pi / width * dx)
            )
        far_field = FAR_FIELD_DISTANCE * h / self.response.pole_distance_from_zero
        last = int(np.ceil(max(far_field, 2 * dx) / width)) + 20
        total = -2 * np.pi * self.response.taylor[0] * h * dx / width * np.ones_like(x)
        _, second, fourth, sixth = self.response.taylor
        ratio = h / width
        for side in (1, -1):
            # beyond, the integral over a strip is between ends of 2 r2 h^2 / x - 4 r4 h^4 / x^3 + 48 r6 h^6 / x^5
            for end in (1, -1):
                edge = last + 1 + (side * x + end * dx / 2) / width
                far = -2 * second * ratio * digamma(edge)
                far -= 4 * fourth * ratio**3 * zeta(3, edge)
                far += 48 * sixth * ratio**5 * zeta(5, edge)
                total += end * h * far
            for image in range(1, last + 1):
                total += self.strip(image * width + side * x, dx)
        return np.asarray(total + self.strip(x, dx))


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


@dataclass(frozen=True)
class RemainderRow:
    """Row of images, with a `period` along y, of a cell of sides `dx` and `dy`."""

    remainder: LayerRemainder
    dx: float
    dy: float
    period: float

    @property
    def _count(self) -> int:
        """Number of harmonics along the length in the remainder."""
        return int(LAST_WAVE / self.remainder.thickness * self.period / (2 * np.pi))

    def _groups(self, farthest: float) -> list[tuple[int, int, float, float]]:
        """Return groups of harmonics up to a distance `farthest`.

        A group is a tuple of its first harmonic, the first one after it, the distance across beyond which they are
        negligible or not asked for, and the period across of their sum.
        """
        groups, first = [], 1
        while first <= self._count:
            decay = NEGLIGIBLE_DECAY * self.period / (2 * np.pi * first)
            reach = min(farthest, decay + self.dx / 2)
            groups.append(
                (first, min(2 * first, self._count + 1), reach, reach + self.dx / 2 + decay)
            )
            first *= 2
        return groups

    def series_cost(self, farthest: float) -> float:
        """Return the cost of :meth:`series` up to a distance `farthest`, in evaluations of the response."""
        cost = 0.0
        for first, end, reach, across in self._groups(farthest):
            waves = (end - first) * LAST_WAVE / self.remainder.thickness * across / (2 * np.pi)
            cost += waves * (1 + TERM_COST * reach / self.dx)
        return cost

    def series(self, x: Array, y: Array) -> Array:
        """Return the varying part (x, y) by harmonics along y.

        Each is an integral over waves across by the trapezoidal rule. The integrand is analytic within the harmonic's
        own wave number of the real axis, so that the rule, which makes the coefficients periodic across, is exact once
        they decay within the period.
        """
        total = np.zeros((x.size, y.size))
        for first, end, reach, across in self._groups(float(x.max(initial=0.0))):
            rows = np.flatnonzero(x <= reach)
            along = 2 * np.pi / self.period * np.arange(first, end)
            step = 2 * np.pi / across
            # the shortest wave across, given the group's first harmonic along
            last = np.sqrt(max((LAST_WAVE / self.remainder.thickness) ** 2 - along[0] ** 2, 0.0))
            crossing = step * np.arange(int(last / step) + 1)
            weight = 4 * step * np.sinc(crossing * self.dx / (2 * np.pi))
            weight[0] /= 2
            wave = np.hypot(crossing[:, None], along)
            wave *= self.remainder.thickness
            spectrum = np.zeros(wave.shape)
            within = wave < LAST_WAVE
            k = wave[within]
            spectrum[within] = np.real(self.remainder.response.remainder(k)) / k
            spectrum *= weight[:, None] * self.remainder.thickness
            spectrum *= np.sinc(along * self.dy / (2 * np.pi))
            fields = np.cos(np.multiply.outer(x[rows], crossing)) @ spectrum
            total[rows] += fields @ np.cos(np.multiply.outer(along, y))
        return total * (self.dx * self.dy / self.period)

    def images(self, x: Array, y: Array) -> Array:
        """Return the varying part (x, y) by images: the three nearest cell by cell, further ones on Chebyshev points."""
        y = np.abs(y - self.period * np.round(y / self.period))
        near = y + self.period * np.arange(-1.0, 2)[:, None]
        shape = x[:, None], near.ravel()
        total = self.remainder.cell(*shape, self.dx, self.dy)
        total = total.reshape(x.size, 3, y.size).sum(axis=1)
        mean = self.remainder.strip(x, self.dx) * (self.dy / self.period)
        total -= mean[:, None]
        return np.asarray(total + self._further(x, y))

    def _further(self, x: Array, y: Array) -> Array:
        """Return the sum over all images except the nearest three, which is smooth on the scale of the period."""
        period = self.period
        reach = max(float(x.max()), self.dx / 2)
        # singular where an image's edge is met, at least a period away
        slim = period / reach
        count = int(np.ceil(NEGLIGIBLE_DECAY / np.arcsinh(slim))) + 2
        nodes_x = reach * chebyshev.chebpts1(count)
        nodes_y = period / 2 * chebyshev.chebpts1(SMOOTH_POINTS)
        far_field = (
            FAR_FIELD_DISTANCE
            * self.remainder.thickness
            / self.remainder.response.pole_distance_from_zero
        )
        last = int(np.ceil(max(far_field, 2 * (reach + self.dx / 2)) / period)) + 2
        values = self._tail(nodes_x, nodes_y, last)
        images = np.arange(2.0, last + 1)
        for block in np.array_split(images, max(1, images.size // IMAGES_AT_ONCE)):
            numbers = np.concatenate([-block, block])
            away = (nodes_y + period * numbers[:, None]).ravel()
            cells = self.remainder.cell(nodes_x[:, None], away, self.dx, self.dy)
            values += cells.reshape(count, numbers.size, nodes_y.size).sum(axis=1)
        across = chebyshev_interpolation(nodes_x.size, x / reach)
        along = chebyshev_interpolation(nodes_y.size, y / (period / 2))
        return np.asarray(across @ values @ along.T)

    def _tail(self, x: Array, y: Array, last: int) -> Array:
        """Return the sum over images beyond the `last`, by their far field.

        It is ``-r2 h^2 / r^3 + 9 r4 h^4 / r^5 - 225 r6 h^6 / r^7``, with r2, r4, r6 the coefficients of R.
        """
        _, second, fourth, sixth = self.remainder.response.taylor
        h, period = self.remainder.thickness, self.period
        powers = (3, -second * h**2), (5, 9 * fourth * h**4), (7, -225 * sixth * h**6)
        total = np.zeros((x.size, y.size))
        for node_x, weight_x in mean_gauss_rule(4):
            u = np.abs(x + node_x * self.dx / 2)[:, None]
            for node_y, weight_y in mean_gauss_rule(4):
                v = y + node_y * self.dy / 2
                for power, strength in powers:
                    for k in range(TAIL_TERMS):
                        order = power + 2 * k
                        ends = sum(zeta(order, last + 1 + side * v / period) for side in (1, -1))
                        term = binom(-power / 2, k) * (u / period) ** (2 * k) * ends
                        total += weight_x * weight_y * strength * term / period**power
        return total * (self.dx * self.dy)

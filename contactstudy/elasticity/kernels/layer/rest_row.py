"""The layer's rest under a cell repeated along the length."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from scipy.special import binom, zeta

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.kernels.cell import gauss
from contactstudy.elasticity.kernels.layer.frf import LayerResponse
from contactstudy.elasticity.kernels.layer.rest_cell import rest_cell
from contactstudy.elasticity.kernels.layer.tables import LAST_WAVE, rest_in_space

# exp(-DECAY) is lost in rounding. Harmonics of the period decay like exp(-2 pi x / L): END periods away
# from a cell nothing varies along the length.
DECAY, END = 37.0, 6.0
# Evaluations of the response that a Fourier series may take; beyond it images are summed in space. Sums
# over waves cost so much less each.
MOST_WAVES, SUM = 5e6, 0.02
# Further away than this, in distances over which the singularity of R nearest to zero is felt, three powers
# of the distance tell all.
FAR = 100.0


def rest_row(
    response: LayerResponse,
    thickness: float,
    x: Array,
    y: Array,
    dx: float,
    dy: float,
    period: float,
) -> Array:
    """:func:`~contactstudy.elasticity.kernels.layer.rest_cell.rest_cell` repeated with ``period`` along y.

    x a column and y a row, of any sign. The rest is short-ranged, so that nothing diverges. What does
    not vary along the length is :func:`rest_strip`; what does is :func:`harmonics`.
    """
    across, along = np.abs(x).ravel(), y.ravel()
    mean = rest_strip(response, thickness, across, dx) * (dy / period)
    return mean[:, None] + harmonics(response, thickness, across, along, dx, dy, period)


def rest_strip(response: LayerResponse, thickness: float, x: Array, dx: float) -> Array:
    """The rest under a strip of width ``dx`` endless along y: an integral of one function of one distance."""
    table = rest_in_space(response)
    upper, lower = ((x + side * dx / 2) / thickness for side in (1, -1))
    return np.asarray(2 * thickness * (table.strip(upper) - table.strip(lower)))


def harmonics(
    response: LayerResponse,
    thickness: float,
    x: Array,
    y: Array,
    dx: float,
    dy: float,
    period: float,
) -> Array:
    """What of the row varies along y, shape (x, y): all but its mean over the period.

    A Fourier series where the layer is thick, and where it is thin a sum over images. x and y flat, x from
    0 on; both forms are exact.
    """
    result = np.zeros((x.size, y.size))
    near = np.flatnonzero(x - dx / 2 < END * period)
    if dy == period or not near.size:
        return result
    if dx > 2 * END * period:  # beyond that, a cell adds nothing that varies
        end = END * period
        for n in near.tolist():
            left, right = max(x[n] - dx / 2, -end), min(x[n] + dx / 2, end)
            middle = np.array([abs(left + right) / 2])
            result[n] = harmonics(response, thickness, middle, y, right - left, dy, period)[0]
        return result
    row = _Row(response, thickness, dx, dy, period)
    form = row.series if row.waves(float(x[near].max())) <= MOST_WAVES else row.images
    result[near] = form(x[near], y)
    return result


@dataclass(frozen=True)
class _Row:
    response: LayerResponse
    thickness: float
    dx: float
    dy: float
    period: float

    @property
    def _count(self) -> int:
        """Harmonics along the length that the rest holds."""
        return int(LAST_WAVE / self.thickness * self.period / (2 * np.pi))

    def _groups(self, farthest: float) -> list[tuple[int, int, float, float]]:
        """Harmonics from a first to a last, how far across they are felt, and the period across to sum with."""
        groups, first = [], 1
        while first <= self._count:
            decay = DECAY * self.period / (2 * np.pi * first)
            felt = min(farthest, decay + self.dx / 2)
            groups.append(
                (first, min(2 * first, self._count + 1), felt, felt + self.dx / 2 + decay)
            )
            first *= 2
        return groups

    def waves(self, farthest: float) -> float:
        """What :meth:`series` costs, in evaluations of the response."""
        cost = 0.0
        for first, end, felt, across in self._groups(farthest):
            waves = (end - first) * LAST_WAVE / self.thickness * across / (2 * np.pi)
            cost += waves * (1 + SUM * felt / self.dx)
        return cost

    def series(self, x: Array, y: Array) -> Array:
        """Harmonics along y, each an integral over the waves across by the trapezoidal rule.

        The integrand is analytic within the harmonic's own wave number of the real axis, so that the rule,
        which repeats the coefficients across, leaves nothing once the repeats have decayed.
        """
        total = np.zeros((x.size, y.size))
        for first, end, felt, across in self._groups(float(x.max(initial=0.0))):
            rows = np.flatnonzero(x <= felt)
            along = 2 * np.pi / self.period * np.arange(first, end)
            step = 2 * np.pi / across
            # no wave is longer than the group's first harmonic lets it be
            last = np.sqrt(max((LAST_WAVE / self.thickness) ** 2 - along[0] ** 2, 0.0))
            crossing = step * np.arange(int(last / step) + 1)
            weight = 4 * step * np.sinc(crossing * self.dx / (2 * np.pi))
            weight[0] /= 2
            wave = np.hypot(crossing[:, None], along)
            wave *= self.thickness
            spectrum = np.zeros(wave.shape)
            within = wave < LAST_WAVE
            k = wave[within]
            spectrum[within] = np.real(self.response.rest(k)) / k
            spectrum *= weight[:, None] * self.thickness
            spectrum *= np.sinc(along * self.dy / (2 * np.pi))
            fields = np.cos(np.multiply.outer(x[rows], crossing)) @ spectrum
            total[rows] += fields @ np.cos(np.multiply.outer(along, y))
        return total * (self.dx * self.dy / self.period)

    def images(self, x: Array, y: Array) -> Array:
        """The three nearest images cell by cell, further ones on Chebyshev points; less the mean."""
        cell = self.dx, self.dy
        y = np.abs(y - self.period * np.round(y / self.period))
        near = y + self.period * np.arange(-1.0, 2)[:, None]
        shape = x[:, None], near.ravel()
        total = rest_cell(self.response, self.thickness, *shape, *cell)
        total = total.reshape(x.size, 3, y.size).sum(axis=1)
        mean = rest_strip(self.response, self.thickness, x, self.dx) * (self.dy / self.period)
        total -= mean[:, None]
        return np.asarray(total + self._further(x, y))

    def _further(self, x: Array, y: Array) -> Array:
        """All images but the nearest three: smooth on the scale of the period."""
        period = self.period
        reach = max(float(x.max()), self.dx / 2)
        # singular where an image's edge is met, at least a period away
        slim = period / reach
        count = int(np.ceil(DECAY / np.arcsinh(slim))) + 2
        nodes_x = reach * chebyshev.chebpts1(count)
        nodes_y = period / 2 * chebyshev.chebpts1(24)
        felt = FAR * self.thickness / self.response.nearest_pole
        last = int(np.ceil(max(felt, 2 * (reach + self.dx / 2)) / period)) + 2
        values = self._tail(nodes_x, nodes_y, last)
        images = np.arange(2.0, last + 1)
        for block in np.array_split(images, max(1, images.size // 64)):
            ahead = np.concatenate([-block, block])
            away = (nodes_y + period * ahead[:, None]).ravel()
            cells = rest_cell(
                self.response, self.thickness, nodes_x[:, None], away, self.dx, self.dy
            )
            values += cells.reshape(count, ahead.size, nodes_y.size).sum(axis=1)
        across = _interpolation(nodes_x.size, x / reach)
        along = _interpolation(nodes_y.size, y / (period / 2))
        return np.asarray(across @ values @ along.T)

    def _tail(self, x: Array, y: Array, last: int) -> Array:
        """Images beyond the ``last``, where it is ``-r2 h^2 / r^3 + 9 r4 h^4 / r^5 - 225 r6 h^6 / r^7``."""
        second, fourth, sixth = rest_in_space(self.response).taylor
        h, period = self.thickness, self.period
        powers = (3, -second * h**2), (5, 9 * fourth * h**4), (7, -225 * sixth * h**6)
        total = np.zeros((x.size, y.size))
        for node_x, weight_x in gauss(4):
            u = np.abs(x + node_x * self.dx / 2)[:, None]
            for node_y, weight_y in gauss(4):
                v = y + node_y * self.dy / 2
                for power, strength in powers:
                    for k in range(14):
                        order = power + 2 * k
                        ends = sum(zeta(order, last + 1 + side * v / period) for side in (1, -1))
                        term = binom(-power / 2, k) * (u / period) ** (2 * k) * ends
                        total += weight_x * weight_y * strength * term / period**power
        return total * (self.dx * self.dy)


def _interpolation(count: int, points: Array) -> Array:
    """Matrix from values at first-kind Chebyshev points to values at ``points``, shape (points, count)."""
    nodes = chebyshev.chebvander(chebyshev.chebpts1(count), count - 1)
    norm = np.full(count, 2.0 / count)
    norm[0] /= 2
    return np.asarray(chebyshev.chebvander(points, count - 1) @ (nodes * norm).T)

"""Influence coefficients of a loaded cell by the waves of its load: alone, in a row, in a lattice."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.special import erfc

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.layer.response import LayerResponse, RealOrComplex, composite

Indices = NDArray[np.intp]
T = TypeVar("T")
# exp(-ROUNDING_EXPONENT) is below rounding.
ROUNDING_EXPONENT = 34.0
# Phase of a wave, in radians, that the Gauss points of one piece of k resolve.
PIECE_PHASE = 12.0
# The waves of a row decay within DECAY_PERIODS; a cell alone is one of a lattice LATTICE_RATIO times as wide as the
# grid.
DECAY_PERIODS, LATTICE_RATIO = 6.0, 4
# Distance of the rows that stand for a single one, over the width of the grid, where the period is longer.
ROW_RATIO = 16
# Smallest period of that lattice, in thicknesses over the distance of the poles from the real axis.
MIN_PERIOD = 64.0
# Windows of waves, in waves per cell: the end, and the width of the erfc by which they end; WINDOW_END widths farther it
# is below rounding. A sum over waves that end so is negligible beyond 2 / width cells: within half of NEAR_CELLS for
# long waves, and at the centre of a cell for those that are seen there. Short waves are the seen ones but the long ones.
Window = tuple[tuple[float, float], ...]
LONG_WAVES: Window = ((0.9, 0.165),)
SEEN_WAVES: Window = ((20.0, 3.5),)
SHORT_WAVES = LONG_WAVES + SEEN_WAVES
WINDOW_END, NEAR_CELLS = 5.3, 24
# Number of values that are held at once.
VALUES_AT_ONCE = 2**17
# Number of waves along an axis up to which they are summed as a series, and beyond which by a transform.
MAX_SERIES_WAVES = 1200


class WaveResponse(Protocol):
    """Fields in a layered half-space under a wave of load; wave numbers are those times the layer's thickness."""

    def __hash__(self) -> int: ...

    @property
    def decay_rate(self) -> float:
        """Rate, per wave number times thickness, at which amplitudes decay: exp(-k `decay_rate`)."""

    @property
    def materials(self) -> LayerResponse:
        """Ratio of the moduli and Poisson's ratios, which determine the singularities in k."""

    def parity(self, name: str) -> tuple[int, int]:
        """Return the parity of a field in x and y."""

    def swap_axes(self, name: str) -> "tuple[WaveResponse, str]":
        """Return the response and the field that take the place of these when the axes are exchanged."""

    def amplitudes(self, across: Array, along: Array) -> dict[str, Array]:
        """Return the fields over the load, by name, under waves (across, along).

        A field that is even along both axes or odd along both has a real amplitude, another an imaginary one.
        """

    def plane_amplitudes(self, k: RealOrComplex) -> dict[str, RealOrComplex]:
        """Return the fields over the load, by name, under waves across; those left out are zero.

        The wave numbers `k` are real or imaginary.
        """


@dataclass(frozen=True)
class WaveCoefficients:
    """Influence coefficients of a field that falls as the inverse cube of the distance, by its waves.

    A cell alone is approximated by a periodic lattice far wider than the grid and the layer's thickness.

    Parameters
    ----------
    waves
        Response to one wave.
    thickness
        Thickness of the layer; all lengths are in one unit.
    name
        Name of the field.
    """

    waves: WaveResponse
    thickness: float
    name: str

    @property
    def parity(self) -> tuple[int, int]:
        """Parity of the field in x and y."""
        return self.waves.parity(self.name)

    def swap_axes(self) -> "WaveCoefficients":
        """Return the coefficients that take the place of these when the axes are exchanged."""
        waves, name = self.waves.swap_axes(self.name)
        return WaveCoefficients(waves, self.thickness, name)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast and are whole numbers of cells.

        A lattice four times as wide as the offsets stands for it; if the layer is thick, its waves along an axis are at
        most `MAX_SERIES_WAVES`.
        """
        periods = [
            LATTICE_RATIO * (float(np.abs(offsets).max()) + step)
            for offsets, step in ((x, dx), (y, dy))
        ]
        least = min(self.least_period, MAX_SERIES_WAVES * self._shortest_wave)
        if least > min(periods):
            return self._series(x, y, dx, dy, (max(periods[0], least), max(periods[1], least)))
        cells = [
            fft.next_fast_len(round(length / step))
            for length, step in zip(periods, (dx, dy), strict=True)
        ]
        field = self._lattice(dx, dy, *cells)
        return np.asarray(field[_indices(x, dx, cells[0]), _indices(y, dy, cells[1])])

    def _series(
        self, x: Array, y: Array, dx: float, dy: float, periods: tuple[float, float]
    ) -> Array:
        """Return the response to one cell of a lattice by its Fourier series; one of x and y is a column."""
        waves, fields = [], []
        for offset, size, period, even in zip((x, y), (dx, dy), periods, self.parity, strict=True):
            q = 2 * np.pi / period * np.arange(int(period / self._shortest_wave) + 1)
            weight = 2 * size / period * np.sinc(q * size / (2 * np.pi))
            weight[0] /= 2
            phase = np.multiply.outer(offset.ravel(), q)
            fields.append((np.cos(phase) if even > 0 else -np.sin(phase)) * weight)
            waves.append(q * self.thickness)
        amplitude = self.waves.amplitudes(waves[0][:, None], waves[1])[self.name]
        odd = self.parity[0] * self.parity[1] < 0
        part = amplitude.imag if odd else self.parity[0] * amplitude.real
        response = fields[0] @ part @ fields[1].T
        return np.asarray(response if np.ndim(x) == 2 else response.T)

    @property
    def least_period(self) -> float:
        """Least period of a lattice that stands for a single cell, however small the offsets are."""
        return MIN_PERIOD * self.thickness / self.waves.materials.pole_distance_from_real_axis

    @property
    def _shortest_wave(self) -> float:
        """Wavelength of the shortest wave that is not negligible."""
        return 2 * np.pi * self.waves.decay_rate * self.thickness / ROUNDING_EXPONENT

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""
        mean = self.strip(x.ravel(), dx) * (dy / period)
        return np.asarray(mean[:, None] + self.varying(x, y, dx, dy, period))

    def strip(self, x: Array, dx: float) -> Array:
        """Return the response to a strip of width `dx`, infinite along y, at offsets `x`."""
        distances, which = np.unique(np.abs(x), return_inverse=True)
        return np.asarray(np.where(x < 0, self.parity[0], 1) * self._line(distances, dx)[which])

    def varying(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the part of :meth:`row` that varies along y, whose mean is zero."""
        along = round(period / dy)
        if along == 1:
            return np.zeros((x.size, y.size))
        farthest = float(np.abs(x).max())
        # beside long periods the field itself has fallen off before its waves have
        reach = farthest + min(DECAY_PERIODS * period, max(ROW_RATIO * farthest, self.least_period))
        across = fft.next_fast_len(int(np.ceil(reach / dx)) + 1)
        chosen = self._lattice(dx, dy, across, along)[_indices(x.ravel(), dx, across)]
        chosen = chosen - chosen.mean(axis=1, keepdims=True)
        return np.asarray(chosen[:, _indices(y.ravel(), dy, along)])

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        cells = round(width / dx), round(period / dy)
        field = self._lattice(dx, dy, *cells)
        return np.asarray(
            field[np.ix_(_indices(x.ravel(), dx, cells[0]), _indices(y.ravel(), dy, cells[1]))]
        )

    def _lattice(self, dx: float, dy: float, across: int, along: int) -> Array:
        """Return the response (across, along) to a cell of a lattice at all its points, summed over its waves."""
        return _lattice(self.waves, self.thickness, dx, dy, across, along)[self.name]

    def _line(self, x: Array, dx: float) -> Array:
        """Return the response to a strip, infinite along y, at distances `x` at least 0, in order."""
        lower, upper = ((x + side * dx / 2) / self.thickness for side in (-1, 1))
        if self.parity[0] < 0:
            return self._between(np.abs(lower), upper)  # what lies on both sides cancels
        return self._between(np.maximum(lower, 0), upper) + self._between(
            np.zeros(x.size), np.maximum(-lower, 0)
        )

    def _between(self, start: Array, end: Array) -> Array:
        """Return the response to strips from `start` to `end`, at least 0; all in thicknesses."""
        # waves that decay along x oscillate with depth: nearer than the depth they are too many
        far = ROUNDING_EXPONENT / self.waves.materials.pole_distance_from_real_axis
        far = max(far, self.waves.decay_rate)
        result = np.zeros(start.size)
        for integral, lower, upper in (
            (self._near, np.minimum(start, far), np.minimum(end, far)),
            (self._far, np.maximum(start, far), np.maximum(end, far)),
        ):
            octave = np.ceil(np.log2(np.maximum(lower if lower.min() >= far else upper, 1)))
            for number in np.unique(octave[upper > lower]).tolist():
                chosen = (octave == number) & (upper > lower)
                result[chosen] += integral(lower[chosen], upper[chosen])
        return result

    def _near(self, start: Array, end: Array) -> Array:
        """Return the response to near strips, by quadrature over real waves."""
        # by octaves, so that grids share the waves
        octave = np.ceil(np.log2(max(float(end.max()), self.waves.decay_rate)))
        longest = min(0.5, PIECE_PHASE / 2.0 ** float(octave))
        ends = [0.0, min(self.waves.materials.pole_distance_from_zero / 4, longest)]
        while ends[-1] < ROUNDING_EXPONENT / self.waves.decay_rate:
            ends.append(ends[-1] + min(ends[-1], longest))
        k, fields = _plane_waves(self.waves, tuple(ends), 1.0)
        if self.name not in fields:
            return np.zeros(start.size)
        waves = fields[self.name]
        phase, width = np.multiply.outer((start + end) / 2, k), end - start
        even = self.parity[0] > 0
        turn = np.cos(phase) if even else -np.sin(phase)
        turn *= width[:, None] * np.sinc(np.multiply.outer(width, k / (2 * np.pi)))
        return np.asarray(turn @ (waves.real if even else waves.imag))

    def _far(self, start: Array, end: Array) -> Array:
        """Return the response to far strips, by quadrature over waves that decay."""
        width = (end - start)[:, None]
        last = min(
            self.waves.materials.pole_distance_from_real_axis,
            ROUNDING_EXPONENT / float(start.min()),
        )
        first = 1e-3 * min(
            self.waves.materials.pole_distance_from_zero, last, 1 / float(width.max())
        )
        count = int(np.ceil(np.log2(last / first)))
        ends = 0.0, *np.geomspace(first, last, count + 1).tolist()
        tau, fields = _plane_waves(self.waves, ends, 1j)
        if self.name not in fields:
            return np.zeros(start.size)
        decay = np.exp(-np.multiply.outer(start, tau)) * np.expm1(-tau * width)
        return np.asarray(decay @ (fields[self.name].imag / tau))


@lru_cache(maxsize=128)
def _plane_waves(
    waves: WaveResponse, ends: tuple[float, ...], direction: complex
) -> tuple[Array, dict[str, RealOrComplex]]:
    """Return Gauss points between `ends`, and each field over pi under waves that are these times `direction`.

    The fields are multiplied by the weights of the points.
    """
    points, weight = composite(np.array(ends))
    fields = waves.plane_amplitudes(direction * points)
    return points, {name: field * weight / np.pi for name, field in fields.items()}


@lru_cache(maxsize=4)
def _lattice(
    waves: WaveResponse, thickness: float, dx: float, dy: float, across: int, along: int
) -> dict[str, Array]:
    """Return the response (across, along) to one cell of a lattice at all its points, for each field.

    Waves that are long along both axes are summed on the lattice. Others are summed on small ones about the cell (Ewald
    1921): those that are short along the longer side of a cell alone, then those that are short along the shorter side.
    Left out are waves whose sum is negligible at half a cell from its edges.
    """
    steps, ratio = (dx, dy), max(dx, dy) / min(dx, dy)

    def on_axes(shorter_side: T, longer_side: T) -> tuple[T, T]:
        return (shorter_side, longer_side) if dx < dy else (longer_side, shorter_side)

    fields = _summed(waves, thickness, steps, (across, along), (LONG_WAVES, LONG_WAVES))
    for near, windows in (
        (on_axes(NEAR_CELLS * ratio, NEAR_CELLS), on_axes(LONG_WAVES, SHORT_WAVES)),
        (on_axes(NEAR_CELLS, NEAR_CELLS / ratio + 3), on_axes(SHORT_WAVES, SEEN_WAVES)),
    ):
        cells = min(across, int(near[0])), min(along, int(near[1]))
        short = _summed(waves, thickness, steps, cells, windows)
        places = np.ix_(*(np.round(fft.fftfreq(n) * n).astype(np.intp) for n in cells))
        for name, field in short.items():
            fields[name][places] += field
    return fields


def _summed(
    waves: WaveResponse,
    thickness: float,
    steps: tuple[float, float],
    cells: tuple[int, int],
    windows: tuple[Window, Window],
) -> dict[str, Array]:
    """Return the response (x, y) to one cell of a lattice of `cells`, for each field, by the waves in `windows`."""
    last = ROUNDING_EXPONENT / (waves.decay_rate * thickness)
    q, weights = [], []  # waves per cell, of both axes at least 0: fields have a parity
    for step, count, window in zip(steps, cells, windows, strict=True):
        shortest = min(last * step / (2 * np.pi), window[-1][0] + WINDOW_END * window[-1][1])
        q.append(np.arange(int(shortest * count) + 1) / count)
        below = [erfc((q[-1] - end) / width) / 2 for end, width in window]
        weights.append(np.sinc(q[-1]) * (below[-1] - sum(below[:-1])))
        weights[-1][0] /= 2
    kx, ky = (2 * np.pi * waves_of / step for waves_of, step in zip(q, steps, strict=True))
    summed: dict[str, Array] = {}
    rows = min(cells[0], max(1, VALUES_AT_ONCE // ky.size))
    for start in range(0, kx.size, rows):
        chosen = slice(start, start + rows)
        columns = int(np.searchsorted(ky, np.sqrt(max(last**2 - kx[start] ** 2, 0.0)), "right"))
        weight = np.multiply.outer(weights[0][chosen], weights[1][:columns])
        amplitudes = waves.amplitudes(kx[chosen, None] * thickness, ky[:columns] * thickness)
        where = np.arange(start, start + weight.shape[0]) % cells[0]
        for name, amplitude in amplitudes.items():
            folded = np.zeros((where.size, -(-columns // cells[1]) * cells[1]), amplitude.dtype)
            np.multiply(amplitude, weight, out=folded[:, :columns])
            total = summed.setdefault(name, np.zeros(cells, amplitude.dtype))
            total[where] += folded.reshape(where.size, -1, cells[1]).sum(axis=1)
    fields = {}
    for name, total in summed.items():
        for axis, parity in enumerate(waves.parity(name)):
            total = total + parity * np.roll(np.flip(total, axis), 1, axis)
        fields[name] = fft.irfft2(total[:, : cells[1] // 2 + 1], cells)
    return fields


def _indices(offsets: Array, step: float, cells: int) -> Indices:
    """Return the indices of `offsets` on a periodic axis of `cells`."""
    return np.asarray(np.round(np.asarray(offsets) / step).astype(np.intp) % cells)

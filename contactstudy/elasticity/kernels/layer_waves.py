"""Influence coefficients of a cell on a layered half-space by the waves of its load: alone, in a row, in a lattice."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.special import erfc

from contactstudy.domain.grid import Array
from contactstudy.elasticity.kernels.layer_response import (
    LayerResponse,
    LayerStress,
    RealOrComplex,
    WaveResponse,
    cell_alone,
    composite,
)
from contactstudy.elasticity.kernels.stress import (
    BOUSSINESQ,
    CERRUTI_ACROSS,
    CERRUTI_ALONG,
    SURFACE,
    SWAPPED,
    CellKernel,
)

Indices = NDArray[np.intp]
T = TypeVar("T")
# exp(-ROUNDING_EXPONENT) is below rounding.
ROUNDING_EXPONENT = 34.0
# Phase of a wave, in radians, that the Gauss points of one piece of k resolve.
PIECE_PHASE = 12.0
# The first wave along a row decays within DECAY_PERIODS, later ones within shorter distances: those from 1, BAND_RATIO,
# BAND_RATIO^2 ... on are summed on lattices of their own.
DECAY_PERIODS, BAND_RATIO = 6.0, 4
# Window of waves: the end and the width, in waves per cell, of the erfc by which waves fade out. Of two such pairs the
# window holds the waves of the second without those of the first.
Window = tuple[tuple[float, float], ...]
# The end effects of a window are negligible beyond 2 / width cells: those of the long waves within half of NEAR_CELLS,
# those of the seen waves at the centre of a cell, half a cell from its edges.
NEAR_CELLS = 24
# The long waves, all waves that are seen at the centres of cells, and the latter without the former.
LONG_WAVES: Window = ((0.9, 0.165),)
SEEN_WAVES: Window = ((20.0, 3.5),)
SHORT_WAVES = LONG_WAVES + SEEN_WAVES
# Number of widths beyond its end at which the erfc is below rounding.
WINDOW_END = 5.3
# Number of values that are held at once.
VALUES_AT_ONCE = 2**17


@dataclass(frozen=True)
class WaveCoefficients:
    """Influence coefficients of a field that falls as the inverse cube of the distance, by its waves.

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
        """Return the response to one cell; x and y broadcast, and form a grid where there are many."""
        h = self.thickness
        return cell_alone(self.waves, self.name, x / h, y / h, dx / h, dy / h)

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
        rows = round(farthest / dx) + 1
        first_waves = [1]
        while 2 * BAND_RATIO * first_waves[-1] < along:
            first_waves.append(BAND_RATIO * first_waves[-1])
        lengths = [farthest + DECAY_PERIODS * period / first for first in first_waves]
        widths = [fft.next_fast_len(int(np.ceil(length / dx)) + 1) for length in lengths]
        # what is summed on small lattices has fallen off there
        least = min(widths[0], rows + int(NEAR_CELLS * max(1, dy / dx)))
        bands = tuple((first, max(width, least)) for first, width in zip(first_waves, widths, strict=True))
        field = _lattice(self.waves, self.thickness, dx, dy, bands, along, rows)[self.name]
        chosen = field[_indices(np.abs(x.ravel()), dx, rows)]
        chosen = np.where(x < 0, self.parity[0], 1) * (chosen - chosen.mean(axis=1, keepdims=True))
        return np.asarray(chosen[:, _indices(y.ravel(), dy, along)])

    def lattice(self, x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        cells = round(width / dx), round(period / dy)
        bands = ((0, cells[0]),)
        field = _lattice(self.waves, self.thickness, dx, dy, bands, cells[1], cells[0])[self.name]
        at_x, at_y = _indices(x.ravel(), dx, cells[0]), _indices(y.ravel(), dy, cells[1])
        return np.asarray(field[np.ix_(at_x, at_y)])

    def _line(self, x: Array, dx: float) -> Array:
        """Return the response to a strip, infinite along y, at distances `x` at least 0, in order."""
        lower, upper = ((x + side * dx / 2) / self.thickness for side in (-1, 1))
        if self.parity[0] < 0:
            return self._between(np.abs(lower), upper)  # what lies on both sides cancels
        return self._between(np.maximum(lower, 0), upper) + self._between(np.zeros(x.size), np.maximum(-lower, 0))

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
        means = np.cos(phase) if even else -np.sin(phase)
        means *= width[:, None] * np.sinc(np.multiply.outer(width, k / (2 * np.pi)))
        return np.asarray(means @ (waves.real if even else waves.imag))

    def _far(self, start: Array, end: Array) -> Array:
        """Return the response to far strips, by quadrature over waves that decay."""
        width = (end - start)[:, None]
        last = min(self.waves.materials.pole_distance_from_real_axis, ROUNDING_EXPONENT / float(start.min()))
        first = 1e-3 * min(self.waves.materials.pole_distance_from_zero, last, 1 / float(width.max()))
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
    weight /= np.pi
    return points, {
        name: sum(parts.values()) * weight
        for name, parts in waves.harmonics(direction * points).items()
        if waves.parity(name)[1] > 0
    }


@lru_cache(maxsize=4)
def _lattice(
    waves: WaveResponse,
    thickness: float,
    dx: float,
    dy: float,
    bands: tuple[tuple[int, int], ...],
    along: int,
    rows: int,
) -> dict[str, Array]:
    """Return the response (rows, along) to one cell of a lattice at its first points, for each field.

    `bands` have the first wave along y, and the number of cells across of the lattice on which the waves from there to
    the next band are summed.

    Waves that are long along both axes are summed on the lattice. Others are summed on small ones about the cell (Ewald
    1921): those that are short along the longer side of a cell alone, then those that are short along the shorter side.
    Left out are waves whose sum is negligible at half a cell from its edges.
    """
    steps, ratio = (dx, dy), max(dx, dy) / min(dx, dy)

    def on_axes(shorter_side: T, longer_side: T) -> tuple[T, T]:
        return (shorter_side, longer_side) if dx < dy else (longer_side, shorter_side)

    fields: dict[str, Array] = {}
    ends = *(first for first, _ in bands[1:]), None
    for (first, across), end in zip(bands, ends, strict=True):
        windows = LONG_WAVES, LONG_WAVES
        part = _summed(waves, thickness, steps, (across, along), windows, slice(first, end), rows)
        fields = {name: fields.get(name, 0.0) + field for name, field in part.items()}
    for near, windows in (
        (on_axes(NEAR_CELLS * ratio, NEAR_CELLS), on_axes(LONG_WAVES, SHORT_WAVES)),
        (on_axes(NEAR_CELLS, NEAR_CELLS / ratio + 3), on_axes(SHORT_WAVES, SEEN_WAVES)),
    ):
        cells = min(bands[0][1], int(near[0])), min(along, int(near[1]))
        short = _summed(waves, thickness, steps, cells, windows)
        at_x, at_y = (np.round(fft.fftfreq(n) * n).astype(np.intp) for n in cells)
        at_x %= bands[0][1]
        seen = np.flatnonzero(at_x < rows)
        places = np.ix_(at_x[seen], at_y)
        for name, field in short.items():
            fields[name][places] += field[seen]
    return fields


def _summed(
    waves: WaveResponse,
    thickness: float,
    steps: tuple[float, float],
    cells: tuple[int, int],
    windows: tuple[Window, Window],
    band: slice = slice(None),
    rows: int | None = None,
) -> dict[str, Array]:
    """Return the response (x, y) to one cell of a lattice of `cells`, for each field, by the waves in `windows`.

    Only waves along y in the `band` are taken; values are those at the first `rows` of x.
    """
    last = ROUNDING_EXPONENT / (waves.decay_rate * thickness)
    q, weights = [], []  # waves per cell, of both axes at least 0: fields have a parity
    for step, count, window, chosen in zip(steps, cells, windows, (slice(None), band), strict=True):
        shortest = min(last * step / (2 * np.pi), window[-1][0] + WINDOW_END * window[-1][1])
        q.append(np.arange(int(shortest * count) + 1)[chosen] / count)
        below = [erfc((q[-1] - end) / width) / 2 for end, width in window]
        weights.append(np.sinc(q[-1]) * (below[-1] - sum(below[:-1])))
        weights[-1][q[-1] == 0] /= 2
    kx, ky = (2 * np.pi * waves_of / step for waves_of, step in zip(q, steps, strict=True))
    first, points = band.start or 0, min(cells[1], 2 * (band.stop or cells[1]))
    summed: dict[str, Array] = {}
    at_once = min(cells[0], max(1, VALUES_AT_ONCE // max(ky.size, 1)))
    for start in range(0, kx.size, at_once):
        chosen = slice(start, start + at_once)
        columns = int(np.searchsorted(ky, np.sqrt(max(last**2 - kx[start] ** 2, 0.0)), "right"))
        weight = np.multiply.outer(weights[0][chosen], weights[1][:columns])
        fields_of_waves = amplitudes(waves, kx[chosen, None] * thickness, ky[:columns] * thickness)
        where = np.arange(start, start + weight.shape[0]) % cells[0]
        for name, amplitude in fields_of_waves.items():
            folded = np.zeros((where.size, -(-(first + columns) // points) * points), amplitude.dtype)
            np.multiply(amplitude, weight, out=folded[:, first : first + columns])
            total = summed.setdefault(name, np.zeros((cells[0], points), amplitude.dtype))
            total[where] += folded.reshape(where.size, -1, points).sum(axis=1)
    fields = {}
    for name, total in summed.items():
        even_x, even_y = waves.parity(name)
        half = (total + even_y * np.roll(np.flip(total, 1), 1, 1))[:, : points // 2 + 1]
        half = half + even_x * np.roll(np.flip(half, 0), 1, 0)
        fields[name] = fft.irfft(fft.ifft(half, axis=0)[:rows], cells[1], axis=1)
    return fields


def amplitudes(waves: WaveResponse, across: Array, along: Array) -> dict[str, Array]:
    """Return the fields over the load, by name, under waves (across, along)."""
    size = np.hypot(across, along)
    harmonics = waves.harmonics(size)
    powers: list[Array | NDArray[np.complex128]] = [np.ones(1)]
    if any(m > 0 for parts in harmonics.values() for m in parts):
        wave = across + 1j * along
        direction = np.divide(wave, size, out=np.ones_like(wave), where=size > 0)
        powers += [direction, direction * direction, direction * direction * direction]
    fields: dict[str, Array] = {}
    for name, parts in harmonics.items():
        odd = waves.parity(name)[1] < 0
        turned = (part * (powers[m].imag if odd else powers[m].real) for m, part in parts.items())
        fields[name] = np.asarray(sum(turned))
    return fields


def _indices(offsets: Array, step: float, cells: int) -> Indices:
    """Return the indices of `offsets` on a periodic axis of `cells`."""
    return np.asarray(np.round(np.asarray(offsets) / step).astype(np.intp) % cells)


@dataclass(frozen=True)
class DisplacementWaves:
    """Displacement of a layered half-space under a wave of load, less that of a homogeneous one of the layer's material.

    Fields "xx", "xy" and "yy" are the displacements along the surface under traction, and "z" is that along the normal
    under pressure, over ``(1 - nu1^2) / (pi E1)``; "x" and "y" are the normal displacement under traction along either
    axis, over ``1 / (4 pi G1)``. Lengths are over the thickness of the layer.

    Parameters
    ----------
    materials
        Materials and depths of their interfaces.
    load
        "pressure", or "traction" along the surface.
    has_long_waves
        Whether the response holds ``contrast exp(-2 k)``, with k = wave number times thickness, whose value for long
        waves is that of the substrate alone. The remainder of waves across is regular.
    """

    #: Rate, per wave number times thickness, at which amplitudes decay: exp(-2 k).
    decay_rate: ClassVar[float] = 2.0

    materials: LayerResponse
    load: str
    has_long_waves: bool = True

    def parity(self, name: str) -> tuple[int, int]:
        """Return the parity of a field in x and y."""
        return (1, 1) if name in ("yy", "z") else SURFACE[name].parity

    def swap_axes(self, name: str) -> tuple["DisplacementWaves", str]:
        """Return the response and the field that take the place of these when the axes are exchanged."""
        return self, SWAPPED.get(name, name)

    def harmonics(self, k: RealOrComplex) -> dict[str, dict[int, RealOrComplex]]:
        """Return the fields by name and number of turns, see :class:`WaveResponse`; none for the mean."""
        weight = np.divide(2 * np.pi, k, out=np.zeros_like(k), where=k != 0)
        if self.load == "pressure":
            return {"z": {0: weight * self._responses(k, slice(1))[0]}}
        along, coupling, across = (weight * part for part in self._responses(k, slice(1, 4)))
        mean, turning = (along + across) / 2, (along - across) / 2
        return {
            "xx": {0: mean, 2: turning},
            "yy": {0: mean, 2: -turning},
            "xy": {2: turning},
            "x": {1: -1j * coupling},
            "y": {1: -1j * coupling},
        }

    def _responses(self, k: RealOrComplex, which: slice) -> RealOrComplex:
        """Return responses, less those of a half-space, of `which` of the four of :meth:`LayerResponse.compliances`."""
        remainders = self.materials.remainders(k, which)
        if self.has_long_waves:
            known = np.array(self.materials.contrasts)[which]
            remainders = remainders + np.multiply.outer(known, np.exp(-2 * k))
        return remainders


# Components of stress by the load on the surface: pressure, shear across, shear along.
FAMILIES: Mapping[str, Mapping[str, CellKernel]] = {
    "pressure": BOUSSINESQ,
    "across": CERRUTI_ACROSS,
    "along": CERRUTI_ALONG,
}
SWAPPED_LOADS = {"pressure": "pressure", "across": "along", "along": "across"}


@dataclass(frozen=True)
class StressWaves(LayerStress):
    """Remainder of the stress in a layered body under one wave of a load on its surface.

    Its part of a homogeneous body is subtracted, as in
    :meth:`~contactstudy.elasticity.kernels.layer_response.LayerStress.remainder`. In names of stresses l is the
    direction of the wave, t that of its crests.

    Parameters
    ----------
    materials, depth
        As of :class:`~contactstudy.elasticity.kernels.layer_response.LayerStress`.
    load
        Load on the surface, of ``FAMILIES``.
    """

    load: str

    def parity(self, name: str) -> tuple[int, int]:
        """Return the parity of a component of stress in x and y."""
        return FAMILIES[self.load][name].parity

    def swap_axes(self, name: str) -> tuple["StressWaves", str]:
        """Return the response and the component that take the place of these when the axes are exchanged."""
        return replace(self, load=SWAPPED_LOADS[self.load]), BOUSSINESQ[name].swapped

    def harmonics(self, k: RealOrComplex) -> dict[str, dict[int, RealOrComplex]]:
        """Return the components of the remainder by name and number of turns, see :class:`WaveResponse`."""
        if self.load == "along":
            return {
                BOUSSINESQ[name].swapped: {
                    m: -part if m == 3 or (m == 2 and name != "yz") else part for m, part in parts.items()
                }
                for name, parts in replace(self, load="across").harmonics(k).items()
            }
        normal, shear, s_ll = self.remainder(k)[0 if self.load == "pressure" else 1]
        s_tt = self.poisson_ratio * (s_ll + normal)
        if self.load == "pressure":
            mean, turning = (s_ll + s_tt) / 2, (s_ll - s_tt) / 2
            return {
                "xx": {0: mean, 2: turning},
                "yy": {0: mean, 2: -turning},
                "zz": {0: normal},
                "yz": {1: -1j * shear},
                "xz": {1: -1j * shear},
                "xy": {2: turning},
            }
        # the shear along the wave is the cosine, that along its crests minus the sine of the angle
        down, around = self.antiplane(k)
        turning = (s_ll - s_tt) / 4 - around / 2
        return {
            "xx": {1: 1j * (s_ll - turning), 3: 1j * turning},
            "yy": {1: 1j * (s_tt + turning), 3: -1j * turning},
            "zz": {1: 1j * normal},
            "yz": {2: (shear - down) / 2},
            "xz": {0: (shear + down) / 2, 2: (shear - down) / 2},
            "xy": {1: 1j * (turning + around), 3: 1j * turning},
        }

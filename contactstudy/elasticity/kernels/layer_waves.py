"""Influence coefficients of a cell on a layered half-space by the waves of its load: alone, in a row, in a lattice.

:class:`WaveCoefficients` has the coefficients of one field of a
:class:`~contactstudy.elasticity.kernels.layer_response.WaveResponse`, which is what layers add to a body without them.
A cell alone integrates the field of a point load, and a strip, which is the mean of a row, that of a line load; both
are tabled over the distance. The rest of a row, and a lattice, are sums over their waves. Lengths are in units of the
depth of the deepest interface, the thickness h, except for those that :class:`WaveCoefficients` takes and returns; wave
numbers k are in units of 1 / h.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Self, TypeVar

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from numpy.typing import NDArray
from scipy import fft
from scipy.special import erfc, gamma, j0, j1, jv, k0, k1, rgamma

from contactstudy.domain.grid import Array
from contactstudy.elasticity.kernels.displacement import mean_gauss_rule
from contactstudy.elasticity.kernels.layer_response import RealOrComplex, WaveResponse, circle, taylor_coefficients

# Any kind of value, the same for both sides of a cell.
T = TypeVar("T")

# Number of points of the polynomial on a piece of distances. Pieces end at r/2 times 0, 1, 2, 4, ..., if waves decay as
# exp(-k r). The singularities of fields, at i r and, of far fields, at zero, are outside a Bernstein ellipse of rho =
# 5.8 about each piece, which leaves an error of 5.8^-22 ~ 1e-17.
CHEBYSHEV_POINTS = 22
# Matrix from values at these points, the nodes, to Chebyshev coefficients: the polynomials are orthogonal over them.
FROM_NODES = 2 / CHEBYSHEV_POINTS * chebyshev.chebvander(chebyshev.chebpts1(CHEBYSHEV_POINTS), CHEBYSHEV_POINTS - 1).T
FROM_NODES[0] /= 2
# exp(-x) is neglected beyond this x in integrals over waves: it is 6e-19.
NEGLIGIBLE_EXPONENT = 42.0
# Number of Gauss points on each piece of k, which is at most two oscillations long: their error is within rounding.
GAUSS_POINTS = 18
# Terms of the Taylor series of a spectrum about k = 0; how many of them the far field of a point load has in closed
# form; and the fraction of the circle of convergence within which the other terms are the rest of the spectrum: a
# difference would cancel there. The first term left out is 0.02^6 of the first one taken.
SERIES_TERMS, LONG_TERMS, SERIES_END = 9, 3, 0.02


class FieldOverDistance(ABC):
    """Fields of a concentrated load on a layered body over the distance from it: polynomials on pieces of the distance.

    A piece is made when it is first used. Columns are the functions of distance that are tabled together.
    """

    def __init__(self, waves: WaveResponse) -> None:
        self.waves = waves
        self._pieces: dict[int, Array] = {}

    @abstractmethod
    def _values(self, distances: Array) -> Array:
        """Return all columns (columns, distances) at `distances` in order, by quadrature over k."""

    def _at_nodes(self, number: int) -> Array:
        """Return all columns (columns, CHEBYSHEV_POINTS) at the nodes of a piece."""
        if number not in self._pieces:
            self._pieces[number] = self._values(piece_nodes(self.waves.decay_rate, number))
        return self._pieces[number]

    def _is_near(self, distance: float) -> bool:
        """Return whether a field at a `distance` is integrated over real k; beyond, fewer imaginary ones serve."""
        far = NEGLIGIBLE_EXPONENT / self.waves.materials.pole_distance_from_real_axis
        return distance < max(far, self.waves.decay_rate)

    def _real_waves(self, distance: float) -> tuple[Array, Array]:
        """Return Gauss points and weights (k,) for integrals over real k of what oscillates with ``k distance``."""
        longest = min(1 / self.waves.decay_rate, 4 * np.pi / distance)
        ends = [0.0, min(self.waves.materials.pole_distance_from_zero, longest)]
        while ends[-1] < NEGLIGIBLE_EXPONENT / self.waves.decay_rate:
            ends.append(ends[-1] + min(ends[-1], longest))
        return composite(np.array(ends))

    def _decaying_waves(self, distance: float) -> tuple[Array, Array]:
        """Return Gauss points and weights (tau,) for integrals over k = i tau of what decays as exp(-tau distance)."""
        materials = self.waves.materials
        end = min(materials.pole_distance_from_real_axis, NEGLIGIBLE_EXPONENT / distance)
        # the first piece, on which the integrand is smooth: factors from 5e-4 to 0.1 change nothing
        start = 1e-3 * min(materials.pole_distance_from_zero, 1 / distance)
        count = int(np.ceil(np.log2(end / start)))
        return composite(np.concatenate([[0.0], np.geomspace(start, end, count + 1)]))


class FieldOfLine(FieldOverDistance):
    """Fields of a unit load per length on a line along y, ``1 / pi int_0^inf Re(F(k) exp(i k x)) dk`` at x > 0.

    F is the sum of the parts of a field in :meth:`WaveResponse.short_harmonics`: what has a closed form is left out.
    """

    def __init__(self, waves: WaveResponse) -> None:
        super().__init__(waves)
        # fields that are odd along y are zero
        self._names = [name for name in waves.harmonics(np.ones(1)) if waves.parity(name)[1] > 0]

    def _spectra(self, k: RealOrComplex) -> RealOrComplex:
        """Return F of all columns (fields, k)."""
        harmonics = self.waves.short_harmonics(k)
        return np.stack([sum(harmonics[name].values()) for name in self._names])

    def at(self, name: str, x: float) -> float:
        """Return the field `name`, even along y, at a distance `x`."""
        return float(self._values(np.array([x]))[self._names.index(name), 0])

    def at_nodes(self, name: str, pieces: int) -> Array:
        """Return the field `name` (nodes,) at the nodes of the first `pieces`, as :func:`over_cells` has them."""
        if name not in self._names:
            return np.zeros(pieces * CHEBYSHEV_POINTS)
        return np.concatenate([self._at_nodes(number)[self._names.index(name)] for number in range(pieces)])

    def _values(self, distances: Array) -> Array:
        """Return all columns (fields, distances) at `distances` in order, by quadrature over k."""
        if self._is_near(float(distances[0])):
            k, weight = self._real_waves(float(distances[-1]))
            spectra = self._spectra(k) * weight
            return np.asarray(np.real(spectra @ np.exp(1j * np.multiply.outer(k, distances))) / np.pi)
        tau, weight = self._decaying_waves(float(distances[0]))
        spectra = self._spectra(1j * tau) * weight
        return np.asarray(-np.imag(spectra) @ np.exp(-np.multiply.outer(tau, distances)) / np.pi)


class FieldOfPoint(FieldOverDistance):
    """Fields of a unit point load.

    A part F of :meth:`WaveResponse.harmonics` with m turns is ``i^m / (2 pi) int F(k) J_m(k s) k dk`` times cos or sin
    of m times the angle from x, at a distance s: a Hankel transform.
    """

    def __init__(self, waves: WaveResponse) -> None:
        super().__init__(waves)
        self._radius = min(0.5 * waves.materials.pole_distance_from_zero, 1 / waves.decay_rate)
        self._parts = [(name, m) for name, parts in waves.harmonics(np.ones(1)).items() for m in parts]
        self._series = taylor_coefficients(self._spectra(circle(self._radius)), self._radius)[:, :SERIES_TERMS]

    def _spectra(self, k: RealOrComplex) -> RealOrComplex:
        """Return ``i^m F(k) k`` of all parts (parts, k), which is real for real `k`."""
        harmonics = self.waves.harmonics(k)
        return np.stack([harmonics[name][m] * (k * 1j**m) for name, m in self._parts])

    def __call__(self, name: str, x: Array, y: Array) -> Array:
        """Return the field `name` at offsets `x` and `y`, which broadcast, but not at the load itself."""
        place = x + 1j * y
        s = np.abs(place)
        direction = place / s
        chosen = [at for at, (field, _) in enumerate(self._parts) if field == name]
        total = np.zeros(s.shape)
        for at, values in zip(chosen, self._interpolated(chosen, s), strict=True):
            turned = direction ** self._parts[at][1]
            total += values * (turned.real if self.waves.parity(name)[1] > 0 else turned.imag)
        return total

    def _interpolated(self, columns: list[int], distances: Array) -> Array:
        """Return the chosen `columns` (columns, ...) at `distances` (...) above 0."""
        scaled = 2 * distances / self.waves.decay_rate
        # frexp: scaled in [2^(e-1), 2^e)
        piece = np.maximum(np.frexp(scaled)[1], 0)
        local = np.where(piece == 0, 2 * scaled, scaled / np.exp2(piece - 2.0)) - np.where(piece == 0, 1, 3)
        values = np.empty((len(columns), *distances.shape))
        for number in np.unique(piece).tolist():
            on_piece = piece == number
            coefficients = FROM_NODES @ self._at_nodes(number)[columns].T
            values[:, on_piece] = chebyshev.chebval(local[on_piece], coefficients)
        return values

    def _values(self, distances: Array) -> Array:
        """Return all columns (parts, distances) at `distances` in order, by quadrature over k."""
        s, turns = distances, np.array([m for _, m in self._parts])
        result = np.empty((turns.size, s.size))
        if self._is_near(float(s[0])):
            k, weight = self._real_waves(float(s[-1]))
            spectra, waves = np.real(self._spectra(k)) * weight, np.multiply.outer(k, s)
            for m, bessel in enumerate(_bessel_j(turns.max(), waves)):
                result[turns == m] = spectra[turns == m] @ bessel
            return result / (2 * np.pi)
        # along the imaginary axis, where J_m decays as K_m; the neglected part is below rounding
        tau, weight = self._decaying_waves(float(s[0]))
        known, unknown = np.split(self._series, [LONG_TERMS], axis=1)
        rest = self._spectra(1j * tau) - polynomial.polyval(1j * tau, known.T)
        short = tau < SERIES_END * self._radius
        rest[:, short] = polynomial.polyval(1j * tau[short], unknown.T) * (1j * tau[short]) ** LONG_TERMS
        powers = np.arange(LONG_TERMS)
        for m, bessel in enumerate(_bessel_k(turns.max(), np.multiply.outer(tau, s))):
            # int k^p J_m(k s) dk
            moments = 2.0**powers * gamma((1 + m + powers) / 2) * rgamma((1 + m - powers) / 2)
            outer = known[turns == m] @ (moments[:, None] / s ** (powers[:, None] + 1))
            decaying = np.real((rest * weight)[turns == m] * (-1j) ** m) @ bessel
            result[turns == m] = outer + 2 / np.pi * decaying
        return result / (2 * np.pi)


@lru_cache(maxsize=256)
def field_of_point(waves: WaveResponse) -> FieldOfPoint:
    """Return the fields of a point load by `waves`, kept for the responses of stress at some hundred depths."""
    return FieldOfPoint(waves)


@lru_cache(maxsize=256)
def field_of_line(waves: WaveResponse) -> FieldOfLine:
    """Return the fields of a line load by `waves`, kept as those of :func:`field_of_point`."""
    return FieldOfLine(waves)


def composite(ends: Array) -> tuple[Array, Array]:
    """Return Gauss points and weights for an integral over pieces between `ends`, `GAUSS_POINTS` on each."""
    nodes, weights = np.array(mean_gauss_rule(GAUSS_POINTS)).T
    middle, width = (ends[1:] + ends[:-1]) / 2, np.diff(ends)
    points = middle[:, None] + width[:, None] / 2 * nodes
    return points.ravel(), (width[:, None] * weights).ravel()


def piece_ends(decay_rate: float, number: int) -> tuple[float, float]:
    """Return the ends of the piece of distances with this `number` from 0 on, for waves with this `decay_rate`."""
    unit = decay_rate / 2
    return (0.0, unit) if number == 0 else (unit * 2.0 ** (number - 1), unit * 2.0**number)


def piece_nodes(decay_rate: float, number: int) -> Array:
    """Return the distances (CHEBYSHEV_POINTS,) of the nodes of a piece."""
    start, end = piece_ends(decay_rate, number)
    return np.asarray((start + end) / 2 + (end - start) / 2 * chebyshev.chebpts1(CHEBYSHEV_POINTS))


def _bessel_j(last: int, x: Array) -> list[Array]:
    """Return the Bessel functions J_0 to J_last, by recurrence where that keeps their digits."""
    values = [j0(x), j1(x)]
    small = x < 0.1
    for m in range(2, last + 1):
        values.append(2 * (m - 1) / x * values[m - 1] - values[m - 2])
        values[m][small] = jv(m, x[small])
    return values


def _bessel_k(last: int, x: Array) -> list[Array]:
    """Return the modified Bessel functions K_0 to K_last, by recurrence."""
    values = [k0(x), k1(x)]
    for m in range(2, last + 1):
        values.append(2 * (m - 1) / x * values[m - 1] + values[m - 2])
    return values


@lru_cache(maxsize=8)
def over_cells(decay_rate: float, offsets: tuple[float, ...], size: float, parity: int) -> tuple[Array, int]:
    """Return weights (offsets, nodes) of a field at the nodes of the first pieces, and the number of these pieces.

    They make integrals over cells of the length `size` along one axis, with their centres at `offsets` from the load.
    The field is even (1) or odd (-1) along that axis, by its `parity`. They are kept for the other fields of a
    response.
    """
    edges = np.array(offsets)[:, None] + np.array([-size / 2, size / 2])
    # exact for the polynomials, and without the differences of their integrals, in which narrow cells would cancel
    gauss, shares = np.array(mean_gauss_rule(CHEBYSHEV_POINTS // 2)).T
    weights: list[Array] = []
    end = 0.0
    while end < np.abs(edges).max():
        start, end = piece_ends(decay_rate, len(weights))
        weights.append(np.zeros((len(offsets), CHEBYSHEV_POINTS)))
        for sign, both_ends in ((1, edges), (parity, -edges[:, ::-1])):
            near, far = np.clip(both_ends, start, end).T
            cells = np.flatnonzero(far > near)
            part = (far - near)[cells, None]
            local = 2 * (near[cells, None] + part * (1 + gauss) / 2 - start) / (end - start) - 1
            values = np.einsum("g,cgn->cn", shares, chebyshev.chebvander(local, CHEBYSHEV_POINTS - 1))
            weights[-1][cells] += sign * part * (values @ FROM_NODES)
    return np.concatenate(weights, axis=1), len(weights)


# exp(-x) is neglected beyond this x in sums of waves: it is 2e-15.
ROUNDING_EXPONENT = 34.0
# Distance across, in wavelengths along y, beyond which a wave along a row has decayed: exp(-2 pi 6) ~ 1e-16.
DECAY_PERIODS = 6.0
# Ratio of the first waves along y of neighbouring bands. The waves of each band are summed on a lattice of their own,
# as wide as its first wave needs. Without bands a coated row of 256 cells along takes four times as long. Ratios of 2
# and 8 take about as long as this one.
BAND_RATIO = 4
# Window of waves: the end and the width, in waves per cell, of the erfc by which waves fade out. Of two such pairs the
# window holds the waves of the second without those of the first.
Window = tuple[tuple[float, float], ...]
# What the fading of a window adds to fields is below rounding beyond 2 / width cells. For LONG_WAVES that is within half
# of NEAR_CELLS. For SEEN_WAVES, beyond which no wave is seen at the centres of cells, it is half a cell, the distance
# of the edges. Half of either end changes coefficients by 5e-5 of the largest at most, twice by 1e-14.
NEAR_CELLS = 24
LONG_WAVES: Window = ((0.9, 0.165),)
SEEN_WAVES: Window = ((20.0, 3.5),)
SHORT_WAVES = LONG_WAVES + SEEN_WAVES
# Number of widths beyond its end at which the erfc is below rounding.
WINDOW_END = 5.3
# For each band of waves the number of the first one along y, and that of the cells across that they are summed on.
Bands = tuple[tuple[int, int], ...]
# Number of amplitudes that are held at once: they stay in the processor's cache.
VALUES_AT_ONCE = 2**17


@dataclass(frozen=True)
class WaveCoefficients:
    """:class:`~contactstudy.elasticity.convolution.Coefficients` of one field of a layered body.

    The field falls as the inverse cube of the distance, or its part without a closed form does.

    Parameters
    ----------
    waves
        Response to one wave.
    thickness
        Depth of the deepest interface; all lengths are in one unit.
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

    def swap_axes(self) -> Self:
        """Return the coefficients that take the place of these when the axes are exchanged."""
        waves, name = self.waves.swap_axes(self.name)
        return replace(self, waves=waves, name=name)

    @property
    def _unit(self) -> float:
        """Factor that takes the field of a cell, whose lengths are in thicknesses, to the unit of the thickness."""
        return self.thickness**self.waves.length_power

    def _over_cells(self, offsets: Array, size: float, axis: int) -> tuple[Array, int]:
        """Return :func:`over_cells` for `offsets` and the `size` of a cell along an `axis`, 0 for x and 1 for y."""
        scaled = tuple(np.ravel(offsets / self.thickness).tolist())
        return over_cells(self.waves.decay_rate, scaled, size / self.thickness, self.parity[axis])

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast, and form a grid where there are many.

        The field of a point load is interpolated on pieces of x times pieces of y, which are integrated over the cell.
        """
        decay_rate = self.waves.decay_rate
        (over_x, pieces_x), (over_y, pieces_y) = self._over_cells(x, dx, 0), self._over_cells(y, dy, 1)
        u, v = (np.ravel([piece_nodes(decay_rate, n) for n in range(pieces)]) for pieces in (pieces_x, pieces_y))
        response = over_x @ field_of_point(self.waves)(self.name, u[:, None], v) @ over_y.T
        at_x, at_y = (np.arange(np.size(offset)).reshape(np.shape(offset)) for offset in (x, y))
        return np.asarray(self._unit * response[at_x, at_y])

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""
        mean = self.strip(x.ravel(), dx) * (dy / period)
        return np.asarray(mean[:, None] + self.varying(x, y, dx, dy, period))

    def strip(self, x: Array, dx: float) -> Array:
        """Return the response to a strip of width `dx`, infinite along y, at offsets `x`."""
        over_x, pieces = self._over_cells(x, dx, 0)
        return np.asarray(self._unit * (over_x @ field_of_line(self.waves).at_nodes(self.name, pieces)))

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
        field = self._on_lattice(dx, dy, bands, along, rows)[_indices(np.abs(x), dx, rows)]
        field = np.where(x < 0, self.parity[0], 1) * (field - field.mean(axis=1, keepdims=True))
        return np.asarray(field[:, _indices(y, dy, along)])

    def lattice(self, x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        across, along = round(width / dx), round(period / dy)
        field = self._on_lattice(dx, dy, ((0, across),), along, across)
        return np.asarray(field[np.ix_(_indices(x, dx, across), _indices(y, dy, along))])

    def _on_lattice(self, dx: float, dy: float, bands: Bands, along: int, rows: int) -> Array:
        """Return the field (rows, along) of :func:`_lattice` in the unit of the thickness."""
        return (
            self._unit * _lattice(self.waves, (dx / self.thickness, dy / self.thickness), bands, along, rows)[self.name]
        )


@lru_cache(maxsize=4)
def _lattice(waves: WaveResponse, cell: tuple[float, float], bands: Bands, along: int, rows: int) -> dict[str, Array]:
    """Return all fields (rows, along) of one cell of a lattice at the first `rows` of its centres, by name.

    `cell` has the sides (dx, dy) of a cell, `along` is the number of cells along y. A band is the waves along y from its
    first one to the next band; `bands` has the number of this first wave, and the number of cells across of the lattice
    on which the band is summed. For a row, which has no images across, each lattice is so wide that the waves of its
    band have decayed from the images to the first `rows`.

    Waves that are long along both axes are summed on these lattices. Others are summed on small ones about the cell
    (Ewald 1921): those that are short along the longer side of a cell alone, then those that are short along the
    shorter side. Left out are waves whose sum is negligible at half a cell from its edges.
    """
    (dx, dy), ratio = cell, max(cell) / min(cell)

    def on_axes(shorter_side: T, longer_side: T) -> tuple[T, T]:
        """Return what holds along the shorter and along the longer side of a cell, along (x, y)."""
        return (shorter_side, longer_side) if dx < dy else (longer_side, shorter_side)

    fields: dict[str, Array] = {}
    ends = *(first for first, _ in bands[1:]), None
    for (first, across), end in zip(bands, ends, strict=True):
        windows = LONG_WAVES, LONG_WAVES
        part = _summed(waves, cell, (across, along), windows, slice(first, end), rows)
        fields = {name: fields.get(name, 0.0) + field for name, field in part.items()}
    for near, windows in (
        (on_axes(NEAR_CELLS * ratio, NEAR_CELLS), on_axes(LONG_WAVES, SHORT_WAVES)),
        # the same length along both axes, and on the longer side at least the neighbouring cells
        (on_axes(NEAR_CELLS, NEAR_CELLS / ratio + 3), on_axes(SHORT_WAVES, SEEN_WAVES)),
    ):
        cells = min(bands[0][1], int(near[0])), min(along, int(near[1]))
        short = _summed(waves, cell, cells, windows)
        at_x, at_y = (np.round(fft.fftfreq(n) * n).astype(np.intp) for n in cells)
        at_x %= bands[0][1]
        seen = np.flatnonzero(at_x < rows)
        places = np.ix_(at_x[seen], at_y)
        for name, field in short.items():
            fields[name][places] += field[seen]
    return fields


def _summed(
    waves: WaveResponse,
    cell: tuple[float, float],
    cells: tuple[int, int],
    windows: tuple[Window, Window],
    band: slice = slice(None),
    rows: int | None = None,
) -> dict[str, Array]:
    """Return all fields (rows, along) of one `cell` of a lattice of `cells` (across, along), by name.

    Only waves in the `windows` across and along, and in the `band` of numbers of waves along y, are taken; values are
    those at the first `rows` of centres, None for all.
    """
    last = ROUNDING_EXPONENT / waves.decay_rate
    # waves per cell, at least 0 along both axes: the others are added by parity, so that 0, its own mirror, is halved
    q, weights = [], []
    for step, count, window, chosen in zip(cell, cells, windows, (slice(None), band), strict=True):
        shortest = min(last * step / (2 * np.pi), window[-1][0] + WINDOW_END * window[-1][1])
        q.append(np.arange(int(shortest * count) + 1)[chosen] / count)
        below = [erfc((q[-1] - end) / width) / 2 for end, width in window]
        weights.append(np.sinc(q[-1]) * (below[-1] - sum(below[:-1])))
        weights[-1][q[-1] == 0] /= 2
    kx, ky = (2 * np.pi * waves_of / step for waves_of, step in zip(q, cell, strict=True))
    first, points = band.start or 0, min(cells[1], 2 * (band.stop or cells[1]))
    summed: dict[str, Array] = {}
    # at most `cells` across, so that no two waves at once go to the same row of `total`
    at_once = min(cells[0], max(1, VALUES_AT_ONCE // max(ky.size, 1)))
    for start in range(0, kx.size, at_once):
        chosen = slice(start, start + at_once)
        columns = int(np.searchsorted(ky, np.sqrt(max(last**2 - kx[start] ** 2, 0.0)), "right"))
        weight = np.multiply.outer(weights[0][chosen], weights[1][:columns])
        fields_of_waves = amplitudes(waves, kx[chosen, None], ky[:columns])
        where = np.arange(start, start + weight.shape[0]) % cells[0]
        for name, amplitude in fields_of_waves.items():
            # at the centres of cells, waves whose numbers differ by `points` are the same: they add up
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
    """Return the fields over the load, by name, under waves whose numbers `across` and `along` broadcast."""
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


def _indices(offsets: Array, step: float, cells: int) -> NDArray[np.intp]:
    """Return the indices (n,) of n `offsets`, multiples of `step`, on a periodic axis of `cells`."""
    return np.asarray(np.round(offsets.ravel() / step).astype(np.intp) % cells)

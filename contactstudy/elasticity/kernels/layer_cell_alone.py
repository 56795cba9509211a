"""Field of a loaded cell alone on a layered half-space, by tables of the field of a point load over the distance."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from scipy.special import gamma, j0, j1, jv, k0, k1, rgamma

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.layer_response import LayerResponse, RealOrComplex, composite

# Tables and cells are divided at r/2 times 0, 1, 2, 4, ..., if waves decay as exp(-k r): the singularities of fields, at
# i r and, of far fields, at zero, are outside a Bernstein ellipse of rho = 5.8.
CHEBYSHEV_POINTS = 22
# exp(-x) is neglected beyond this x.
NEGLIGIBLE_EXPONENT = 42.0
# Terms of the Taylor series of a spectrum about k = 0; how many the far field has in closed form; and up to which part
# of its circle of convergence the others stand for the rest.
SERIES_TERMS, LONG_TERMS, SERIES_END = 9, 3, 0.02

# Parts of a field, by the number of turns.
Parts = Mapping[int, RealOrComplex]


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

    def harmonics(self, k: RealOrComplex) -> Mapping[str, Parts]:
        """Return the fields over the load, by name and by number m of turns, under waves with wave numbers `k`.

        Under a wave at an angle t from x a field is the sum of its parts times cos(m t), or times sin(m t) if it is odd
        along y. Parts with an even m are real for real `k`, others imaginary. Wave numbers may be complex.
        """


class PointField:
    """Fields of a point load on a layered body, as tables of the distance that are filled as they are used.

    A part F of :meth:`WaveResponse.harmonics` with m turns is ``i^m / (2 pi) int F(k) J_m(k s) k dk`` times cos or sin
    of m times the angle from x, at a distance of s thicknesses.
    """

    def __init__(self, waves: WaveResponse) -> None:
        self.waves = waves
        self._around = min(0.5 * waves.materials.pole_distance_from_zero, 1 / waves.decay_rate)
        circle = self._around * np.exp(2j * np.pi * np.arange(64) / 64)
        self._parts = [(name, m) for name, parts in waves.harmonics(circle).items() for m in parts]
        terms = np.real(np.fft.fft(self._spectra(circle)))[:, :SERIES_TERMS] / 64
        self._series = terms / self._around ** np.arange(float(SERIES_TERMS))
        self._pieces: dict[int, Array] = {}

    def _spectra(self, k: RealOrComplex) -> RealOrComplex:
        """Return ``i^m F(k) k`` of all parts (parts, k), which is real for real `k`."""
        harmonics = self.waves.harmonics(k)
        return np.stack([harmonics[name][m] * (k * 1j**m) for name, m in self._parts])

    def __call__(self, name: str, x: Array, y: Array) -> Array:
        """Return the field `name` at offsets `x` and `y`, which broadcast, but not at the load itself."""
        place = x + 1j * y
        s = np.abs(place)
        direction = place / s
        scaled = 2 * s / self.waves.decay_rate
        # frexp: scaled in [2^(e-1), 2^e)
        piece = np.maximum(np.frexp(scaled)[1], 0)
        local = np.where(piece == 0, 2 * scaled, scaled / np.exp2(piece - 2.0)) - np.where(piece == 0, 1, 3)
        chosen = [at for at, (field, _) in enumerate(self._parts) if field == name]
        radial = np.empty((len(chosen), *s.shape))
        for number in np.unique(piece).tolist():
            on_piece = piece == number
            radial[:, on_piece] = chebyshev.chebval(local[on_piece], self._piece(number)[:, chosen])
        total = np.zeros(s.shape)
        for at, values in zip(chosen, radial, strict=True):
            turned = direction ** self._parts[at][1]
            total += values * (turned.real if self.waves.parity(name)[1] > 0 else turned.imag)
        return total

    def _piece(self, number: int) -> Array:
        """Return the Chebyshev coefficients (degree, parts) of all radial fields on a piece of distances."""
        if number not in self._pieces:
            nodes = chebyshev.chebpts1(CHEBYSHEV_POINTS)
            start, end = piece_ends(self.waves, number)
            values = self._radial((start + end) / 2 + (end - start) / 2 * nodes)
            self._pieces[number] = chebyshev.chebfit(nodes, values.T, CHEBYSHEV_POINTS - 1)
        return self._pieces[number]

    def _radial(self, s: Array) -> Array:
        """Return the radial fields (parts, s) at distances `s` in order, by quadrature over k."""
        materials, turns = self.waves.materials, np.array([m for _, m in self._parts])
        result = np.empty((turns.size, s.size))
        far = NEGLIGIBLE_EXPONENT / materials.pole_distance_from_real_axis
        if s[0] < max(far, self.waves.decay_rate):
            k, weight = self._real(float(s[-1]))
            spectra, waves = np.real(self._spectra(k)) * weight, np.multiply.outer(k, s)
            for m, bessel in enumerate(_bessel_j(turns.max(), waves)):
                result[turns == m] = spectra[turns == m] @ bessel
            return result / (2 * np.pi)
        # along the imaginary axis, where J_m decays as K_m; the neglected part is below rounding
        tau, weight = self._imaginary(float(s[0]))
        known, unknown = np.split(self._series, [LONG_TERMS], axis=1)
        rest = self._spectra(1j * tau) - polynomial.polyval(1j * tau, known.T)
        short = tau < SERIES_END * self._around
        rest[:, short] = polynomial.polyval(1j * tau[short], unknown.T) * (1j * tau[short]) ** LONG_TERMS
        powers = np.arange(LONG_TERMS)
        for m, bessel in enumerate(_bessel_k(turns.max(), np.multiply.outer(tau, s))):
            # int k^p J_m(k s) dk
            moments = 2.0**powers * gamma((1 + m + powers) / 2) * rgamma((1 + m - powers) / 2)
            outer = known[turns == m] @ (moments[:, None] / s ** (powers[:, None] + 1))
            decaying = np.real((rest * weight)[turns == m] * (-1j) ** m) @ bessel
            result[turns == m] = outer + 2 / np.pi * decaying
        return result / (2 * np.pi)

    def _real(self, s: float) -> tuple[Array, Array]:
        """Return Gauss points and weights for integrals over k of a field that oscillates with ``k s``."""
        longest = min(1 / self.waves.decay_rate, 4 * np.pi / s)
        ends = [0.0, min(self.waves.materials.pole_distance_from_zero, longest)]
        while ends[-1] < NEGLIGIBLE_EXPONENT / self.waves.decay_rate:
            ends.append(ends[-1] + min(ends[-1], longest))
        return composite(np.array(ends))

    def _imaginary(self, s: float) -> tuple[Array, Array]:
        """Return Gauss points and weights for integrals over tau of a field that decays like ``exp(-s tau)``."""
        materials = self.waves.materials
        end = min(materials.pole_distance_from_real_axis, NEGLIGIBLE_EXPONENT / s)
        start = 1e-3 * min(materials.pole_distance_from_zero, 1 / s)
        count = int(np.ceil(np.log2(end / start)))
        return composite(np.concatenate([[0.0], np.geomspace(start, end, count + 1)]))


@lru_cache(maxsize=256)
def point_field(waves: WaveResponse) -> PointField:
    """Return the tables of one response."""
    return PointField(waves)


def piece_ends(waves: WaveResponse, number: int) -> tuple[float, float]:
    """Return the ends of a piece of distances in thicknesses."""
    unit = waves.decay_rate / 2
    return (0.0, unit) if number == 0 else (unit * 2.0 ** (number - 1), unit * 2.0**number)


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


def cell_alone(waves: WaveResponse, name: str, x: Array, y: Array, dx: float, dy: float) -> Array:
    """Return the field `name` of a cell of sides `dx` and `dy` alone; all lengths are in thicknesses.

    The field of a point load is interpolated by Chebyshev polynomials on pieces of x times pieces of y, which are
    integrated over the cell. The offsets `x` and `y` broadcast, and form a grid where there are many.
    """
    even_x, even_y = waves.parity(name)
    nodes_x, over_x = _integrals(waves, np.ravel(x), dx, even_x)
    nodes_y, over_y = _integrals(waves, np.ravel(y), dy, even_y)
    response = over_x @ point_field(waves)(name, nodes_x[:, None], nodes_y) @ over_y.T
    at_x, at_y = (np.arange(np.size(offset)).reshape(np.shape(offset)) for offset in (x, y))
    return np.asarray(response[at_x, at_y])


def _integrals(waves: WaveResponse, offsets: Array, size: float, parity: int) -> tuple[Array, Array]:
    """Return offsets above 0 (nodes,), and weights (offsets, nodes) of values there: integrals over cells of a `size`.

    Values are those of a field that is even or odd, by its `parity`.
    """
    edges = offsets[:, None] + np.array([-size / 2, size / 2])
    distances, local = np.abs(edges), chebyshev.chebpts1(CHEBYSHEV_POINTS)
    basis = chebyshev.chebfit(local, np.eye(CHEBYSHEV_POINTS), CHEBYSHEV_POINTS - 1)
    primitives = chebyshev.chebint(basis, lbnd=-1)
    nodes, weights, number, end = [], [], 0, 0.0
    while end < distances.max():
        start, end = piece_ends(waves, number)
        middle, half = (start + end) / 2, (end - start) / 2
        nodes.append(middle + half * local)
        within = np.clip((distances - middle) / half, -1, 1)
        up_to = half * chebyshev.chebvander(within, CHEBYSHEV_POINTS) @ primitives
        if parity > 0:
            up_to *= np.sign(edges)[..., None]
        weights.append(up_to[:, 1] - up_to[:, 0])
        number += 1
    return np.concatenate(nodes), np.concatenate(weights, axis=1)

"""Layers on a half-space under a wave of pressure or tangential traction: displacement of the surface, stress below it.

The change by the layers has a closed form, but for a remainder. It is zero for the longest waves, and so short-ranged:
:class:`LayerResponse` gives that of the displacement, :class:`LayerStress` that of the stress. With the wave number k,
``t = k z`` and Airy's stress function ``f(t) cos(k x) / k^2``, a pressure ``P cos(k x)`` and a traction ``Q sin(k x)``
along x give the stresses ``s_zz = -f cos(k x)``, ``s_xz = f' sin(k x)`` and ``s_xx = f'' cos(k x)``.

The field of a cell alone is found by tables of the field of a point load over the distance.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from math import factorial
from typing import Any, Protocol

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from numpy.typing import NDArray
from scipy.interpolate import PPoly, make_interp_spline
from scipy.special import gamma, j0, j1, jv, k0, k1, rgamma

from contactstudy.domain.grid import Array
from contactstudy.elasticity.kernels.displacement import mean_gauss_rule

RealOrComplex = NDArray[np.inexact[Any]]

# Largest wave number times thickness of one step through a layer: in a longer one exponentials cancel.
LONGEST_STEP = 4.0
# Wave number times thickness beyond which a layer is a half-space: exp(-2 * 20) is below rounding.
DEEP = 20.0
# Largest length of a piece of the spline through a remainder: over its wave number, and at long waves.
SPLINE_PIECE, LONG_PIECE = 1 / 64, 0.25
# Points on each piece of the spline, and its degree.
SPLINE_POINTS, SPLINE_DEGREE = 48, 7
# Wave number over the distance of the nearest pole up to which a remainder is its Taylor series to k^6. The error is of
# the order of SERIES_END^7.
SERIES_END = 0.02
# Values of a remainder beyond which a spline is made for all of them.
MAX_DIRECT = 4096
# Last wave number of that spline. The shortest wave that is asked for has 17 along both axes, 24 in all. Beyond 20
# remainders are below 2e-14 of the largest.
LAST_SPLINE_WAVE = 25.0
# Gauss points on each piece of k, at most two oscillations long.
GAUSS_POINTS = 18


@dataclass(frozen=True)
class LayerResponse:
    """Layers on a half-space under a wave, and what the half-space adds to one of the deepest layer's material.

    The state is (2 G k U, 2 G k V, s_zz, s_xz), with displacement U along the wave and V along the normal, k the wave
    number times the depth of the deepest interface, and G of the material at hand. The compliance under pressure and
    shear is carried up through the layers from that of the half-space, and traction down: neither step has exponentials
    that cancel. Normal displacement under pressure, over that of a half-space of the top layer, changes by
    ``d0 exp(-2 k) + R(k)``; d0 is the first of `contrasts`, and R is the first of `remainders`, zero at k = 0.

    Source: plane strain of bonded layers (Burmister 1945; Johnson 1985, sect. 5.8), antiplane strain across the wave.
    It holds for every direction of the wave.

    Parameters
    ----------
    shear_ratios
        Shear modulus of the top layer over that of each material below; 0 for a rigid half-space.
    poisson_ratios
        Poisson's ratios, from the top layer to the half-space.
    interfaces
        Depths of the interfaces over that of the deepest one.
    """

    shear_ratios: tuple[float, ...]
    poisson_ratios: tuple[float, ...]
    interfaces: tuple[float, ...] = (1.0,)

    @property
    def above(self) -> "LayerResponse":
        """The same layers on a half-space of the deepest layer's material."""
        return LayerResponse(self.shear_ratios[:-1], self.poisson_ratios[:-1], self.interfaces[:-1])

    @property
    def all_shear_ratios(self) -> tuple[float, ...]:
        """Shear modulus of the top layer over that of each material, itself the first."""
        return (1.0, *self.shear_ratios)

    @property
    def contrasts(self) -> tuple[float, float, float, float]:
        """Factors of ``exp(-2 k)`` in what the half-space adds, in the order of :meth:`compliances`.

        They are of displacement by pressure, by shear along the wave, of their coupling, and by shear across the wave.
        The coupling of the displacements is over 1 / (2 G) of the top layer, the others are over ``(1 - nu^2) / E``.
        """
        before, ratio = self.all_shear_ratios[-2:]
        nu1, nu2 = self.poisson_ratios[-2:]
        normal, stiff = ratio * (1 - nu2) - before * (1 - nu1), 1 - self.poisson_ratios[0]
        coupling = ratio * (1 - 2 * nu2) - before * (1 - 2 * nu1)
        return normal / stiff, normal / stiff, coupling, (ratio - before) / stiff

    @property
    def _stiffness_ratio(self) -> float:
        """Largest over smallest shear modulus, of one layer that of the layer over the half-space, at least 1.

        A rigid half-space does not count.
        """
        elastic = [ratio for ratio in self.all_shear_ratios if ratio]
        ratio = max(elastic) / min(elastic)
        return max(self.shear_ratios[0], 1.0) if len(self.interfaces) == 1 else ratio

    @property
    def pole_distance_from_zero(self) -> float:
        """Lower bound of the distance of singularities of the remainders from k = 0.

        The nearest one of one layer tends to ``k = -(1 - nu1) / (2 m (1 - nu2))`` for a stiff one, with the ratio m of
        the shear moduli; the bound takes nu1 = 1/2.
        """
        return min(0.2, 0.25 / (1 - min(self.poisson_ratios[1:]))) / self._stiffness_ratio

    @property
    def pole_distance_from_real_axis(self) -> float:
        """Lower bound of the distance of poles of the remainders in the right half-plane from the real axis.

        A plate on a soft half-space has one at the cube root of the ratio of moduli; a soft layer between stiff ones,
        in which they shift, at its square root. On the imaginary axis itself an incompressible layer on a rigid
        half-space has one at 0.74, where what is integrated along that axis has decayed.
        """
        power = 1 / 3 if len(self.interfaces) == 1 else 1 / 2
        return float(0.85 * self._stiffness_ratio**-power)

    def index(self, depth: float) -> int:
        """Return the number of the material at a depth, to which its lower interface belongs."""
        return int(np.searchsorted(self.interfaces, depth))

    def _slabs(self, depth: float) -> Iterator[tuple[int, float, float, float]]:
        """Yield (material, factor, top, bottom) of each layer from below, cut at a depth.

        The factor takes a compliance times the shear modulus of the material below to one times that of this layer.
        """
        ratios, below = self.all_shear_ratios, len(self.interfaces)
        for top, bottom in reversed(list(pairwise(sorted({0.0, *self.interfaces, depth})))):
            material = self.index(bottom)
            yield material, ratios[below] / ratios[material] if material < below else 1.0, top, bottom
            below = material

    def plane(self, k: RealOrComplex, depth: float = 0.0) -> tuple[RealOrComplex, RealOrComplex]:
        """Return compliance and traction at a depth (k, 2, 2) in the plane of the wave.

        The compliance is (2 G k U, 2 G k V) over (s_zz, s_xz), and the traction that over the same at the surface.
        """
        nu, unity = self.poisson_ratios[-1], np.ones((k.size, 1, 1), k.dtype)
        compliance = unity * np.array([[1 - 2 * nu, 2 * nu - 2], [2 * nu - 2, 1 - 2 * nu]])
        traction = unity * np.eye(2)
        at_depth = compliance
        for material, factor, top, bottom in self._slabs(depth):
            compliance, t = compliance * factor, k * (bottom - top)
            if bottom == depth:
                at_depth = compliance
            if bottom > depth:
                t = t / np.maximum(np.abs(t) / DEEP, 1)
            steps = max(1, int(np.ceil(np.abs(t).max(initial=0.0) / LONGEST_STEP)))
            up = _transfer(-t / steps, self.poisson_ratios[material])
            for _ in range(steps):
                inverse = _inverse(up[:, 2:, :2] @ compliance + up[:, 2:, 2:])
                compliance = (up[:, :2, :2] @ compliance + up[:, :2, 2:]) @ inverse
                if bottom <= depth:
                    traction = traction @ inverse
        return at_depth if depth else compliance, traction

    def antiplane(self, k: RealOrComplex, depth: float = 0.0) -> tuple[RealOrComplex, RealOrComplex]:
        """Return compliance and traction at a depth along the crests of the wave, each of the shape of `k`.

        The compliance is G k W over the shear, with displacement W along the crests; the traction is the shear over
        that at the surface.
        """
        compliance = through = at_depth = np.ones_like(k)
        for _, factor, top, bottom in self._slabs(depth):
            compliance, t = compliance * factor, k * (bottom - top)
            if bottom == depth:
                at_depth = compliance
            if bottom <= depth:
                through = through / (np.cosh(t) + compliance * np.sinh(t))
            tanh = np.tanh(t)
            compliance = (compliance + tanh) / (1 + compliance * tanh)
        return at_depth if depth else compliance, through

    def compliances(self, k: RealOrComplex) -> RealOrComplex:
        """Return displacements by pressure and by shear along the wave, their coupling, and across (4, k).

        They are over ``(1 - nu^2) / E`` of the top layer, but for the coupling, which is over 1 / (2 G).
        """
        plane, stiff = self.plane(k)[0], 1 - self.poisson_ratios[0]
        normal, along = -plane[:, 1, 0] / (2 * stiff), -plane[:, 0, 1] / (2 * stiff)
        return np.stack([normal, along, plane[:, 0, 0], self.antiplane(k)[0] / stiff])

    def remainders(self, k: RealOrComplex, which: slice = slice(None)) -> RealOrComplex:
        """Return `compliances` less those of :attr:`above`, less ``contrasts exp(-2 k)``, of shape (4, ...).

        `which` selects some of the four. Many real values are read off a spline.
        """
        if k.size > MAX_DIRECT and not np.iscomplexobj(k):
            fitted = _spline(self)
            return np.asarray(np.moveaxis(PPoly(fitted.c[..., which], fitted.x)(k), -1, 0))
        flat = k.ravel()
        change = self._change(flat)
        long = np.abs(flat) < SERIES_END * self.pole_distance_from_zero
        if long.any():
            change[:, long] = polynomial.polyval(flat[long], np.array(self._series).T)
        change = change[which]
        return np.asarray(change.reshape(len(change), *k.shape))

    def _change(self, k: RealOrComplex) -> RealOrComplex:
        """Return :meth:`remainders` at `k` (k,) as differences, which lose digits to cancellation for long waves."""
        change = self.compliances(k) - self.above.compliances(k)
        change -= np.multiply.outer(np.array(self.contrasts), np.exp(-2 * k))
        return np.asarray(change)

    @cached_property
    def _series(self) -> list[list[float]]:
        """Taylor coefficients up to k^6 of all `remainders`, of which the first is zero."""
        radius = 0.5 * self.pole_distance_from_zero  # of a circle around zero: Cauchy's integrals on it
        unit_circle = np.exp(2j * np.pi * np.arange(64) / 64)
        terms = np.real(np.fft.fft(self._change(radius * unit_circle)))[:, :7] / 64
        return [[0.0, *row[1:]] for row in (terms / radius ** np.arange(7.0)).tolist()]


def _inverse(matrix: RealOrComplex) -> RealOrComplex:
    """Return the inverse of many matrices (k, 2, 2), in a quarter of the time of LAPACK."""
    a, b, c, d = matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 0], matrix[:, 1, 1]
    inverse = np.stack([d, -b, -c, a], axis=-1) / (a * d - b * c)[:, None]
    return np.asarray(inverse.reshape(-1, 2, 2))


def _transfer(t: RealOrComplex, nu: float) -> RealOrComplex:
    """Return the exponential of t times the derivative of the state of :class:`LayerResponse` (t, 4, 4)."""
    rate = np.array([[0, 1, 0, 2], [-nu, 0, 1 - 2 * nu, 0], [0, 0, 0, -1], [1, 0, nu, 0]], dtype=float)
    rate[[1, 3]] /= 1 - nu
    cosh, sinh = np.cosh(t), np.sinh(t)
    terms = cosh - t * sinh / 2, (3 * sinh - t * cosh) / 2, t * sinh / 2, (t * cosh - sinh) / 2
    powers = [np.linalg.matrix_power(rate, n) for n in range(4)]
    return np.asarray(sum(np.multiply.outer(term, power) for term, power in zip(terms, powers, strict=True)))


def spline(function: Callable[[Array], RealOrComplex], first: float, last: float) -> PPoly:
    """Return a spline through a `function` (..., k) of wave numbers up to `last`, whose first piece ends at `first`.

    The function is asked for at most `MAX_DIRECT` values at once. Polynomials take a third of the time of a sum of
    B-splines.
    """
    ends = [0.0, first]
    while ends[-1] < last:
        ends.append(ends[-1] + min(ends[-1], max(LONG_PIECE, SPLINE_PIECE * ends[-1])))
    k = np.concatenate([np.arange(SPLINE_POINTS) / SPLINE_POINTS * (end - at) + at for at, end in pairwise(ends)])
    k = np.append(k, ends[-1])
    blocks = [function(block) for block in np.array_split(k, 1 + k.size // MAX_DIRECT)]
    fitted = make_interp_spline(k, np.concatenate(blocks, axis=-1).reshape(-1, k.size).T, SPLINE_DEGREE)
    knots = fitted.t[SPLINE_DEGREE:-SPLINE_DEGREE]
    powers = [fitted(knots[:-1], n) / factorial(n) for n in range(SPLINE_DEGREE, -1, -1)]
    return PPoly(np.array(powers), knots)


@lru_cache(maxsize=32)
def _spline(response: LayerResponse) -> PPoly:
    """Return all remainders of a response as a spline."""
    return spline(response.remainders, response.pole_distance_from_zero / 2, LAST_SPLINE_WAVE)


def composite(ends: Array) -> tuple[Array, Array]:
    """Return Gauss points and weights on pieces between `ends`."""
    nodes, weights = np.array(mean_gauss_rule(GAUSS_POINTS)).T
    middle, width = (ends[1:] + ends[:-1]) / 2, np.diff(ends)
    points = middle[:, None] + width[:, None] / 2 * nodes
    return points.ravel(), (width[:, None] * weights).ravel()


# Last wave number of the spline through the remainder of a stress, times the rate at which that decays. A wave with 34
# along each axis, where the remainder is below rounding, has 48 in all.
LAST_STRESS_WAVE = 49.0
# Wave numbers beyond which that spline is made: more than the integral over the waves of a strip takes. On a lattice it
# is always made, since many sums read it.
MAX_DIRECT_STRESS = 2**13


def half_space(t: RealOrComplex) -> tuple[tuple[RealOrComplex, RealOrComplex, RealOrComplex], ...]:
    """Return (s_zz, s_xz, s_xx) in a half-space at ``t = k z``, under a unit pressure and under a unit shear."""
    e = np.exp(-t)
    return (-(1 + t) * e, -t * e, -(1 - t) * e), (t * e, (t - 1) * e, (2 - t) * e)


@dataclass(frozen=True)
class LayerStress:
    """Stress under a wave at one depth, and its change by the layers.

    In the layers it is the change from the same layers on a half-space of the deepest layer's material, below them that
    from the half-space without layers.

    Parameters
    ----------
    materials
        Materials and depths of their interfaces.
    depth
        Depth over that of the deepest interface, at least 0.
    """

    materials: LayerResponse
    depth: float

    @property
    def in_layer(self) -> bool:
        """True if the depth is in a layer, to which its lower interface belongs."""
        return self.depth <= 1

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio of the material at this depth."""
        return self.materials.poisson_ratios[self.materials.index(self.depth)]

    @property
    def decay_rate(self) -> float:
        """Rate at which a remainder decays as exp(-k `decay_rate`), with `k` as in :meth:`plane`."""
        return 2 - self.depth if self.in_layer else self.depth

    def plane(self, k: RealOrComplex) -> RealOrComplex:
        """Return (s_zz, s_xz, s_xx) under a unit pressure and a unit shear (load, component, k).

        `k` is the wave number times the depth of the deepest interface, on the real or the imaginary axis. s_xx follows
        from s_zz and the strain along x: ``(1 - nu) s_xx = 2 G du/dx + nu s_zz``.
        """
        compliance, traction = self.materials.plane(k, self.depth)
        nu = self.poisson_ratio
        # the stress at the surface is -P and -Q
        normal, shear = -np.moveaxis(traction, 0, -1)
        strain = -np.moveaxis(compliance @ traction, 0, -1)[0]  # 2 G du/dx
        return np.stack([normal, shear, (strain + nu * normal) / (1 - nu)], axis=1)

    def remainder(self, k: RealOrComplex) -> RealOrComplex:
        """Return the change of :meth:`plane` less what is known in closed form.

        It is zero at k = 0, and decays as exp(-k `decay_rate`). In a layer the closed form is a change of s_xx alone,
        taken at the depth of the point's mirror image in the deepest interface: the stress of this layer under the
        strain of the half-space there, less that under the strain of one of the deepest layer's material. Values at
        many real `k`, up to LAST_STRESS_WAVE over the decay rate, and at those of a lattice (across, along) are read
        off a spline.
        """
        if (k.ndim > 1 or k.size > MAX_DIRECT_STRESS) and not np.iscomplexobj(k):
            values = np.asarray(np.moveaxis(_stress_spline(LayerStress(self.materials, self.depth))(k), -1, 0))
        else:
            values = self._remainder(k.ravel())
        return values.reshape(2, 3, *k.shape)

    def _remainder(self, k: RealOrComplex) -> RealOrComplex:
        """Return :meth:`remainder` at wave numbers `k` (k,)."""
        if not self.in_layer:
            return np.asarray(self.plane(k) - np.array(half_space(k * self.depth)))
        above, image = self.materials.above, np.array(half_space(k * self.decay_rate))
        change: RealOrComplex = self.plane(k) - LayerStress(above, self.depth).plane(k)
        for sign, below in ((1, self.materials), (-1, above)):
            change[:, 2] = change[:, 2] - sign * self._strained(below, image[:, 0], image[:, 2])
        return change

    def ratios(self, below: LayerResponse) -> tuple[float, float, float]:
        """Return the shear modulus here over that of a half-space `below`, and Poisson's ratios here and there."""
        own_ratio = self.materials.all_shear_ratios[self.materials.index(self.depth)]
        return below.all_shear_ratios[-1] / own_ratio, self.poisson_ratio, below.poisson_ratios[-1]

    def _strained(self, below: LayerResponse, normal: RealOrComplex, across: RealOrComplex) -> RealOrComplex:
        """Return s_xx here under the strain of a half-space `below`, whose s_zz and s_xx are `normal` and `across`."""
        ratio, nu1, nu2 = self.ratios(below)
        strain = ratio * ((1 - nu2) * across - nu2 * normal)
        return np.asarray((strain + nu1 * normal) / (1 - nu1))

    def antiplane(self, k: RealOrComplex) -> tuple[RealOrComplex, RealOrComplex]:
        """Return the remainder, as :meth:`remainder`, of the shear stresses along the crests under a unit shear there.

        With the stress proportional to exp(i k x) and y along the crests, they are s_yz and the imaginary part of s_xy.
        """
        down, around = self._antiplane(k)
        if not self.in_layer:
            decay = np.exp(-k * self.depth)
            return decay - down, around - decay
        without = LayerStress(self.materials.above, self.depth)._antiplane(k)
        contrast = self.ratios(self.materials)[0] - self.ratios(self.materials.above)[0]
        return without[0] - down, around - without[1] - contrast * np.exp(-k * self.decay_rate)

    def _antiplane(self, k: RealOrComplex) -> tuple[RealOrComplex, RealOrComplex]:
        """Return the shear along the crests over that at the surface, and G times the slope of the displacement."""
        compliance, traction = self.materials.antiplane(k, self.depth)
        return traction, compliance * traction


@lru_cache(maxsize=64)
def _stress_spline(stress: LayerStress) -> PPoly:
    """Return the remainder as a spline (load and component) of the wave number."""
    return spline(stress.remainder, stress.materials.pole_distance_from_zero / 2, LAST_STRESS_WAVE / stress.decay_rate)


# Tables and cells are divided at r/2 times 0, 1, 2, 4, ..., if waves decay as exp(-k r): the singularities of fields, at
# i r and, of far fields, at zero, are outside a Bernstein ellipse of rho = 5.8.
CHEBYSHEV_POINTS = 22
# exp(-x) is neglected beyond this x.
NEGLIGIBLE_EXPONENT = 42.0
# Terms of the Taylor series of a spectrum about k = 0; how many the far field has in closed form; and up to which part
# of its circle of convergence the others stand for the rest.
SERIES_TERMS, LONG_TERMS, TABLE_SERIES_END = 9, 3, 0.02

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
        short = tau < TABLE_SERIES_END * self._around
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

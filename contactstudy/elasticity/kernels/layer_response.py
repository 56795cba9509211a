"""Layers on a half-space under one wave of load: displacement of the surface, and stress at a depth.

A load on the surface is a pressure or a tangential traction, in proportion to ``exp(i k x)``. :class:`LayerResponse`
has the response of all layers, by stiffness matrices. A :class:`WaveResponse` is what layers add to bodies without
them, for every direction of the wave: :class:`DisplacementWaves` to the displacement of the surface,
:class:`StressWaves` to the stress at one depth. Part of it has a closed form. The rest, the remainder, is zero for the
longest waves, so that its field is short-ranged. :mod:`~contactstudy.elasticity.kernels.layer_waves` sums these waves
to the fields of cells.

Lengths are in units of the depth of the deepest interface, called the thickness; so are wave numbers k, in units of its
inverse. With Airy's stress function ``f(t) cos(k x) / k^2``, ``t = k z``, a pressure ``P cos(k x)`` and a traction ``Q
sin(k x)`` along x give the stresses ``s_zz = -f cos(k x)``, ``s_xz = f' sin(k x)`` and ``s_xx = f'' cos(k x)``, tension
positive, with z into the body.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from math import factorial
from typing import Any, ClassVar

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray
from scipy.interpolate import PPoly, make_interp_spline

from contactstudy.domain.grid import Array
from contactstudy.elasticity.kernels.stress import BOUSSINESQ, FAMILIES, SURFACE, SWAPPED

# Real numbers for real wave numbers, complex ones for complex ones.
RealOrComplex = NDArray[np.inexact[Any]]
# Parts of one field by their number m of turns, see :meth:`WaveResponse.harmonics`.
Parts = Mapping[int, RealOrComplex]

# Wave number times thickness beyond which a layer is a half-space: exp(-2 * 20) is below rounding.
DEEP = 20.0
# Number of wave numbers beyond which they are read off a spline: more than most quadratures over the waves of a point
# or a line take. Those of a lattice, (across, along), always are, since many sums of them read the same spline.
MAX_DIRECT = 8192
# Last wave number of the spline times the rate of decay. Sums of waves end where exp(-34) is left of a wave along
# either axis, and the shortest wave is sqrt(2) times as short.
LAST_SPLINE_WAVE = 49.0
# Largest length of a piece of the spline, points on each piece, and its degree. With them it has the digits of what it
# interpolates; pieces of a quarter of the length change nothing.
LONGEST_PIECE, SPLINE_POINTS, SPLINE_DEGREE = 1.0, 48, 7
# Wave number over the distance of the nearest pole up to which a remainder of displacement is its Taylor series, and
# the last power in that. The error of the series is of the order of 0.02^7 ~ 1e-12 of its terms.
SERIES_END, SERIES_POWER = 0.02, 6


@dataclass(frozen=True)
class LayerResponse:
    """Layers on a half-space under a wave of load on the surface.

    In the plane of the wave the state at a depth is (2 G k U, 2 G k V, s_zz, s_xz), with the displacement U along the
    wave and V along the normal, the wave number k, and the shear modulus G of the material at that depth. The
    compliance, displacement over stress, is found upwards through the layers from that of the half-space, then the
    traction on planes of constant depth downwards: neither has exponentials that cancel.

    Source: plane strain of bonded layers (Burmister 1945; Johnson 1985, sect. 5.8), and antiplane strain for the
    displacement W along the crests of the wave. It holds for every direction of the wave.

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
        """Response of the same layers where the half-space is of the deepest layer's material: one interface less."""
        return LayerResponse(self.shear_ratios[:-1], self.poisson_ratios[:-1], self.interfaces[:-1])

    @property
    def all_shear_ratios(self) -> tuple[float, ...]:
        """Shear modulus of the top layer over that of each material, itself the first."""
        return (1.0, *self.shear_ratios)

    @property
    def contrasts(self) -> tuple[float, float, float, float]:
        """Factors of ``exp(-2 k)`` in :meth:`compliances` less those of :attr:`above`, in their order and units.

        With them the compliances are those of the half-space alone under the longest waves.
        """
        before, ratio = self.all_shear_ratios[-2:]
        nu1, nu2 = self.poisson_ratios[-2:]
        normal, stiff = ratio * (1 - nu2) - before * (1 - nu1), 1 - self.poisson_ratios[0]
        coupling = ratio * (1 - 2 * nu2) - before * (1 - 2 * nu1)
        return normal / stiff, normal / stiff, coupling, (ratio - before) / stiff

    @property
    def _stiffness_ratio(self) -> float:
        """Largest over smallest shear modulus, rigid half-spaces left out; at least 1.

        One layer counts only where it is stiffer than the half-space: its modulus over that of the half-space.
        """
        elastic = [ratio for ratio in self.all_shear_ratios if ratio]
        ratio = max(elastic) / min(elastic)
        return max(self.shear_ratios[0], 1.0) if len(self.interfaces) == 1 else ratio

    @property
    def pole_distance_from_zero(self) -> float:
        """Lower bound of the distance of singularities of the remainders from k = 0 in the complex plane.

        The nearest singularity of one stiff layer tends to ``k = -(1 - nu1) / (2 m (1 - nu2))``, with the ratio m of
        the shear moduli; the bound takes nu1 = 1/2. It is taken as 0.2 at most: half of that changes no
        coefficient beyond rounding, twice that by 1e-13 of the largest.
        """
        return min(0.2, 0.25 / (1 - min(self.poisson_ratios[1:]))) / self._stiffness_ratio

    @property
    def pole_distance_from_real_axis(self) -> float:
        """Lower bound of the distance of poles of the remainders in the right half-plane from the real axis.

        With the ratio of moduli m, a stiff layer on a soft half-space has a pole at a distance of m^(-1/3). Several
        layers, such as two stiff ones that shear a soft one, have one at m^(-1/2). On the imaginary axis itself an
        incompressible layer on a rigid half-space has a pole at 0.74, where what is integrated along that axis has
        decayed. Half or twice the factor 0.85 changes no coefficient beyond rounding.
        """
        power = 1 / 3 if len(self.interfaces) == 1 else 1 / 2
        return float(0.85 * self._stiffness_ratio**-power)

    def index(self, depth: float) -> int:
        """Return the number of the material at a depth, 0 for the top layer; an interface belongs to the layer above."""
        return int(np.searchsorted(self.interfaces, depth))

    def _slabs(self, depth: float) -> Iterator[tuple[int, float, float, float]]:
        """Yield (number of the material, factor, top, bottom) of each layer from below, cut in two at a `depth`.

        The factor takes a compliance times the shear modulus of the material below to one times that of this layer; top
        and bottom are depths.
        """
        ratios, below = self.all_shear_ratios, len(self.interfaces)
        for top, bottom in reversed(list(pairwise(sorted({0.0, *self.interfaces, depth})))):
            material = self.index(bottom)
            yield material, ratios[below] / ratios[material] if material < below else 1.0, top, bottom
            below = material

    def plane(self, k: RealOrComplex, depth: float = 0.0) -> tuple[RealOrComplex, RealOrComplex]:
        """Return compliance and traction (k, 2, 2) at a `depth` in the plane of the wave, for wave numbers `k` (k,).

        The compliance takes (s_zz, s_xz) to (2 G k U, 2 G k V), both at the depth. The traction takes (s_zz, s_xz) at
        the surface to that at the depth.
        """
        nu, unity = self.poisson_ratios[-1], np.ones((k.size, 1, 1), k.dtype)
        compliance = unity * np.array([[1 - 2 * nu, 2 * nu - 2], [2 * nu - 2, 1 - 2 * nu]])
        traction = unity * np.eye(2)
        at_depth = compliance
        for material, factor, top, bottom in self._slabs(depth):
            compliance, t = compliance * factor, k * (bottom - top)
            if bottom == depth:
                at_depth = compliance
            if bottom > depth:  # traction is not needed there: a deep layer counts as thick as DEEP
                t = t / np.maximum(np.abs(t) / DEEP, 1)
            up = _transfer(-t, self.poisson_ratios[material])
            inverse = _inverse(up[:, 2:, :2] @ compliance + up[:, 2:, 2:])
            compliance = (up[:, :2, :2] @ compliance + up[:, :2, 2:]) @ inverse
            if bottom <= depth:
                traction = traction @ inverse
        return at_depth if depth else compliance, traction

    def antiplane(self, k: RealOrComplex, depth: float = 0.0) -> tuple[RealOrComplex, RealOrComplex]:
        """Return compliance and traction at a `depth` along the crests of the wave, each of the shape of `k`.

        The compliance is G k W over the shear stress there, with the displacement W along the crests; the traction is
        the shear stress there over that at the surface.
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
        """Return four displacements of the surface under waves `k` (k,), each times k over the load (4, k).

        In order: along the normal by pressure, and along the wave by shear along the wave, in units of ``2 (1 - nu^2) /
        E`` of the top layer; their coupling, along the wave by s_zz, in units of its 1 / (2 G); and along the crests by
        shear along these, in the unit of the first.
        """
        plane, stiff = self.plane(k)[0], 1 - self.poisson_ratios[0]
        normal, along = -plane[:, 1, 0] / (2 * stiff), -plane[:, 0, 1] / (2 * stiff)
        return np.stack([normal, along, plane[:, 0, 0], self.antiplane(k)[0] / stiff])


def _inverse(matrix: RealOrComplex) -> RealOrComplex:
    """Return the inverse of many matrices (k, 2, 2), in a quarter of the time of LAPACK and with more digits."""
    a, b, c, d = matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 0], matrix[:, 1, 1]
    inverse = np.stack([d, -b, -c, a], axis=-1) / (a * d - b * c)[:, None]
    return np.asarray(inverse.reshape(-1, 2, 2))


def _transfer(t: RealOrComplex, nu: float) -> RealOrComplex:
    """Return the matrices (t, 4, 4) that take the state of :class:`LayerResponse` from a depth to one t / k deeper.

    They are the exponential of t times the matrix of the state's derivative, `nu` being Poisson's ratio. Its
    eigenvalues are 1 and -1, both twice, so that the exponential is a cubic polynomial of the matrix.
    """
    rate = np.array([[0, 1, 0, 2], [-nu, 0, 1 - 2 * nu, 0], [0, 0, 0, -1], [1, 0, nu, 0]], dtype=float)
    rate[[1, 3]] /= 1 - nu
    cosh, sinh = np.cosh(t), np.sinh(t)
    terms = cosh - t * sinh / 2, (3 * sinh - t * cosh) / 2, t * sinh / 2, (t * cosh - sinh) / 2
    powers = [np.linalg.matrix_power(rate, n) for n in range(4)]
    return np.asarray(sum(np.multiply.outer(term, power) for term, power in zip(terms, powers, strict=True)))


class WaveResponse(ABC):
    """Fields that layers add to those of a body under a wave of load, over the load, in any direction of the wave.

    A subclass names its fields, and subtracts from them what has a closed form: :meth:`remainders`. Subclasses are
    frozen dataclasses: tables and splines are kept for equal ones. Wave numbers are in units of the inverse of the
    thickness, real, or complex where waves decay.
    """

    #: Materials and interfaces, which determine the singularities in k.
    materials: LayerResponse
    #: Power of the thickness by which the fields of a cell are multiplied, since lengths are in thicknesses here.
    length_power: ClassVar[int]

    @property
    @abstractmethod
    def decay_rate(self) -> float:
        """Rate at which remainders decay with the wave number, as exp(-k `decay_rate`)."""

    @abstractmethod
    def parity(self, name: str) -> tuple[int, int]:
        """Return the parity of the field `name` in x and y: 1 if it is even, -1 if it is odd."""

    @abstractmethod
    def swap_axes(self, name: str) -> "tuple[WaveResponse, str]":
        """Return the response and the field that take the place of these when the axes x and y are exchanged."""

    @abstractmethod
    def harmonics(self, k: RealOrComplex) -> Mapping[str, Parts]:
        """Return all fields by name, each as its parts by their number m of turns, under waves with wave numbers `k`.

        Under a wave at an angle t from x a field is the sum of its parts times cos(m t), or times sin(m t) if it is odd
        along y. Parts with an even m are real for real `k`, others imaginary. Wave numbers may be complex.
        """

    def short_harmonics(self, k: RealOrComplex) -> Mapping[str, Parts]:
        """Return :meth:`harmonics` without the closed form of the field of a line load, which reaches to infinity."""
        return self.harmonics(k)

    @abstractmethod
    def direct_remainders(self, k: RealOrComplex) -> RealOrComplex:
        """Return the remainders of the response in the subclass's order (n, k), without the spline."""

    def remainders(self, k: RealOrComplex) -> RealOrComplex:
        """Return the remainders (n, ...) at wave numbers `k` (...). Many real ones are read off a spline."""
        if (k.ndim > 1 or k.size > MAX_DIRECT) and not np.iscomplexobj(k):
            return np.asarray(np.moveaxis(_spline(self)(k), -1, 0))
        values = self.direct_remainders(k.ravel())
        return values.reshape(len(values), *k.shape)


@lru_cache(maxsize=64)
def _spline(waves: WaveResponse) -> PPoly:
    """Return all remainders of `waves` as a spline of the real wave number; its values are (k, n).

    Its pieces grow with the wave number, from half the distance of the nearest pole on. A polynomial on each piece
    takes a third of the time of a sum of B-splines.
    """
    ends = [0.0, waves.materials.pole_distance_from_zero / 2]
    while ends[-1] < LAST_SPLINE_WAVE / waves.decay_rate:
        ends.append(ends[-1] + min(ends[-1], LONGEST_PIECE))
    k = np.concatenate([np.arange(SPLINE_POINTS) / SPLINE_POINTS * (end - at) + at for at, end in pairwise(ends)])
    k = np.append(k, ends[-1])
    blocks = [waves.direct_remainders(block) for block in np.array_split(k, 1 + k.size // MAX_DIRECT)]
    fitted = make_interp_spline(k, np.concatenate(blocks, axis=-1).T, SPLINE_DEGREE)
    knots = fitted.t[SPLINE_DEGREE:-SPLINE_DEGREE]
    powers = [fitted(knots[:-1], n) / factorial(n) for n in range(SPLINE_DEGREE, -1, -1)]
    return PPoly(np.array(powers), knots)


def taylor_coefficients(values: RealOrComplex, radius: float) -> Array:
    """Return Taylor coefficients (..., 64) about zero of functions that are real on the real axis.

    `values` (..., 64) are theirs on the :func:`circle` with this `radius`, within which they are analytic. The
    coefficients are Cauchy's integrals.
    """
    return np.asarray(np.real(np.fft.fft(values)) / 64 / radius ** np.arange(64.0))


def circle(radius: float) -> NDArray[np.complex128]:
    """Return 64 points (64,) on a circle around zero, for :func:`taylor_coefficients`."""
    return np.asarray(radius * np.exp(2j * np.pi * np.arange(64) / 64))


@dataclass(frozen=True)
class DisplacementWaves(WaveResponse):
    """Displacement of the surface that the half-space adds to that of the same layers on more of the deepest layer.

    Fields "xx", "xy" and "yy" are the displacements along the surface under traction, and "z" is that along the normal
    under pressure, all over ``(1 - nu1^2) / (pi E1)`` of the top layer. "x" and "y" are the normal displacement under
    traction along either axis, over ``1 / (4 pi G1)``. The closed form are the :attr:`LayerResponse.contrasts` times
    ``exp(-2 k)``: under long waves they make the displacement that of the half-space alone.

    Parameters
    ----------
    materials
        Materials and depths of their interfaces.
    load
        "pressure", or "traction" along the surface.
    """

    length_power: ClassVar[int] = 1
    decay_rate: ClassVar[float] = 2.0

    materials: LayerResponse
    load: str

    def parity(self, name: str) -> tuple[int, int]:
        """Return the parity of the field `name` in x and y."""
        return (1, 1) if name in ("yy", "z") else SURFACE[name].parity

    def swap_axes(self, name: str) -> tuple["DisplacementWaves", str]:
        """Return the response and the field that take the place of these when the axes are exchanged."""
        return self, SWAPPED.get(name, name)

    def harmonics(self, k: RealOrComplex) -> dict[str, dict[int, RealOrComplex]]:
        """Return all fields by name and number of turns, see :meth:`WaveResponse.harmonics`; they are 0 at k = 0."""
        return self._turned(k, self.remainders(k) + np.multiply.outer(self._contrasts, np.exp(-2 * k)))

    def short_harmonics(self, k: RealOrComplex) -> dict[str, dict[int, RealOrComplex]]:
        """Return the :meth:`harmonics` of the remainders alone."""
        return self._turned(k, self.remainders(k))

    def _turned(self, k: RealOrComplex, responses: RealOrComplex) -> dict[str, dict[int, RealOrComplex]]:
        """Return the fields of :meth:`harmonics` from `responses` (1 or 3, ...) in the order of the compliances."""
        # 1 / r has the transform 2 pi / k
        weighted = np.divide(2 * np.pi, k, out=np.zeros_like(k), where=k != 0) * responses
        if self.load == "pressure":
            return {"z": {0: weighted[0]}}
        along_wave, coupling, along_crests = weighted
        mean, turning = (along_wave + along_crests) / 2, (along_wave - along_crests) / 2
        return {
            "xx": {0: mean, 2: turning},
            "yy": {0: mean, 2: -turning},
            "xy": {2: turning},
            "x": {1: -1j * coupling},
            "y": {1: -1j * coupling},
        }

    @property
    def _of_load(self) -> slice:
        """Places of the responses to this load among the four of :meth:`LayerResponse.compliances`."""
        return slice(1) if self.load == "pressure" else slice(1, 4)

    @property
    def _contrasts(self) -> Array:
        """Factors of ``exp(-2 k)`` in the responses to this load (1 or 3,)."""
        return np.array(self.materials.contrasts[self._of_load])

    def direct_remainders(self, k: RealOrComplex) -> RealOrComplex:
        """Return the compliances of this load less those without the half-space, less the closed form (1 or 3, k)."""
        change = self._change(k)
        long = np.abs(k) < SERIES_END * self.materials.pole_distance_from_zero
        if long.any():
            change[:, long] = polynomial.polyval(k[long], self._series.T)
        return change

    def _change(self, k: RealOrComplex) -> RealOrComplex:
        """Return :meth:`direct_remainders` as differences, which lose digits to cancellation for long waves."""
        change = (self.materials.compliances(k) - self.materials.above.compliances(k))[self._of_load]
        return np.asarray(change - np.multiply.outer(self._contrasts, np.exp(-2 * k)))

    @cached_property
    def _series(self) -> Array:
        """Taylor coefficients (1 or 3, power) of the remainders at k = 0, where they are zero."""
        radius = self.materials.pole_distance_from_zero / 2
        terms = taylor_coefficients(self._change(circle(radius)), radius)[:, : SERIES_POWER + 1]
        terms[:, 0] = 0
        return terms


# The key of ``FAMILIES`` that takes the place of another when the axes are exchanged.
SWAPPED_LOADS = {"pressure": "pressure", "across": "along", "along": "across"}


def half_space(t: RealOrComplex, load: str) -> RealOrComplex:
    """Return the stress in a half-space at ``t = k z`` in the order of :meth:`StressWaves.stresses`."""
    e = np.exp(-t)
    if load == "pressure":
        return np.stack([-(1 + t) * e, -t * e, -(1 - t) * e])
    return np.stack([t * e, (t - 1) * e, (2 - t) * e, -e, e])


@dataclass(frozen=True)
class StressWaves(WaveResponse):
    """Stress at one depth under a wave of load, and its change by the layers.

    In the layers it is the change from the same layers on a half-space of the deepest layer's material, below them that
    from the half-space without layers. Its closed form in a layer is a change of the stresses along the surface, by
    strains at the depth of the point's mirror image in the deepest interface. It is the stress of this layer under the
    strain of the half-space there, less that under the strain of a half-space of the deepest layer's material. Below
    the layers there is no closed form. Fields are the components of stress over the load, such as "xz".

    Parameters
    ----------
    materials
        Materials and depths of their interfaces.
    depth
        Depth over that of the deepest interface, at least 0.
    load
        Load on the surface, a key of ``FAMILIES``.
    """

    length_power: ClassVar[int] = 0

    materials: LayerResponse
    depth: float
    load: str

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
        """Rate of decay of the remainders: the depth, of the mirror image in the deepest interface for a layer."""
        return 2 - self.depth if self.in_layer else self.depth

    def parity(self, name: str) -> tuple[int, int]:
        """Return the parity of the component `name` of stress in x and y."""
        return FAMILIES[self.load][name].parity

    def swap_axes(self, name: str) -> tuple["StressWaves", str]:
        """Return the response and the component that take the place of these when the axes are exchanged."""
        return replace(self, load=SWAPPED_LOADS[self.load]), BOUSSINESQ[name].swapped

    def harmonics(self, k: RealOrComplex) -> dict[str, dict[int, RealOrComplex]]:
        """Return the remainder of all components by name and number of turns, see :meth:`WaveResponse.harmonics`.

        In the names of stresses here l is the direction of the wave and t that of its crests.
        """
        if self.load == "along":
            # with the axes exchanged the angle t is pi/2 - t: cos 2 t, cos 3 t and sin 3 t change their sign
            return {
                BOUSSINESQ[name].swapped: {
                    m: -part if m == 3 or (m == 2 and name != "yz") else part for m, part in parts.items()
                }
                for name, parts in replace(self, load="across").harmonics(k).items()
            }
        normal, shear, s_ll, *along_crests = self.remainders(k)
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
        s_tz, s_lt = along_crests
        turning = (s_ll - s_tt) / 4 - s_lt / 2
        return {
            "xx": {1: 1j * (s_ll - turning), 3: 1j * turning},
            "yy": {1: 1j * (s_tt + turning), 3: -1j * turning},
            "zz": {1: 1j * normal},
            "yz": {2: (shear - s_tz) / 2},
            "xz": {0: (shear + s_tz) / 2, 2: (shear - s_tz) / 2},
            "xy": {1: 1j * (turning + s_lt), 3: 1j * turning},
        }

    def stresses(self, k: RealOrComplex) -> RealOrComplex:
        """Return the stress of the body under waves with real or imaginary numbers `k` (k,).

        Under a unit pressure it is (s_zz, s_xz, s_xx) (3, k). For the other loads (5, k) it is these three under a unit
        shear along the wave, then (s_yz, s_xy) under a unit shear along its crests. Stress is proportional to exp(i k
        x), and s_xy is divided by i. s_xx follows from s_zz and the strain along x: ``(1 - nu) s_xx = 2 G du/dx + nu
        s_zz``.
        """
        compliance, traction = self.materials.plane(k, self.depth)
        # the load at the surface is the stress -1
        traction = -traction[:, :, [0 if self.load == "pressure" else 1]]
        normal, shear = traction[:, :, 0].T
        strain = (compliance @ traction)[:, 0, 0]  # 2 G du/dx
        nu = self.poisson_ratio
        in_plane = [normal, shear, (strain + nu * normal) / (1 - nu)]
        if self.load == "pressure":
            return np.stack(in_plane)
        slope_over_shear, down = self.materials.antiplane(k, self.depth)
        return np.stack([*in_plane, -down, slope_over_shear * down])

    def direct_remainders(self, k: RealOrComplex) -> RealOrComplex:
        """Return the change of :meth:`stresses` by the layers, less its closed form (3 or 5, k)."""
        if not self.in_layer:
            return np.asarray(self.stresses(k) - half_space(k * self.depth, self.load))
        change = self.stresses(k) - replace(self, materials=self.materials.above).stresses(k)
        image = half_space(k * self.decay_rate, self.load)
        for sign, below in ((1, self.materials), (-1, self.materials.above)):
            shear_ratio, nu, nu_below = self.ratios(below)
            strain = shear_ratio * ((1 - nu_below) * image[2] - nu_below * image[0])
            change[2] -= sign * strain / (1 - nu)
            change[4:] -= sign * shear_ratio * image[4:]
        return np.asarray(change)

    def ratios(self, below: LayerResponse) -> tuple[float, float, float]:
        """Return the shear modulus here over that of a half-space `below`, and Poisson's ratios here and there."""
        own_ratio = self.materials.all_shear_ratios[self.materials.index(self.depth)]
        return below.all_shear_ratios[-1] / own_ratio, self.poisson_ratio, below.poisson_ratios[-1]

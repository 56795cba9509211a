"""Stress in a layer and in the half-space below it, under a wave of pressure and of tangential traction.

With the wave number k, ``t = k z`` and Airy's stress function ``f(t) cos(k x) / k^2``, a pressure ``P cos`` and a
traction ``Q sin`` along x give ``s_zz = -f cos``, ``s_xz = f' sin`` and ``s_xx = f'' cos``. Displacements and traction
are continuous at the interface. Two bases are used: exponentials from either face of the layer, and for long waves,
where these become alike, the matrix exponential of the state (2 G k U, 2 G k V, s_zz, s_xz).

Source: plane strain of a bonded layer (Burmister 1945; Johnson 1985, sect. 5.8), with shear on its surface.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.layer.response import LayerResponse, RealOrComplex

# Wave number times thickness up to which the matrix exponential is used.
LONG_WAVE = 1.5
# Spline through the remainder, which decays as exp(-r k): largest r k of a piece, points on each, degree, and last r k,
# that of a wave with 34, where it is below rounding, along either axis.
SPLINE_PIECE, SPLINE_POINTS, SPLINE_DEGREE, LAST_STRESS_WAVE = 0.5, 48, 7, 49.0


def half_space(t: RealOrComplex) -> tuple[tuple[RealOrComplex, RealOrComplex, RealOrComplex], ...]:
    """Return (s_zz, s_xz, s_xx) in a half-space at ``t = k z``, under a unit pressure and under a unit shear."""
    e = np.exp(-t)
    return (-(1 + t) * e, -t * e, -(1 - t) * e), (t * e, (t - 1) * e, (2 - t) * e)


@dataclass(frozen=True)
class LayerStress:
    """Stress under a wave, at one depth.

    Parameters
    ----------
    materials
        Ratio of the moduli and Poisson's ratios.
    depth
        Depth over the thickness of the layer, at least 0.
    """

    materials: LayerResponse
    depth: float

    @property
    def in_layer(self) -> bool:
        """True if the depth is in the layer, to which the interface belongs."""
        return self.depth <= 1

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio of the material at this depth."""
        both = self.materials.coating_poisson_ratio, self.materials.substrate_poisson_ratio
        return both[0] if self.in_layer else both[1]

    @property
    def decay_rate(self) -> float:
        """Rate, per wave number times thickness, at which a remainder decays: exp(-k `decay_rate`)."""
        return 2 - self.depth if self.in_layer else self.depth

    def plane(self, k: RealOrComplex) -> RealOrComplex:
        """Return (s_zz, s_xz, s_xx) under a unit pressure and a unit shear (load, component, k).

        `k` is the wave number times the thickness, on the real or the imaginary axis.
        """
        result: RealOrComplex = np.empty((2, 3, k.size), dtype=np.result_type(k, float))
        long = np.abs(k) <= LONG_WAVE
        for chosen, solve in ((long, self._by_state), (~long, self._by_exponentials)):
            if chosen.any():
                result[:, :, chosen] = solve(k[chosen])
        return result

    def remainder(self, k: RealOrComplex) -> RealOrComplex:
        """Return :meth:`plane` less what is known in closed form: zero at k = 0, decaying as exp(-k `decay_rate`).

        In the layer the closed form is the stress in a half-space of its material, and a change of s_xx at the depth
        of the point mirrored in the interface, from the stress there to that of the layer under the substrate's strain.
        Below the layer it is the stress in a half-space of the substrate.
        """
        remainder: RealOrComplex = self.plane(k) - np.array(half_space(k * self.depth))
        if self.in_layer:
            at_mirror_image = np.array(half_space(k * self.decay_rate))
            remainder[:, 2] -= (
                self.strained(at_mirror_image[:, 0], at_mirror_image[:, 2]) - at_mirror_image[:, 2]
            )
        return remainder

    def strained(self, normal: RealOrComplex, across: RealOrComplex) -> RealOrComplex:
        """Return s_xx of the layer under the strain of the substrate, whose s_zz and s_xx are `normal` and `across`."""
        ratio, nu1, nu2 = self._ratios
        below = ratio * ((1 - nu2) * across - nu2 * normal)
        return np.asarray((below + nu1 * normal) / (1 - nu1))

    def antiplane(self, k: RealOrComplex) -> tuple[RealOrComplex, RealOrComplex]:
        """Return the shear stresses along the crests by a unit shear along them, less those of a half-space.

        With the stress proportional to exp(i k x) and y along the crests, they are s_yz and the imaginary part of s_xy.
        """
        ratio = self._ratios[0]
        mismatch = (ratio - 1) / (ratio + 1)
        image_sum = 1 / (1 - mismatch * np.exp(-2 * k))
        decay = np.exp(-k * self.depth)
        if not self.in_layer:
            through = (1 - mismatch) * image_sum
            return (1 - through) * decay, (through - 1) * decay
        mirrored = np.exp(-k * self.decay_rate)
        down, up = image_sum * decay, mismatch * image_sum * mirrored
        return decay - down + up, down + up - decay - (ratio - 1) * mirrored

    def interpolated(self, k: Array) -> Array:
        """Return :meth:`remainder` at real `k` of any shape, by a spline made once up to ``r k = LAST_STRESS_WAVE``."""
        values = np.asarray(_table(self)(k.ravel())).T
        return np.asarray(values.reshape(2, 3, *k.shape))

    @property
    def _ratios(self) -> tuple[float, float, float]:
        """Ratio of the shear moduli, and Poisson's ratios of the layer and of the substrate."""
        layer = self.materials
        return layer.shear_ratio, layer.coating_poisson_ratio, layer.substrate_poisson_ratio

    def _by_exponentials(self, k: RealOrComplex) -> RealOrComplex:
        """Return the stress of short waves, from ``exp(-t), t exp(-t)`` and the same from the interface."""
        ratio, nu1, nu2 = self._ratios
        unity, none = np.ones_like(k), np.zeros_like(k)
        top = _decaying(none), _reversed(_decaying(k))
        interface = _decaying(k), _reversed(_decaying(none))
        surface, faces = np.concatenate(top), np.concatenate(interface)
        below = ratio * _displacements(_decaying(none), nu2)
        rows = np.zeros((k.size, 6, 6), dtype=k.dtype)
        rows[:, 0, :4], rows[:, 1, :4] = surface[:, 0].T, surface[:, 1].T
        for row in (0, 1):
            rows[:, 2 + row, :4] = faces[:, row].T
            rows[:, 2 + row, 4:] = -_decaying(none)[:, row].T
            rows[:, 4 + row, :4] = _displacements(faces, nu1)[:, row].T
            rows[:, 4 + row, 4:] = -below[:, row].T
        # rows of very unlike materials
        rows[:, 4:] /= 1 + ratio
        loads = np.zeros((k.size, 6, 2), dtype=k.dtype)
        loads[:, 0, 0], loads[:, 1, 1] = unity, -unity
        weights = np.linalg.solve(rows, loads)
        if self.in_layer:
            stresses = np.concatenate(
                [_decaying(k * self.depth), _reversed(_decaying(k * (1 - self.depth)))]
            )
            return _stress(stresses, weights[:, :4])
        return _stress(_decaying(k * (self.depth - 1)), weights[:, 4:])

    def _by_state(self, k: RealOrComplex) -> RealOrComplex:
        """Return the stress of long waves, from the state at the surface carried through the layer."""
        ratio, nu1, nu2 = self._ratios
        below = _decaying(np.zeros_like(k))
        displaced = ratio * _displacements(below, nu2)
        through = self._transfer(k)
        rows = np.zeros((k.size, 4, 4), dtype=k.dtype)
        rows[:, :, :2] = through[:, :, :2]
        rows[:, 0, 2:], rows[:, 1, 2:] = -displaced[:, 0].T, -displaced[:, 1].T
        rows[:, 2, 2:], rows[:, 3, 2:] = below[:, 0].T, -below[:, 1].T
        # the stress at the surface is known: -P and -Q
        right_side = -np.eye(2)
        unknown = np.linalg.solve(rows, -through[:, :, 2:] @ right_side)
        if not self.in_layer:
            return _stress(_decaying(k * (self.depth - 1)), unknown[:, 2:])
        surface = np.concatenate(
            [unknown[:, :2], np.broadcast_to(right_side, (k.size, 2, 2)).astype(k.dtype)], axis=1
        )
        along, _, normal, shear = np.moveaxis(self._transfer(k * self.depth) @ surface, 1, 0)
        across = (along + nu1 * normal) / (1 - nu1)
        return np.stack([normal.T, shear.T, across.T], axis=1)

    def _transfer(self, t: RealOrComplex) -> RealOrComplex:
        """Return the exponential of t times the derivative of the layer's state (t, 4, 4)."""
        nu = self._ratios[1]
        rate = np.array(
            [[0, 1, 0, 2], [-nu, 0, 1 - 2 * nu, 0], [0, 0, 0, -1], [1, 0, nu, 0]], dtype=float
        )
        rate[[1, 3]] /= 1 - nu
        cosh, sinh = np.cosh(t), np.sinh(t)
        terms = cosh - t * sinh / 2, (3 * sinh - t * cosh) / 2, t * sinh / 2, (t * cosh - sinh) / 2
        powers = [np.linalg.matrix_power(rate, n) for n in range(4)]
        return np.asarray(
            sum(np.multiply.outer(term, power) for term, power in zip(terms, powers, strict=True))
        )


def _decaying(t: RealOrComplex) -> RealOrComplex:
    """Return f, f', f'' and f''' (function, derivative, t) of ``exp(-t)`` and ``t exp(-t)``."""
    e = np.exp(-t)
    return np.array([[e, -e, e, -e], [t * e, (1 - t) * e, (t - 2) * e, (3 - t) * e]])


def _reversed(functions: RealOrComplex) -> RealOrComplex:
    """Return functions of a distance that falls with t: odd derivatives change their sign."""
    return np.asarray(functions * np.array([1, -1, 1, -1])[:, None])


def _displacements(functions: RealOrComplex, nu: float) -> RealOrComplex:
    """Return ``2 G k U`` and ``2 G k V`` (function, displacement, t) of Airy's stress functions."""
    value, first, second, third = np.moveaxis(functions, 1, 0)
    return np.stack([(1 - nu) * second + nu * value, (1 - nu) * third + (nu - 2) * first], axis=1)


def _stress(functions: RealOrComplex, weights: RealOrComplex) -> RealOrComplex:
    """Return (s_zz, s_xz, s_xx) (load, component, t) of a sum of `functions` with `weights` (t, function, load)."""
    value, first, second = (
        np.einsum("ft,tfl->lt", functions[:, order], weights) for order in (0, 1, 2)
    )
    return np.stack([-value, first, second], axis=1)


@lru_cache(maxsize=64)
def _table(stress: LayerStress) -> BSpline:
    """Return the remainder as a spline (load and component) of the wave number."""
    longest = SPLINE_PIECE / max(stress.decay_rate, 2)
    ends = [0.0, min(stress.materials.pole_distance_from_zero / 2, longest)]
    while ends[-1] * stress.decay_rate < LAST_STRESS_WAVE:
        ends.append(ends[-1] + min(ends[-1], longest))
    k = np.concatenate(
        [np.arange(SPLINE_POINTS) / SPLINE_POINTS * (end - at) + at for at, end in pairwise(ends)]
    )
    k = np.append(k, ends[-1])
    return make_interp_spline(k, stress.remainder(k).reshape(6, -1).T, SPLINE_DEGREE)

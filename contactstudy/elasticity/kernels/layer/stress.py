"""Stress in layers and in the half-space below them, under a wave of pressure and of tangential traction.

With the wave number k, ``t = k z`` and Airy's stress function ``f(t) cos(k x) / k^2``, a pressure ``P cos`` and a
traction ``Q sin`` along x give ``s_zz = -f cos``, ``s_xz = f' sin`` and ``s_xx = f'' cos``.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import PPoly

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.layer.response import LayerResponse, RealOrComplex, spline

# Last wave number of the spline through the remainder, times the rate at which that decays. A wave with 34 along each
# axis, where the remainder is below rounding, has 48 in all.
LAST_STRESS_WAVE = 49.0
# Wave numbers beyond which that spline is made: more than the integral over the waves of a strip takes. On a lattice it
# is always made, since many sums read it.
MAX_DIRECT = 2**13


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

        `k` is the wave number times the depth of the deepest interface, on the real or the imaginary axis.
        """
        return _plane(self.materials, self.depth, k)

    def remainder(self, k: RealOrComplex) -> RealOrComplex:
        """Return the change of :meth:`plane` less what is known in closed form.

        It is zero at k = 0, and decays as exp(-k `decay_rate`). In a layer the closed form is a change of s_xx alone,
        taken at the depth of the point's mirror image in the deepest interface: the stress of this layer under the
        strain of the half-space there, less that under the strain of one of the deepest layer's material. Values at
        many real `k`, up to LAST_STRESS_WAVE over the decay rate, and at those of a lattice (across, along) are read
        off a spline.
        """
        if (k.ndim > 1 or k.size > MAX_DIRECT) and not np.iscomplexobj(k):
            values = np.asarray(np.moveaxis(_spline(self)(k), -1, 0))
        else:
            values = self._remainder(k.ravel())
        return values.reshape(2, 3, *k.shape)

    def _remainder(self, k: RealOrComplex) -> RealOrComplex:
        """Return :meth:`remainder` at wave numbers `k` (k,)."""
        if not self.in_layer:
            return np.asarray(self.plane(k) - np.array(half_space(k * self.depth)))
        above, image = self.materials.above, np.array(half_space(k * self.decay_rate))
        change: RealOrComplex = self.plane(k) - _plane(above, self.depth, k)
        for sign, below in ((1, self.materials), (-1, above)):
            change[:, 2] = change[:, 2] - sign * self._strained(below, image[:, 0], image[:, 2])
        return change

    def ratios(self, below: LayerResponse) -> tuple[float, float, float]:
        """Return the shear modulus here over that of a half-space `below`, and Poisson's ratios here and there."""
        here = self.materials.all_shear_ratios[self.materials.index(self.depth)]
        ratio = below.all_shear_ratios[-1] / here
        return ratio, self.poisson_ratio, below.poisson_ratios[-1]

    def _strained(self, below: LayerResponse, normal: RealOrComplex, across: RealOrComplex) -> RealOrComplex:
        """Return s_xx here under the strain of a half-space `below`, whose s_zz and s_xx are `normal` and `across`."""
        ratio, nu1, nu2 = self.ratios(below)
        strain = ratio * ((1 - nu2) * across - nu2 * normal)
        return np.asarray((strain + nu1 * normal) / (1 - nu1))

    def antiplane(self, k: RealOrComplex) -> tuple[RealOrComplex, RealOrComplex]:
        """Return the remainder, as :meth:`remainder`, of the shear stresses along the crests under a unit shear there.

        With the stress proportional to exp(i k x) and y along the crests, they are s_yz and the imaginary part of s_xy.
        """
        down, around = _antiplane(self.materials, self.depth, k)
        if not self.in_layer:
            decay = np.exp(-k * self.depth)
            return decay - down, around - decay
        without = _antiplane(self.materials.above, self.depth, k)
        contrast = self.ratios(self.materials)[0] - self.ratios(self.materials.above)[0]
        return without[0] - down, around - without[1] - contrast * np.exp(-k * self.decay_rate)


def _plane(materials: LayerResponse, depth: float, k: RealOrComplex) -> RealOrComplex:
    """Return (s_zz, s_xz, s_xx) under a unit pressure and a unit shear (load, component, k).

    s_xx follows from s_zz and the strain along x: ``(1 - nu) s_xx = 2 G du/dx + nu s_zz``.
    """
    compliance, traction = materials.plane(k, depth)
    nu = materials.poisson_ratios[materials.index(depth)]
    # the stress at the surface is -P and -Q
    normal, shear = -np.moveaxis(traction, 0, -1)
    strain = -np.moveaxis(compliance @ traction, 0, -1)[0]  # 2 G du/dx
    return np.stack([normal, shear, (strain + nu * normal) / (1 - nu)], axis=1)


def _antiplane(materials: LayerResponse, depth: float, k: RealOrComplex) -> tuple[RealOrComplex, RealOrComplex]:
    """Return the shear along the crests over that at the surface, and G times the slope of the displacement."""
    compliance, traction = materials.antiplane(k, depth)
    return traction, compliance * traction


@lru_cache(maxsize=64)
def _spline(stress: LayerStress) -> PPoly:
    """Return the remainder as a spline (load and component) of the wave number."""

    def remainder(k: Array) -> RealOrComplex:
        blocks = np.array_split(k, 1 + k.size // MAX_DIRECT)
        return np.concatenate([stress.remainder(block) for block in blocks], axis=2)

    first = stress.materials.pole_distance_from_zero / 2
    return spline(remainder, first, LAST_STRESS_WAVE / stress.decay_rate)

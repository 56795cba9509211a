"""Waves of the short-ranged remainder of the stress in a coated half-space."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.layer.response import LayerResponse, RealOrComplex
from contactstudy.elasticity.kernels.layer.stress import LayerStress
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS, CellKernel
from contactstudy.elasticity.kernels.traction import CERRUTI_ACROSS, CERRUTI_ALONG

# Components of stress by the load on the surface: pressure, shear across, shear along.
FAMILIES: Mapping[str, Mapping[str, CellKernel]] = {
    "pressure": COMPONENTS,
    "across": CERRUTI_ACROSS,
    "along": CERRUTI_ALONG,
}
SWAPPED_LOADS = {"pressure": "pressure", "across": "along", "along": "across"}


@dataclass(frozen=True)
class StressWaves:
    """Remainder of the stress in a layered body under one wave of a load on its surface.

    Its part of a homogeneous body is subtracted, as in
    :meth:`~contactstudy.elasticity.kernels.layer.stress.LayerStress.remainder`. In names of stresses l is the direction
    of the wave, t that of its crests.

    Parameters
    ----------
    stress
        Stress under one wave at a depth.
    load
        Load on the surface, of ``FAMILIES``.
    """

    stress: LayerStress
    load: str

    @property
    def decay_rate(self) -> float:
        """Rate, per wave number times thickness, at which the remainder decays."""
        return self.stress.decay_rate

    @property
    def materials(self) -> LayerResponse:
        """Ratio of the moduli and Poisson's ratios."""
        return self.stress.materials

    def parity(self, name: str) -> tuple[int, int]:
        """Return the parity of a component of stress in x and y."""
        return FAMILIES[self.load][name].parity

    def swap_axes(self, name: str) -> tuple["StressWaves", str]:
        """Return the response and the component that take the place of these when the axes are exchanged."""
        return StressWaves(self.stress, SWAPPED_LOADS[self.load]), COMPONENTS[name].swapped

    def plane_amplitudes(self, k: RealOrComplex) -> dict[str, RealOrComplex]:
        """Return the stresses over the load, by name, under waves across with wave numbers `k`, real or imaginary."""
        if self.load == "along":
            s_tz, s_lt = self.stress.antiplane(k)
            return {"yz": s_tz + 0j, "xy": 1j * s_lt}
        factor = 1 if self.load == "pressure" else 1j
        loaded = self.stress.remainder(k)[0 if self.load == "pressure" else 1]
        normal, shear, across = factor * loaded + 0j
        transverse = self.stress.poisson_ratio * (normal + across)
        return {"xx": across, "yy": transverse, "zz": normal, "xz": -1j * shear}

    def amplitudes(self, across: Array, along: Array) -> dict[str, Array]:
        """Return all components of the remainder over the load, by name, under waves (across, along)."""
        size = np.hypot(across, along)
        with np.errstate(invalid="ignore"):
            c = np.where(size > 0, across / size, 1.0)
            s = np.where(size > 0, along / size, 0.0)
        pressed, sheared = self.stress.interpolated(size)
        s_tz: RealOrComplex
        s_lt: RealOrComplex
        if self.load == "pressure":
            normal, shear, s_ll = pressed[0], -1j * pressed[1], pressed[2]
            s_tz = s_lt = np.zeros_like(size)
        else:
            part, transverse = (c, -s) if self.load == "across" else (s, c)
            normal, shear = 1j * part * sheared[0], part * sheared[1]
            s_ll = 1j * part * sheared[2]
            down, around = self.stress.antiplane(size)
            s_tz, s_lt = transverse * down, 1j * transverse * around
        s_tt = self.stress.poisson_ratio * (s_ll + normal)
        return {
            "xx": c * c * s_ll + s * s * s_tt - 2 * c * s * s_lt,
            "yy": s * s * s_ll + c * c * s_tt + 2 * c * s * s_lt,
            "zz": normal,
            "yz": s * shear + c * s_tz,
            "xz": c * shear - s * s_tz,
            "xy": c * s * (s_ll - s_tt) + (c * c - s * s) * s_lt,
        }

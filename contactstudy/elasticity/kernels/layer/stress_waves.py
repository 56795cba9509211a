"""Waves of the short-ranged remainder of the stress in a coated half-space."""

from collections.abc import Mapping
from dataclasses import dataclass

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

    def harmonics(self, k: RealOrComplex) -> dict[str, dict[int, RealOrComplex]]:
        """Return the components of the remainder by name and number of turns, see :class:`WaveResponse`."""
        if self.load == "along":
            return {
                COMPONENTS[name].swapped: {
                    m: -part if m == 3 or (m == 2 and name != "yz") else part for m, part in parts.items()
                }
                for name, parts in StressWaves(self.stress, "across").harmonics(k).items()
            }
        normal, shear, s_ll = self.stress.remainder(k)[0 if self.load == "pressure" else 1]
        s_tt = self.stress.poisson_ratio * (s_ll + normal)
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
        down, around = self.stress.antiplane(k)
        turning = (s_ll - s_tt) / 4 - around / 2
        return {
            "xx": {1: 1j * (s_ll - turning), 3: 1j * turning},
            "yy": {1: 1j * (s_tt + turning), 3: -1j * turning},
            "zz": {1: 1j * normal},
            "yz": {2: (shear - down) / 2},
            "xz": {0: (shear + down) / 2, 2: (shear - down) / 2},
            "xy": {1: 1j * (turning + around), 3: 1j * turning},
        }

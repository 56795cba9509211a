"""Displacement of a layered surface under waves of load, less that of a half-space of the material of the layer."""

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

import numpy as np

from contactstudy.elasticity.kernels.layer.response import LayerResponse, RealOrComplex
from contactstudy.elasticity.kernels.traction import SURFACE, SWAPPED


class Subtracted(Enum):
    """Whether ``contrast exp(-2 k)`` is subtracted from a response, with k = wave number times thickness.

    The contrast is the value of the response for long waves, which see the substrate alone.
    """

    #: It is left in: the whole response.
    NONE = 0
    #: It is subtracted, so that the remainder of waves across is regular.
    LONG_WAVES = 1


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
    subtracted
        What is left out for long waves, as it is known in closed form.
    load
        "pressure", or "traction" along the surface.
    """

    #: Rate, per wave number times thickness, at which amplitudes decay: exp(-2 k).
    decay_rate: ClassVar[float] = 2.0

    materials: LayerResponse
    subtracted: Subtracted
    load: str

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
        """Return responses, less those of a half-space, of `which` of the four in the order of :func:`contrasts`."""
        units = np.array([1, 1, 1, 1 - self.materials.poisson_ratios[0]])[which]
        remainders = self.materials.remainders(k, which)
        if self.subtracted is Subtracted.NONE:
            known = np.array(self.materials.contrasts)[which]
            remainders = remainders + np.multiply.outer(known, np.exp(-2 * k))
        return np.asarray(remainders / units.reshape(-1, *[1] * k.ndim))


def contrasts(materials: LayerResponse) -> tuple[float, float, float, float]:
    """Return the values of a layered response for long waves, over the compliances of :class:`DisplacementWaves`.

    They are of pressure, of shear along the wave, of their coupling, and of shear across the wave.
    """
    normal, along, coupling, across = materials.contrasts
    return normal, along, coupling, across / (1 - materials.poisson_ratios[0])

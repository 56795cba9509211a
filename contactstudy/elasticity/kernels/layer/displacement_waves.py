"""Displacement of a layered surface under waves of pressure and traction, less that without the half-space."""

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.layer.response import LayerResponse, RealOrComplex
from contactstudy.elasticity.kernels.stress_cell import (
    CellKernel,
    second_derivative_log,
    stress_cell,
)
from contactstudy.elasticity.kernels.traction import SURFACE, SWAPPED


class Subtracted(Enum):
    """Part of long waves, ``contrast exp(-2 k)``, that is subtracted from a response."""

    #: None: the whole response.
    NONE = 0
    #: All of it, so that the remainder of waves across is regular.
    FIRST = 1


@dataclass(frozen=True)
class DisplacementWaves:
    """Displacement under a wave of load that the half-space below a layer adds to that of the layer's.

    Fields "xx", "xy" and "yy" are the displacements along the surface under traction, and "z" is that along the normal
    under pressure, over ``(1 - nu1^2) / (pi E1)``; "x" and "y" are the normal displacement under traction along either
    axis, over ``1 / (4 pi G1)``; all in thicknesses.

    Parameters
    ----------
    materials
        Materials and depths of their interfaces.
    subtracted
        Terms of long waves that are left out, as they are known in closed form.
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

    def plane_amplitudes(self, k: RealOrComplex) -> dict[str, RealOrComplex]:
        """Return the fields, by name, under waves across with wave numbers `k`, real or imaginary."""
        pressed, along, coupling, across = (
            2 * np.pi / k * part + 0j for part in self._responses(k)
        )
        if self.load == "pressure":
            return {"z": pressed}
        return {"xx": along, "yy": across, "x": -1j * coupling}

    def amplitudes(self, across: Array, along: Array) -> dict[str, Array]:
        """Return all fields, by name, under waves (across, along); none for the mean."""
        size = np.hypot(across, along)
        weight = np.divide(2 * np.pi, size, out=np.zeros_like(size), where=size > 0)
        pressed, longitudinal, coupling, transverse = (
            weight * part for part in self._responses(size)
        )
        if self.load == "pressure":
            return {"z": np.real(pressed)}
        c, s = (part * weight / (2 * np.pi) for part in (across, along))
        return {
            "xx": c * c * longitudinal + s * s * transverse,
            "yy": s * s * longitudinal + c * c * transverse,
            "xy": c * s * (longitudinal - transverse),
            "x": -1j * c * coupling,
            "y": -1j * s * coupling,
        }

    def _responses(self, k: RealOrComplex) -> list[RealOrComplex]:
        """Return the responses in the order of :func:`contrasts`, less those of a half-space."""
        normal, along, coupling, across = self.materials.remainders(k)
        remainders = normal, along, coupling, across / (1 - self.materials.poisson_ratios[0])
        if self.subtracted is Subtracted.FIRST:
            return list(remainders)
        decay = np.exp(-2 * k)
        known = contrasts(self.materials)
        return [rest + first * decay for rest, first in zip(remainders, known, strict=True)]


def contrasts(materials: LayerResponse) -> tuple[float, float, float, float]:
    """Return the `contrasts` of a response over the compliances of :class:`DisplacementWaves`.

    They are of pressure, of shear along the wave, of their coupling, and of shear across the wave.
    """
    normal, along, coupling, across = materials.contrasts
    return normal, along, coupling, across / (1 - materials.poisson_ratios[0])


# Potentials of a cell at a distance z from its plane, whose spectra are 2 pi exp(-q z) times the name of each:
# the integrals over x and y of the derivatives of z ln(r + z) - r and of ln(r + z).
def _xx_corner(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the integral of the field ``qx^2 / q^3``."""
    asinh = np.arcsinh(y / np.hypot(x, z))
    return np.asarray(x * asinh - z * second_derivative_log(x, y, z, r))


def _x_corner(x: Array, y: Array, z: float, r: Array, nu: float) -> Array:
    """Return the integral of the field ``-i qx / q^2``."""
    asinh = np.arcsinh(y / np.hypot(x, z))
    return np.asarray(y * np.log(r + z) + x * second_derivative_log(x, y, z, r) + z * asinh)


# By field, of a point and of a corner: the buried term of shear along waves; across them x and y are swapped.
BURIED_FIELDS = {
    name: CellKernel(name, parity, point, corner, lambda strip, nu: 0.0, name)
    for name, parity, point, corner in (
        # qx^2 / q^3
        ("xx", (1, 1), lambda x, y, z, r, nu: 1 / (r + z) - x * x / (r * (r + z) ** 2), _xx_corner),
        # qx qy / q^3
        (
            "xy", (-1, -1),
            lambda x, y, z, r, nu: -x * y / (r * (r + z) ** 2),
            lambda x, y, z, r, nu: r - z * np.log(r + z),
        ),
        # -i qx / q^2
        ("x", (-1, 1), lambda x, y, z, r, nu: x / (r * (r + z)), _x_corner),
    )
}  # fmt: skip


def buried_field(name: str, x: Array, y: Array, dx: float, dy: float, depth: float) -> Array:
    """Return the integral of the field `name` over a cell buried at a `depth`."""
    if name not in BURIED_FIELDS:
        x, y, dx, dy, name = y, x, dy, dx, SWAPPED[name]
    return 2 * np.pi * stress_cell(BURIED_FIELDS[name], x, y, depth, dx, dy, 0.0)

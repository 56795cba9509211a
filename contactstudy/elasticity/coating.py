"""Layers on the surface: influence coefficients that a bonded layer adds, and a Winkler layer in series with bodies.

A bonded layer deforms with its substrate as one elastic body (:class:`CoatingCoefficients`). Each cell of a Winkler
layer yields to its own pressure alone (:class:`WithWinklerLayer`).
"""

from dataclasses import dataclass
from math import log

import numpy as np
from scipy.special import log1p

from contactstudy.domain.device import Precision
from contactstudy.domain.grid import Array, on_cells
from contactstudy.elasticity.approximate_inverse import FreeEndsInverse, SpectralInverse
from contactstudy.elasticity.convolution import Convolution, weighted_sum
from contactstudy.elasticity.kernels.layer_waves import WaveCoefficients, field_of_line


@dataclass(frozen=True, eq=False)
class WithWinklerLayer:
    """Linear map from pressure (x, y) to displacement (x, y), ``K * pressure + compliance pressure``.

    Parameters
    ----------
    convolution
        Map from pressure to the displacement of the bodies, a convolution with their coefficients K.
    compliance
        Displacement of each cell over its own pressure (x, y) [m/Pa], at least 0.
    """

    convolution: Convolution
    compliance: Array

    def __call__(self, pressure: Array) -> Array:
        """Return the displacement (x, y) under a `pressure` (x, y)."""
        displacement = self.convolution(pressure)
        displacement += self.compliance * pressure
        return displacement

    @property
    def transform_size(self) -> float:
        """Number of cells of the padded grid, transformed in one application."""
        return self.convolution.transform_size

    @property
    def self_compliance(self) -> float:
        """Displacement [m/Pa] of the most compliant cell under unit pressure on it.

        That of the bodies is relative to its mean over the padded grid, which is a rigid motion.
        """
        return self.convolution.self_compliance + float(self.compliance.max())

    @property
    def blocks(self) -> tuple[int, int]:
        """Number of cells (across, along) that are merged on a coarser grid."""
        return self.convolution.blocks

    def scaled(self, factor: float, precision: Precision) -> "WithWinklerLayer":
        """Return this operator times `factor`, in `precision`."""
        layer = (self.compliance * factor).astype(precision.real)
        return WithWinklerLayer(self.convolution.scaled(factor, precision), layer)

    def coarsened(self) -> "WithWinklerLayer":
        """Return the operator on larger cells: mean displacement of blocks under a pressure constant in each."""
        convolution = self.convolution.coarsened()
        return WithWinklerLayer(convolution, on_cells(self.compliance, convolution.cells))

    def approximate_inverse(self, precision: Precision | None = None) -> SpectralInverse | FreeEndsInverse:
        """Return the preconditioner of the operator with the mean compliance in all cells."""
        return weighted_sum([(1.0, self.convolution)], float(self.compliance.mean())).approximate_inverse(precision)


@dataclass(frozen=True)
class CoatingCoefficients(WaveCoefficients):
    """Influence coefficients [m] that a bonded layer adds to those of a half-space of its own material.

    They are one field of :class:`~contactstudy.elasticity.kernels.layer_response.DisplacementWaves`. For a strip its
    closed form is the field of a line that is buried at two thicknesses.

    Parameters
    ----------
    waves, thickness, name
        Response of the layer, its thickness [m], and the name of the field: "z" is displacement along the normal under
        pressure, "x" and "y" that under traction along either axis; "xx", "xy" and "yy" are along the surface.
    datum
        Distance [m] as in :class:`~contactstudy.elasticity.convolution.BoussinesqCoefficients`.
    """

    datum: float

    def strip(self, x: Array, dx: float) -> Array:
        """Return the response (x,) to a strip of width `dx`, infinite along y, at offsets `x` (x,).

        The logarithms and arctangents are the closed form, integrated over the strip; the base class has the remainder.
        """
        depth, remainder = 2 * self.thickness, super().strip(x, dx)
        if self.name == "x":
            coupling = self.waves.materials.contrasts[2]
            upper, lower = (
                edge * np.arctan(edge / depth) - depth / 2 * np.log(edge**2 + depth**2)
                for edge in (x + dx / 2, x - dx / 2)
            )
            return np.asarray(remainder + 2 * coupling * (upper - lower))
        return np.asarray(remainder - dx * self._contrast * _log_mean(np.abs(x), dx / 2, depth) + self.rigid_shift(dx))

    @property
    def _contrast(self) -> float:
        """Factor of ``-ln(x^2 + 4 h^2)`` in the displacement at x from a line, with the thickness h; 0 of odd fields."""
        pressed, along_wave, _, along_crests = self.waves.materials.contrasts
        return {"xx": along_wave, "yy": along_crests, "z": pressed}.get(self.name, 0.0)

    def rigid_shift(self, line: float) -> float:
        """Return what the datum adds to the response to a row of images, each with the area `line` times the period.

        The surface does not move at the datum under a load on a line. Fields that are odd along an axis have none: 0.
        """
        if self.name not in ("xx", "yy", "z"):
            return 0.0
        remainder = field_of_line(self.waves).at(self.name, self.datum / self.thickness)
        return line * (self._contrast * log(self.datum**2 + 4 * self.thickness**2) - remainder)


def _log_mean(x: Array, half: float, depth: float) -> Array:
    """Return the mean of ``ln(x^2 + depth^2)`` over segments of half-length `half` about each x."""
    place = x + 1j * depth
    t = half / place
    ends = (1 + t) * log1p(t) - (1 - t) * log1p(-t)
    return np.asarray(2 * np.real(np.log(place) - 1 + ends / (2 * t)))

"""Influence coefficients that a bonded layer adds, and an operator in series with a Winkler layer."""

from dataclasses import dataclass, replace
from math import log

import numpy as np
from scipy.special import log1p

from contactstudy.domain.device import Precision
from contactstudy.domain.grid import Array, on_cells
from contactstudy.elasticity.approximate_inverse import ExactInverse, FreeEndsInverse, SpectralInverse
from contactstudy.elasticity.convolution import Convolution, weighted_sum
from contactstudy.elasticity.kernels.layer_response import LayerResponse
from contactstudy.elasticity.kernels.layer_waves import DisplacementWaves, WaveCoefficients
from contactstudy.elasticity.kernels.stress import SWAPPED


@dataclass(frozen=True, eq=False)
class WithWinklerLayer:
    """Linear map from pressure to displacement, ``K * pressure + compliance pressure``.

    Parameters
    ----------
    convolution
        Displacement of the bodies, K.
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
        """Displacement of the most compliant cell by its own unit pressure; that of the half-space above the mean."""
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

    def approximate_inverse(
        self, precision: Precision | None = None
    ) -> SpectralInverse | FreeEndsInverse | ExactInverse:
        """Return a preconditioner: the exact inverse of few cells, else that with a layer of the mean compliance."""
        layer = float(self.compliance.mean())
        inverse = weighted_sum([(1.0, self.convolution)], layer).approximate_inverse(precision)
        if isinstance(inverse, ExactInverse):
            return ExactInverse(inverse.compliance + np.diag(self.compliance.ravel() - layer))
        return inverse


# Width over its distance of a strip that stands for a line.
LINE = 1e-4


@dataclass(frozen=True)
class CoatingCoefficients:
    """Influence coefficients [m] that a bonded layer adds to those of a half-space of its own material.

    Under long waves the displacement is that of a half-space of the substrate. A row's mean has these waves in closed
    form, as those of lines buried at two thicknesses; all else is found from the
    :class:`~contactstudy.elasticity.kernels.layer_waves.DisplacementWaves`.

    Parameters
    ----------
    response
        Ratio of the moduli and Poisson's ratios.
    thickness
        Thickness of the layer [m].
    name
        "xx", "xy" or "yy" for displacement along one axis under traction along another, "x" or "y" for displacement
        along the normal under traction along that axis, "z" along the normal under pressure.
    datum
        Distance [m] as in :class:`~contactstudy.elasticity.convolution.BoussinesqCoefficients`.
    """

    response: LayerResponse
    thickness: float
    name: str
    datum: float

    @property
    def parity(self) -> tuple[int, int]:
        """Parity along each axis."""
        return self._waves().parity

    def swap_axes(self) -> "CoatingCoefficients":
        """Return the field with x and y exchanged."""
        return replace(self, name=SWAPPED.get(self.name, self.name))

    def _waves(self, *, has_long_waves: bool = True) -> WaveCoefficients:
        """Return the sums of waves of the response."""
        load = "pressure" if self.name == "z" else "traction"
        return WaveCoefficients(DisplacementWaves(self.response, load, has_long_waves), self.thickness, self.name)

    def _remainder(self, x: Array, dx: float) -> Array:
        """Return the response to a strip as :meth:`_strip`, without that to long waves."""
        return self.thickness * self._waves(has_long_waves=False).strip(x, dx)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast."""
        return self.thickness * self._waves().cell(x, y, dx, dy)

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""
        varying = self.thickness * self._waves().varying(x, y, dx, dy, period)
        return np.asarray(varying + self._strip(x.ravel(), dx)[:, None] * (dy / period))

    def _strip(self, x: Array, dx: float) -> Array:
        """Return the response to a strip of width `dx`, infinite along y, at offsets `x`."""
        depth, coupling = 2 * self.thickness, self.response.contrasts[2]
        total = self._remainder(x, dx)
        if self.name == "x":
            upper, lower = (
                edge * np.arctan(edge / depth) - depth / 2 * np.log(edge**2 + depth**2)
                for edge in (x + dx / 2, x - dx / 2)
            )
            return np.asarray(total + 2 * coupling * (upper - lower))
        if contrast := self._contrast:
            total = total - dx * contrast * _log_mean(np.abs(x), dx / 2, depth)
        return np.asarray(total + self.rigid_shift(dx))

    @property
    def _contrast(self) -> float:
        """First term of long waves whose displacement along its load grows with the logarithm of the distance."""
        pressed, along, _, across = self.response.contrasts
        return {"xx": along, "yy": across, "z": pressed}.get(self.name, 0.0)

    def rigid_shift(self, line: float) -> float:
        """Return what the datum adds to the response to a row of images, each with the area `line` times the period.

        The surface does not move at the datum under a load on a line. Fields without a logarithm have none.
        """
        if self.name not in ("xx", "yy", "z"):
            return 0.0
        width = LINE * self.datum
        of_waves = float(self._remainder(np.array([self.datum]), width)[0]) / width
        return line * (self._contrast * log(self.datum**2 + 4 * self.thickness**2) - of_waves)

    def lattice(self, x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        return self.thickness * self._waves().lattice(x, y, dx, dy, width, period)


def _log_mean(x: Array, half: float, depth: float) -> Array:
    """Return the mean of ``ln(x^2 + depth^2)`` over segments of half-length `half` about each x."""
    place = x + 1j * depth
    t = half / place
    ends = (1 + t) * log1p(t) - (1 - t) * log1p(-t)
    return np.asarray(2 * np.real(np.log(place) - 1 + ends / (2 * t)))

"""Influence coefficients that a bonded layer adds to those of a half-space of its own material."""

from dataclasses import dataclass
from math import log
from typing import ClassVar

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.layer_image import image_cell, image_lattice, image_row
from contactstudy.elasticity.kernels.layer_remainder import LayerRemainder
from contactstudy.elasticity.kernels.layer_response import LayerResponse


@dataclass(frozen=True)
class CoatingDisplacement:
    """Influence coefficients [m] that a bonded layer adds to those of a half-space of its own material.

    They are pi E1* times displacement over pressure, with E1* the plane-strain modulus of the layer: ``d0 I + J``.
    I is the displacement by a cell two thicknesses above the surface, in closed form; far away it changes the layer's
    compliance to that of the substrate. J is short-ranged.

    Parameters
    ----------
    response
        Response of the layer to a wave of pressure.
    thickness
        Thickness of the layer [m].
    datum
        Distance [m] as in :class:`~contactstudy.elasticity.coefficients.Displacement`.
    """

    response: LayerResponse
    thickness: float
    datum: float
    parity: ClassVar[tuple[int, int]] = (1, 1)

    def turned(self) -> "CoatingDisplacement":
        """Return these coefficients, which do not change when the axes are exchanged."""
        return self

    @property
    def _remainder(self) -> LayerRemainder:
        """Coefficients J."""
        return LayerRemainder(self.response, self.thickness)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast."""
        image = image_cell(x, y, dx, dy, 2 * self.thickness)
        return self._remainder.cell(x, y, dx, dy) + self.response.contrast * image

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""
        image = image_row(x, y, dx, dy, period, 2 * self.thickness)
        remainder = self._remainder.row(x, y, dx, dy, period)
        shift = self.rigid_shift(dx * dy / period)
        return np.asarray(remainder + self.response.contrast * image + shift)

    def rigid_shift(self, line: float) -> float:
        """Return what the datum adds to the response to a row of images, each with the area `line` times the period."""
        return self.response.contrast * 2 * line * log(self.datum)

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        image = image_lattice(x, y, dx, dy, width, period, 2 * self.thickness)
        remainder = self._remainder.lattice(x, y, dx, dy, width, period)
        return remainder + self.response.contrast * image

"""Influence coefficients of a coating: what a bonded layer adds to a half-space of its own material."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.layer_image import image_cell, image_lattice, image_row
from contactstudy.elasticity.kernels.layer_response import LayerResponse
from contactstudy.elasticity.kernels.layer_rest import rest_cell, rest_lattice, rest_row


@dataclass(frozen=True)
class CoatingDisplacement:
    """Influence coefficients [m] that a bonded layer adds to those of a half-space of its own material.

    They are pi E1* times displacement over pressure, with E1* the plane-strain modulus of the layer: ``d0 I + J``.
    I is a cell seen from two thicknesses below, in closed form, which far away turns the layer's compliance into the
    substrate's, and J is short-ranged.

    Parameters
    ----------
    response
        Answer of the layer to a wave of pressure.
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

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast."""
        layer_rest = rest_cell(self.response, self.thickness, x, y, dx, dy)
        return layer_rest + self.response.contrast * image_cell(x, y, dx, dy, 2 * self.thickness)

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""
        layer_rest = rest_row(self.response, self.thickness, x, y, dx, dy, period)
        shift = 2 * dx * dy / period * np.log(self.datum)
        image = shift + image_row(x, y, dx, dy, period, 2 * self.thickness)
        return np.asarray(layer_rest + self.response.contrast * image)

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        extent = width, period
        layer_rest = rest_lattice(self.response, self.thickness, x, y, dx, dy, *extent)
        image = image_lattice(x, y, dx, dy, *extent, 2 * self.thickness)
        return np.asarray(layer_rest + self.response.contrast * image)

"""Influence coefficients that a bonded layer adds, under pressure and tangential traction, to those of its material."""

from dataclasses import dataclass
from math import log
from typing import ClassVar

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.kernels.layer.buried_potential import (
    buried_cell,
    buried_lattice,
    buried_row,
    log_mean,
)
from contactstudy.elasticity.kernels.layer.remainder import LayerRemainder
from contactstudy.elasticity.kernels.layer.response import LayerResponse
from contactstudy.elasticity.kernels.layer.shear import ShearWaves, Subtracted, buried_field
from contactstudy.elasticity.kernels.layer.wave_coefficients import (
    LATTICE_RATIO,
    MAX_SERIES_WAVES,
    WaveCoefficients,
)
from contactstudy.elasticity.kernels.traction import SWAPPED


@dataclass(frozen=True)
class CoatingCoefficients:
    """Influence coefficients [m] that a bonded layer adds to those of a half-space of its own material.

    They are pi E1* times displacement over pressure, with E1* the plane-strain modulus of the layer: ``d0 I + J``.
    I is the displacement by a cell buried at two thicknesses, in closed form; far away it changes the layer's
    compliance to that of the substrate. J is short-ranged.

    Parameters
    ----------
    response
        Response of the layer to a wave of pressure.
    thickness
        Thickness of the layer [m].
    datum
        Distance [m] as in :class:`~contactstudy.elasticity.coefficients.BoussinesqCoefficients`.
    """

    response: LayerResponse
    thickness: float
    datum: float
    parity: ClassVar[tuple[int, int]] = (1, 1)

    def swap_axes(self) -> "CoatingCoefficients":
        """Return these coefficients, which do not change when the axes are exchanged."""
        return self

    @property
    def _remainder(self) -> LayerRemainder:
        """Coefficients J."""
        return LayerRemainder(self.response, self.thickness)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast."""
        buried = buried_cell(x, y, dx, dy, 2 * self.thickness)
        return self._remainder.cell(x, y, dx, dy) + self.response.contrast * buried

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""
        buried = buried_row(x, y, dx, dy, period, 2 * self.thickness)
        remainder = self._remainder.row(x, y, dx, dy, period)
        shift = self.rigid_shift(dx * dy / period)
        return np.asarray(remainder + self.response.contrast * buried + shift)

    def rigid_shift(self, line: float) -> float:
        """Return what the datum adds to the response to a row of images, each with the area `line` times the period."""
        return self.response.contrast * 2 * line * log(self.datum)

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        buried = buried_lattice(x, y, dx, dy, width, period, 2 * self.thickness)
        remainder = self._remainder.lattice(x, y, dx, dy, width, period)
        return remainder + self.response.contrast * buried


@dataclass(frozen=True)
class CoatingShearCoefficients:
    """Influence coefficients [m] under tangential traction that a bonded layer adds to those of its own half-space.

    They are those of :class:`~contactstudy.elasticity.kernels.layer.shear.ShearWaves`: under long waves the
    displacement along the surface is that of a half-space of the substrate. A row's mean and a cell alone have long
    waves in closed form, as mirror sources buried at two thicknesses; what is left is summed by its waves.

    Parameters
    ----------
    response
        Ratio of the moduli and Poisson's ratios.
    thickness
        Thickness of the layer [m].
    name
        "xx", "xy" or "yy" for displacement along one axis under traction along another, "x" or "y" for displacement
        along the normal under traction along that axis.
    datum
        Distance [m] as in :class:`~contactstudy.elasticity.coefficients.BoussinesqCoefficients`.
    """

    response: LayerResponse
    thickness: float
    name: str
    datum: float

    @property
    def parity(self) -> tuple[int, int]:
        """Parity along each axis."""
        return ShearWaves(self.response, Subtracted.NONE).parity(self.name)

    def swap_axes(self) -> "CoatingShearCoefficients":
        """Return the field with x and y exchanged."""
        return CoatingShearCoefficients(
            self.response, self.thickness, SWAPPED[self.name], self.datum
        )

    @property
    def _terms(self) -> tuple[tuple[float, ...], ...]:
        """Terms of long waves."""
        return ShearWaves(self.response, Subtracted.NONE).terms

    def _waves(self, subtracted: Subtracted) -> WaveCoefficients:
        """Return the sums of waves of the response without the terms that are `subtracted`."""
        return WaveCoefficients(ShearWaves(self.response, subtracted), self.thickness, self.name)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast."""
        h, waves = self.thickness, self._waves(Subtracted.ALL_THREE)
        farthest = max(float(np.abs(x).max()), float(np.abs(y).max())) + max(dx, dy)
        # images of the lattice contribute less than 1e-6
        period = max(LATTICE_RATIO * farthest, waves.least_period)
        if waves.count(period) <= MAX_SERIES_WAVES:
            total = h * waves.series(x, y, dx, dy, (period, period))
        else:
            total = h * waves.transformed(x, y, dx, dy, waves.least_period)
        for order, (along, across, coupling) in enumerate(zip(*self._terms, strict=True)):
            images = {self.name: along, SWAPPED[self.name]: across}
            if self.name in ("x", "y"):
                images = {self.name: coupling}
            elif self.name == "xy":
                images = {self.name: along - across}
            for name, weight in images.items():
                total += h**order * weight * buried_field(name, order, x, y, dx, dy, 2 * h)
        return np.asarray(total)

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""
        varying = self.thickness * self._waves(Subtracted.NONE).varying(x, y, dx, dy, period)
        return np.asarray(varying + self._strip(x.ravel(), dx)[:, None] * (dy / period))

    def _strip(self, x: Array, dx: float) -> Array:
        """Return the response to a strip of width `dx`, infinite along y, at offsets `x`."""
        depth = 2 * self.thickness
        along, across, coupling = (terms[0] for terms in self._terms)
        remainder = self.thickness * self._waves(Subtracted.FIRST).strip(x, dx)
        if self.name == "x":
            upper, lower = (
                edge * np.arctan(edge / depth) - depth / 2 * np.log(edge**2 + depth**2)
                for edge in (x + dx / 2, x - dx / 2)
            )
            return np.asarray(remainder + 2 * coupling * (upper - lower))
        if self.name in ("xx", "yy"):
            # as of a half-space, whose surface at the datum stays where it is
            line = 2 * log(self.datum) - log_mean(np.abs(x), dx / 2, depth)
            return np.asarray(remainder + dx * (along if self.name == "xx" else across) * line)
        return remainder

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        return self.thickness * self._waves(Subtracted.NONE).lattice(x, y, dx, dy, width, period)

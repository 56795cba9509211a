"""Operators from shear on the surface to displacement: coefficients that are odd, and of two components."""

from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.elasticity.coefficients import Coefficients, Displacement, kernel
from contactstudy.elasticity.convolution import padded_cells, spread
from contactstudy.elasticity.kernels.stress_cell import stress_cell
from contactstudy.elasticity.kernels.stress_periodic import (
    stress_cell_doubly_periodic,
    stress_cell_periodic,
)
from contactstudy.elasticity.kernels.traction import SURFACE
from contactstudy.elasticity.transforms import TRANSFORMS, Waves


@dataclass(frozen=True)
class SurfaceField:
    """Influence coefficients of a field on the surface under shear, integrated over a cell.

    Parameters
    ----------
    name
        Name of the field in :data:`~contactstudy.elasticity.kernels.traction.SURFACE`, or "yy".
    datum
        Distance [m] from which displacement is counted, for "yy", as in
        :class:`~contactstudy.elasticity.coefficients.Displacement`.
    """

    name: str
    datum: float

    @property
    def parity(self) -> tuple[int, int]:
        """Parity along each axis, odd along an axis that the name has once."""
        even_x, even_y = (-1 if self.name.count(axis) % 2 else 1 for axis in "xy")
        return even_x, even_y

    def turned(self) -> "SurfaceField":
        """Return the field with x and y exchanged."""
        return SurfaceField("".join(sorted(self.name.translate({120: 121, 121: 120}))), self.datum)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the field of one cell; x and y broadcast."""
        if self.name == "yy":
            return self._inverse_distance.cell(x, y, dx, dy) - self._complement.cell(x, y, dx, dy)
        return 2 * np.pi * stress_cell(SURFACE[self.name], x, y, 0.0, dx, dy, 0.0)

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the field of an infinite row of images along y; x is a column, y a row."""
        cell = dx, dy, period
        if self.name == "yy":
            return self._inverse_distance.row(x, y, *cell) - self._complement.row(x, y, *cell)
        return 2 * np.pi * stress_cell_periodic(SURFACE[self.name], x, y, 0.0, *cell, 0.0)

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """Return the field of an infinite lattice of images along both axes; x is a column, y a row."""
        cell = dx, dy, width, period
        if self.name == "yy" or (self.name == "xx" and period > width):
            if self.name == "yy" and period > width:
                turned = y.reshape(-1, 1), x.reshape(1, -1)
                return self.turned().lattice(*turned, dy, dx, period, width).T
            field_yy = self._complement.lattice(x, y, *cell)
            return np.asarray(self._inverse_distance.lattice(x, y, *cell) - field_yy)
        return 2 * np.pi * stress_cell_doubly_periodic(SURFACE[self.name], x, y, 0.0, *cell, 0.0)

    @property
    def _inverse_distance(self) -> Displacement:
        """Coefficients of 1 / r, the sum of the fields xx and yy."""
        return Displacement(self.datum)

    @property
    def _complement(self) -> "SurfaceField":
        """Field that, with this one, adds up to 1 / r."""
        return SurfaceField("yy" if self.name == "xx" else "xx", self.datum)


@dataclass(frozen=True, eq=False)
class GeneralConvolution:
    """Convolution of fields (x, y) with coefficients that are even or odd, by their `spectrum` on the padded grid."""

    spectrum: Waves
    cells: tuple[int, int]
    padded: tuple[int, int]

    def times(self, factors: float | Waves) -> "GeneralConvolution":
        """Return the convolution whose waves are multiplied by `factors`."""
        return replace(self, spectrum=self.spectrum * factors)

    def __call__(self, field: Array) -> Array:
        """Return `field` (x, y) convolved with the coefficients."""
        waves = TRANSFORMS.forward(field, self.padded)
        waves *= self.spectrum
        return TRANSFORMS.backward(waves, self.cells, self.padded)


def general_convolution(
    coefficients: Coefficients, grid: Grid, paddings: Paddings
) -> GeneralConvolution:
    """Return the convolution with `coefficients` on `grid`."""
    padded = padded_cells(grid, paddings)
    around = spread(kernel(grid, paddings, coefficients), padded, coefficients.parity)
    return GeneralConvolution(TRANSFORMS.forward(around, padded), grid.cells, padded)


@dataclass(frozen=True, eq=False)
class ShearResponse:
    """Displacement along the surface [m] under shear [Pa], both (component, x, y): symmetric and positive.

    ``u_x = (c / pi) sum of [1 / r + n x^2 / r^3] q_x + n (x y / r^3) q_y`` over bodies, c their compliance and ``n = nu
    / (1 - nu)``. Source: Johnson (1985), eqs. 3.75a, b.
    """

    xx: GeneralConvolution
    yy: GeneralConvolution
    xy: GeneralConvolution

    def __call__(self, shear: Array) -> Array:
        """Return the displacement [m] under `shear` [Pa], both (component, x, y), by four transforms."""
        padded, cells = self.xx.padded, self.xx.cells
        x, y = (TRANSFORMS.forward(component, padded) for component in shear)
        across = self.xx.spectrum * x
        across += self.xy.spectrum * y
        # in place: new arrays cost as much as a transform
        x *= self.xy.spectrum
        y *= self.yy.spectrum
        x += y
        return np.stack([TRANSFORMS.backward(waves, cells, padded) for waves in (across, x)])

    def times(self, factors: Waves) -> "ShearResponse":
        """Return the response whose waves, each of all components, are multiplied by `factors`."""
        return ShearResponse(*(part.times(factors) for part in (self.xx, self.yy, self.xy)))

    @property
    def largest(self) -> float:
        """Upper bound of displacement over shear in the root mean square [m/Pa], apart from a rigid shift."""
        sums = np.maximum(np.abs(self.xx.spectrum), np.abs(self.yy.spectrum))
        return float((sums + np.abs(self.xy.spectrum)).max())


def shear_response(
    bodies: tuple[tuple[float, float], ...], grid: Grid, paddings: Paddings, datum: float
) -> ShearResponse:
    """Return the response of `bodies`, each given by its compliance (1 - nu^2) / E [1/Pa] and Poisson's ratio."""
    compliance_sum = sum(compliance for compliance, _ in bodies) / np.pi
    shear_part = sum(compliance * nu / (1 - nu) for compliance, nu in bodies) / np.pi
    spectra = {
        name: general_convolution(coefficients, grid, paddings).spectrum
        for name, coefficients in (
            ("all", Displacement(datum)),
            ("xx", SurfaceField("xx", datum)),
            ("xy", SurfaceField("xy", datum)),
        )
    }
    padded = padded_cells(grid, paddings)
    return ShearResponse(
        *(
            GeneralConvolution(spectrum, grid.cells, padded)
            for spectrum in (
                compliance_sum * spectra["all"] + shear_part * spectra["xx"],
                (compliance_sum + shear_part) * spectra["all"] - shear_part * spectra["xx"],
                shear_part * spectra["xy"],
            )
        )
    )

"""Operators from tangential traction on the surface to displacement along the surface, and along the normal.

Fields have two components, across (x) and along (y). Displacement along the surface comes from a symmetric operator of
both, :class:`ShearResponse`. Displacement along the normal, positive into the body, is odd along the traction; that of
two bodies changes the gap where they are unlike (:func:`normal_displacement`). Without friction nothing here is used.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from contactstudy.domain.grid import Array, Grid, Paddings
from contactstudy.elasticity.convolution import (
    BoussinesqCoefficients,
    Coefficients,
    GeneralConvolution,
    general_convolutions,
)
from contactstudy.elasticity.kernels.stress import SURFACE, SWAPPED, StressCoefficients
from contactstudy.elasticity.transforms import TRANSFORMS, ComplexField

# A sum of signed weights is zero where it is smaller than this fraction of the sum of their sizes: it is rounding.
WEIGHT_ROUNDING = 1e-14


@dataclass(frozen=True)
class CerrutiCoefficients:
    """Influence coefficients of a field on the surface under tangential traction, integrated over a cell (Cerruti).

    Parameters
    ----------
    name
        Displacement by traction: along the surface "xx", "xy" or "yy" (``x^2 / r^3``, ``x y / r^3`` and ``y^2 / r^3``),
        or along the normal "x" or "y" (``x / r^2`` and ``y / r^2``), as in Johnson (1985), eqs. 3.75.
    datum
        Distance [m] across at which a load on a line does not move the surface, for "xx" and "yy", as in
        :class:`~contactstudy.elasticity.convolution.BoussinesqCoefficients`.
    """

    name: str
    datum: float

    @property
    def parity(self) -> tuple[int, int]:
        """Parity along each axis: -1, odd, along an axis that stands once in the name, else 1."""
        even_x, even_y = (-1 if self.name.count(axis) % 2 else 1 for axis in "xy")
        return even_x, even_y

    def swap_axes(self) -> "CerrutiCoefficients":
        """Return the field with x and y exchanged."""
        return CerrutiCoefficients(SWAPPED[self.name], self.datum)

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the field of one cell; x and y broadcast."""
        if self.name == "yy":
            return self._inverse_distance.cell(x, y, dx, dy) - self._complement.cell(x, y, dx, dy)
        return 2 * np.pi * self._integral.cell(x, y, dx, dy)

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the field of an infinite row of images along y; x is a column, y a row."""
        cell = dx, dy, period
        if self.name == "yy":
            return self._inverse_distance.row(x, y, *cell) - self._complement.row(x, y, *cell)
        field = 2 * np.pi * self._integral.row(x, y, *cell)
        # the field of the row is constant across, beside what decays: the surface at the datum stays where it is
        return field - 2 * dx * dy / period if self.name == "xx" else field

    def lattice(self, x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
        """Return the field of an infinite lattice of images along both axes, of zero mean; x is a column, y a row."""
        cell = dx, dy, width, period
        # the kernels have no "yy", and exchange the axes where the period exceeds the width, which makes "xx" one
        if self.name == "yy" or (self.name == "xx" and period > width):
            if self.name == "yy" and period > width:
                swapped = y.reshape(-1, 1), x.reshape(1, -1)
                return self.swap_axes().lattice(*swapped, dy, dx, period, width).T
            field_yy = self._complement.lattice(x, y, *cell)
            return np.asarray(self._inverse_distance.lattice(x, y, *cell) - field_yy)
        return 2 * np.pi * self._integral.lattice(x, y, *cell)

    @property
    def _integral(self) -> StressCoefficients:
        """Coefficients of the field over 2 pi, which depends on no Poisson's ratio."""
        return StressCoefficients(SURFACE[self.name], 0.0, 0.0)

    @property
    def _inverse_distance(self) -> BoussinesqCoefficients:
        """Coefficients of 1 / r, the sum of the fields xx and yy."""
        return BoussinesqCoefficients(self.datum)

    @property
    def _complement(self) -> "CerrutiCoefficients":
        """Field that, with this one, adds up to 1 / r."""
        return CerrutiCoefficients("yy" if self.name == "xx" else "xx", self.datum)


@dataclass(frozen=True, eq=False)
class ShearResponse:
    """Displacement along the surface [m] under tangential traction [Pa], both (component, x, y).

    It is symmetric and positive, unless a body creeps while it rolls.

    For one half-space ``u_x = (c / pi) sum of [1 / r + n x^2 / r^3] q_x + n (x y / r^3) q_y``, where q is the traction,
    r the distance, ``c = (1 - nu^2) / E`` the compliance under pressure and ``n = nu / (1 - nu)``; u_y has x and y
    exchanged. Source: Johnson (1985), eqs. 3.75a, b.

    Parameters
    ----------
    xx, yy
        Convolutions from the traction along an axis to the displacement along it [m/Pa].
    xy
        Convolution from the traction along either axis to the displacement along the other.
    """

    xx: GeneralConvolution
    yy: GeneralConvolution
    xy: GeneralConvolution

    def __call__(self, shear: Array) -> Array:
        """Return the displacement [m] under the traction `shear` [Pa], both (component, x, y), by four transforms."""
        padded, cells = self.xx.padded, self.xx.cells
        x, y = (TRANSFORMS.forward(component, padded) for component in shear)
        across = self.xx.spectrum * x
        across += self.xy.spectrum * y
        # in place: new arrays cost as much as a transform
        x *= self.xy.spectrum
        y *= self.yy.spectrum
        x += y
        return np.stack([TRANSFORMS.backward(waves, cells, padded) for waves in (across, x)])

    def scaled(self, factors: float | ComplexField) -> "ShearResponse":
        """Return the response whose waves are multiplied by `factors`, which broadcast over the spectra."""
        return ShearResponse(*(part.scaled(factors) for part in (self.xx, self.yy, self.xy)))

    @property
    def largest(self) -> float:
        """Upper bound of displacement over traction in the root mean square [m/Pa], over all waves and the mean."""
        sums = np.maximum(np.abs(self.xx.spectrum), np.abs(self.yy.spectrum))
        return float((sums + np.abs(self.xy.spectrum)).max())


# Compliance under traction, as coefficients [m] with their weights [1/Pa]: along the surface by the components "xx",
# "yy" and "xy", and along the normal by "x" and "y", the axis of the traction.
ShearCompliance = Mapping[str, Mapping[Coefficients, float]]


@runtime_checkable
class ShearableBody(Protocol):
    """Body whose response to tangential traction is known."""

    def shear_compliance(self, datum: float) -> ShearCompliance:
        """Return the compliance under tangential traction; `datum` [m] is that of the response to pressure."""


def half_space_shear_compliance(compliance: float, poisson_ratio: float, datum: float) -> ShearCompliance:
    """Return the compliance under traction of a half-space; its `compliance` under pressure is (1 - nu^2) / E [1/Pa]."""
    isotropic = compliance / np.pi
    by_poisson = isotropic * poisson_ratio / (1 - poisson_ratio)
    normal = compliance * (1 - 2 * poisson_ratio) / (2 * np.pi * (1 - poisson_ratio))
    inverse_distance, xx = BoussinesqCoefficients(datum), CerrutiCoefficients("xx", datum)
    return {
        "xx": {inverse_distance: isotropic, xx: by_poisson},
        "yy": {inverse_distance: isotropic + by_poisson, xx: -by_poisson},
        "xy": {CerrutiCoefficients("xy", datum): by_poisson},
        "x": {CerrutiCoefficients("x", datum): normal},
        "y": {CerrutiCoefficients("y", datum): normal},
    }


def shear_response(bodies: Iterable[ShearableBody], grid: Grid, paddings: Paddings, datum: float) -> ShearResponse:
    """Return the operator of the displacement of all `bodies` together under one tangential traction.

    `paddings` are (across, along); `datum` [m] is the zero of displacement, see :class:`CerrutiCoefficients`.
    """
    shears = [body.shear_compliance(datum) for body in bodies]
    weights = {name: summed_responses(1, *(shear[name] for shear in shears)) for name in ("xx", "yy", "xy")}
    return ShearResponse(*general_convolutions(weights.values(), grid, paddings))


def normal_displacement(
    first: ShearableBody, second: ShearableBody, axes: str, grid: Grid, paddings: Paddings, datum: float
) -> list[GeneralConvolution]:
    """Return the convolution from traction along each of the `axes` to the gap that it adds, or [] for similar bodies.

    `axes` is a text such as "x" or "xy"; the traction is that on the first body. Both bodies move alike under it where
    their coefficients have the same weights: they are elastically similar.
    """
    first_shear, second_shear = first.shear_compliance(datum), second.shear_compliance(datum)
    weights = {axis: summed_responses(-1, first_shear[axis], second_shear[axis]) for axis in axes}
    if not any(weights.values()):
        return []
    return general_convolutions(weights.values(), grid, paddings)


def summed_responses(sign: int, *responses: Mapping[Coefficients, float]) -> Mapping[Coefficients, float]:
    """Return the sum of `responses`, all but the first times `sign`, without what cancels or is zero."""
    summed: dict[Coefficients, float] = {}
    sizes: dict[Coefficients, float] = {}
    for number, response in enumerate(responses):
        for coefficients, weight in response.items():
            signed = sign * weight if number else weight
            summed[coefficients] = summed.get(coefficients, 0.0) + signed
            sizes[coefficients] = sizes.get(coefficients, 0.0) + abs(weight)
    return {kind: weight for kind, weight in summed.items() if abs(weight) > WEIGHT_ROUNDING * sizes[kind]}

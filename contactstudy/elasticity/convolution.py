"""Operators from pressure to displacement: convolutions with influence coefficients, by real Fourier transforms.

:class:`Coefficients` are the response to one loaded cell; :func:`influence_coefficients` samples them on a grid, summed
over the images that the paddings include. :func:`superposed` makes the operator of a contact of them, a
:class:`Convolution`, and :func:`general_convolutions` those of fields that are odd along an axis. One transform of the
pressure and one back give the displacement (Liu, Wang & Liu 2000); rows that are zero, or that are not asked for, are
not transformed.

Arrays are (x, y), across and along the contact; cells count along both axes. A padded axis of n cells has at least 2 n
points, one that wraps has n. A spectrum is the transform on px x py points, (px, py // 2 + 1) numbers.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from math import ceil, log
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import DTypeLike
from scipy import fft

from contactstudy.domain.device import Cpu, Precision, arrays, cached_array, device
from contactstudy.domain.grid import Array, Grid, Padding, Paddings, across_and_along
from contactstudy.domain.validation import InvalidInput, Metres, valid
from contactstudy.elasticity.approximate_inverse import (
    MARGIN,
    FreeEndsInverse,
    SpectralInverse,
    at_unpadded_wave_numbers,
)
from contactstudy.elasticity.kernels.displacement import (
    boussinesq_cell,
    boussinesq_cell_doubly_periodic,
    boussinesq_cell_periodic,
)
from contactstudy.elasticity.transforms import TRANSFORMS, ComplexField, transforms


class Coefficients(Protocol):
    """Influence coefficients: the response to one loaded cell at offsets x and y, alone or with its periodic images.

    Methods take offsets from the centre of the cell and lengths in one unit, and return one coefficient for each offset
    (x, y). `dx` and `dy` are the sides of the cell, `width` and `period` the distances between images along x and y.
    """

    @property
    def parity(self) -> tuple[int, int]:
        """Parity along each axis, 1 for coefficients that are even along it, -1 for odd ones."""

    def swap_axes(self) -> "Coefficients":
        """Return the coefficients with the two axes exchanged."""

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast."""

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""

    def lattice(self, x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""


@dataclass(frozen=True)
class BoussinesqCoefficients:
    """Integrals of 1 / r over a cell: pi E* times the normal displacement of a half-space over the pressure [m].

    Parameters
    ----------
    datum
        Distance [m] across at which a load on a line along y does not move the surface: the zero of displacement, which
        an infinite row of images leaves open. With a lattice of images displacement is counted from its mean.
    """

    datum: float
    parity: ClassVar[tuple[int, int]] = (1, 1)

    def swap_axes(self) -> "BoussinesqCoefficients":
        """Return these coefficients, which do not change when the axes are exchanged."""
        return self

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Return the response to one cell; x and y broadcast."""
        return boussinesq_cell(x, y, dx, dy)

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """Return the response to an infinite row of images along y; x is a column, y a row."""
        response = boussinesq_cell_periodic(x, y, dx, dy, period)
        response += self.rigid_shift(dx * dy / period)
        return response

    def rigid_shift(self, line: float) -> float:
        """Return what the datum adds to the response to a row of images, each with the area `line` times the period."""
        return 2 * line * log(self.datum)

    def lattice(self, x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        return boussinesq_cell_doubly_periodic(x, y, dx, dy, width, period)


# Datum of a body with free faces over its length. The loads on it are mirrored about both faces, in a row without end.
# Those beyond the two neighbouring images together do not displace the middle of the body with a datum of
# ``2 exp(1 - 0.577) = 3.05`` lengths, here rounded; 0.577 is Euler's constant.
DATUM_OVER_LENGTH = 3.0


@dataclass(frozen=True)
class FreeFaceCoefficients(BoussinesqCoefficients):
    """Coefficients of a body with two free faces: those of the half-space, and what determines the effect of the faces.

    :mod:`~contactstudy.elasticity.free_faces` makes the operator of them.

    Parameters
    ----------
    length
        Distance between the faces [m].
    poisson_ratio
        Poisson's ratio of the body.
    """

    length: float
    poisson_ratio: float

    @classmethod
    def of(cls, length: float, poisson_ratio: float) -> "FreeFaceCoefficients":
        """Return the coefficients of a body of this `length` [m], with its datum."""
        return cls(DATUM_OVER_LENGTH * length, length, poisson_ratio)


@dataclass(frozen=True)
class _Axis:
    """Axis of a grid: number of `cells`, their size `step` [m], `period` [m] of the images, and its padding.

    The window of a padding has the numbers of the periods with an image, 0 for the cell itself; None has all.
    """

    cells: int
    step: float
    period: float
    padding: Padding

    @property
    def known(self) -> int:
        """Number of offsets to evaluate; on a periodic axis those beyond half a period follow by symmetry."""
        return self.cells // 2 + 1 if self.padding.wraps else self.cells

    @property
    def offsets(self) -> Array:
        """Offsets to evaluate (offsets,) [m]."""
        return np.arange(float(self.known)) * self.step


def influence_coefficients(grid: Grid, paddings: Paddings, coefficients: Coefficients) -> Array:
    """Return `coefficients` (x, y) at offsets of 0, 1, 2 ... cells, summed over the images that the paddings include.

    A periodic axis of n cells has ``n // 2 + 1`` offsets, any other axis n.
    """
    axes = zip(grid.cells, grid.cell_size, grid.extent, paddings, strict=True)
    across, along = (_Axis(*axis) for axis in axes)
    return _on_axes(across, along, coefficients)


def _on_axes(across: _Axis, along: _Axis, coefficients: Coefficients) -> Array:
    """Return the `coefficients` (across, along) at the offsets of both axes, images included."""
    cell = across.step, along.step
    if across.padding.window is None:
        if along.padding.window is not None:
            return _on_axes(along, across, coefficients.swap_axes()).T
        x, y = across.offsets[:, None], along.offsets
        return coefficients.lattice(x, y, *cell, across.period, along.period)
    even_x, even_y = coefficients.parity

    def columns(x: Array) -> Array:
        """Return the coefficients (x, along) at offsets `x` (x,), images along the length included."""
        if along.padding.window is None:
            return coefficients.row(x[:, None], along.offsets, *cell, along.period)
        return _summed(lambda y: coefficients.cell(x, y[:, None], *cell), along, even_y).T

    return _summed(columns, across, even_x)


def _summed(coefficients: Callable[[Array], Array], axis: _Axis, parity: int) -> Array:
    """Return the sum (offsets, ...) of ``coefficients(d + m L)`` over the periods m of the window, for known offsets d.

    L is the period of the axis. `coefficients` maps offsets (n,) to (n, ...) and is even or odd, by its `parity`. So the
    offsets of one period serve two images: the one ahead and, reversed, the next one behind. Far images are added
    first: small terms are summed before large ones.
    """
    window, count = axis.padding.window, axis.cells
    assert window is not None
    total: Array | None = None
    for period in range(max(window[-1], -window[0] - 1), -1, -1):
        is_ahead, is_behind = period in window, -period - 1 in window
        distances = np.arange(count + 1.0) if is_behind else np.arange(float(axis.known))
        block = coefficients((period * count + distances) * axis.step)
        images = [block[: axis.known]] if is_ahead else []
        images += [parity * block[: -axis.known - 1 : -1]] if is_behind else []
        for image in images:
            total = image if total is None else np.add(total, image)
    return np.asarray(total)


# Wave numbers along the length with less than this fraction of the energy of the strongest one are left out of a sum:
# in amplitude 1e-14, somewhat above rounding in double precision.
NEGLIGIBLE_ENERGY = 1e-28
# Least number of cells along an axis of a coarser grid. If it is 64, contacts take up to 1.2 times as many
# convolutions; if it is 8, they take as many as now.
MIN_COARSENED = 32


@dataclass(frozen=True, eq=False)
class Convolution:
    """Linear map from pressure to displacement on one grid, ``displacement = K * pressure``.

    Call it with a pressure (x, y) [Pa] to get the displacement (x, y) [m]. It is symmetric, and positive definite
    except for rigid-body motion and, with a window of images, for some waves.

    Parameters
    ----------
    spectrum
        Transform of the influence coefficients on the padded grid (px, py // 2 + 1) [m/Pa].
    cells
        Cells of the grid (across, along).
    padded
        Points (px, py) of the transforms.
    ends
        Whether each axis ends, without images beyond: near its ends the preconditioner has a margin.
    work
        Flat array of complex numbers, as many as the spectrum has, that each transform overwrites: allocating a large
        array costs as much as a transform. :meth:`scaled` makes it for a solve. None for an operator that several
        threads may share, and on a device that reuses memory itself.
    """

    spectrum: Array
    cells: tuple[int, int]
    padded: tuple[int, int]
    ends: tuple[bool, bool] = field(default=(False, False), kw_only=True)
    work: ComplexField | None = field(default=None, kw_only=True)

    def __call__(self, pressure: Array) -> Array:
        """Return the displacement (x, y) [m] under a `pressure` (x, y) [Pa].

        Raises
        ------
        InvalidInput
            If the pressure does not have the shape of the grid.
        """
        if pressure.shape != self.cells:
            raise InvalidInput(f"pressure has the shape {pressure.shape}: give it {self.cells}.")
        work = self.work_array(self.padded, self.spectrum.dtype)
        return transforms().convolved(pressure, self.spectrum, self.padded, work)

    def work_array(self, shape: tuple[int, int], real: DTypeLike) -> ComplexField | None:
        """Return the part (px, py // 2 + 1) of `work` for waves of a field of a `shape` (px, py) of `real` numbers."""
        if self.work is None:
            return None
        rows, columns = shape[0], shape[1] // 2 + 1
        return self.work.view(np.result_type(real, np.complex64))[: rows * columns].reshape(rows, columns)

    @property
    def transform_size(self) -> float:
        """Number of cells of the padded grid, transformed in one application."""
        return float(self.padded[0] * self.padded[1])

    @property
    def self_compliance(self) -> float:
        """Displacement of a cell under its own unit pressure, relative to the mean over the padded grid [m/Pa].

        It is the mean of the spectrum without its first entry, that of rigid-body motion. With infinitely many images
        that entry may have any sign: in a cell far wider than the datum it would make the sum negative.
        """
        xp, py = arrays(), self.padded[1]
        stored_once = xp.sum(self.spectrum[:, 0])
        if py % 2 == 0 and py > 1:
            stored_once += xp.sum(self.spectrum[:, -1])
        total = 2 * xp.sum(self.spectrum) - stored_once - self.spectrum[0, 0]
        return float(total / self.transform_size)

    def work_of_product(self, across: Array, along: Array) -> float:
        """Return the sum of pressure times displacement [Pa m] under the pressure ``across[:, None] * along`` [Pa].

        It follows from the spectrum, which is even, without a transform of the field.
        """
        px, py = self.padded
        of_x, of_y = np.abs(fft.fft(across, px)) ** 2, np.abs(fft.rfft(along, py)) ** 2
        of_y[1 : (py + 1) // 2] *= 2  # rfft keeps one of two conjugate waves
        waves = np.flatnonzero(of_y > NEGLIGIBLE_ENERGY * of_y.max())
        return float(np.einsum("x,xy,y", of_x, self.spectrum[:, waves], of_y[waves]) / self.transform_size)

    def scaled(self, factor: float, precision: Precision) -> Self:
        """Return this operator times `factor`, in `precision`, on the device in use, for one thread."""
        if not isinstance(device(), Cpu):  # half of the rows repeat: they are not copied
            xp, px = arrays(), self.padded[0]
            half: Array = device().to_device(self.spectrum[: px // 2 + 1]) * factor
            half = xp.astype(half, precision.on_device, copy=False)
            repeated = xp.flip(half[1 : (px + 1) // 2, :], axis=0)
            return replace(self, spectrum=xp.concat([half, repeated]))
        spectrum = np.multiply(self.spectrum, factor, dtype=self.spectrum.dtype).astype(precision.real, copy=False)
        work = np.empty(self.padded[0] * (self.padded[1] // 2 + 1), np.result_type(spectrum, np.complex64))
        return replace(self, spectrum=spectrum, work=work)

    @property
    def blocks(self) -> tuple[int, int]:
        """Number of cells (across, along) that :meth:`coarsened` joins: 2 along an axis that can be halved, else 1."""
        across, along = (
            2 if cells % 2 == 0 and padded % 2 == 0 and cells >= 2 * MIN_COARSENED else 1
            for cells, padded in zip(self.cells, self.padded, strict=True)
        )
        return across, along

    def coarsened(self) -> Self:
        """Return the operator on larger cells: mean displacement of blocks of cells under a pressure constant in each.

        It is a Galerkin coarsening. Restriction to larger cells and prolongation to smaller ones together multiply wave
        k on an axis of n points by ``cos(pi k / n)^2``. The larger cells alias the upper half of the waves to the lower.
        """
        (px, py), blocks = self.padded, self.blocks
        cells = self.cells[0] // blocks[0], self.cells[1] // blocks[1]
        spectrum = coarsened_spectrum(self.spectrum, self.padded, blocks)
        return replace(self, spectrum=spectrum, cells=cells, padded=(px // blocks[0], py // blocks[1]))

    def approximate_inverse(self, precision: Precision | None = None) -> SpectralInverse | FreeEndsInverse:
        """Return a preconditioner: division by the spectrum on the unpadded grid, as if it were periodic.

        Near an end of an axis without images the grid has a margin. It works in the operator's own precision, unless
        another `precision` is given and can hold the spectrum's range.
        """
        real = self.spectrum.dtype if precision is None else precision.real

        def inverse(cells: tuple[int, int]) -> SpectralInverse:
            """Return the division by the spectrum on a grid of these `cells`."""
            spectrum = at_unpadded_wave_numbers(self.spectrum, cells, self.padded)
            return SpectralInverse(spectrum, cells, self.work_array, real)

        longer = self._beyond_free_ends
        if longer == self.cells:
            return inverse(self.cells)
        return FreeEndsInverse(self.cells, longer, inverse)

    @property
    def _beyond_free_ends(self) -> tuple[int, int]:
        """Cells (across, along) of the grid with a margin beyond the ends of each axis that ends, a multiple of 4."""
        across, along = (
            4 * fft.next_fast_len(ceil(n * (1 + MARGIN) / 4)) if ends and n > 1 else n
            for n, ends in zip(self.cells, self.ends, strict=True)
        )
        return across, along


def coarsened_spectrum(spectrum: Array, padded: tuple[int, int], blocks: tuple[int, int]) -> Array:
    """Return a `spectrum` on `padded` points (px, py) for cells that are merged in `blocks` (1 or 2 across, along).

    See :meth:`Convolution.coarsened`.
    """
    (px, py), (across, along) = padded, blocks
    if across == 2:
        weights = np.cos(np.pi / px * np.arange(px // 2)[:, None]) ** 2
        spectrum = _aliased(spectrum[: px // 2, :], spectrum[px // 2 :, :], weights)
    if along == 2:
        weights = np.cos(np.pi / py * np.arange(py // 4 + 1)[None, :]) ** 2
        mirrored = arrays().flip(spectrum, axis=1)
        columns = py // 4 + 1
        spectrum = _aliased(spectrum[:, :columns], mirrored[:, :columns], weights)
    return spectrum


def _aliased(low: Array, high: Array, weights: Array) -> Array:
    """Return ``low weights + high (1 - weights)``: the waves `low` and their aliases `high` on larger cells."""
    folded = low - high
    folded *= arrays().astype(device().to_device(weights), folded.dtype, copy=False)
    folded += high
    return folded


@dataclass(frozen=True, eq=False)
class GeneralConvolution:
    """Convolution of fields (x, y) with coefficients that are even or odd along each axis.

    Parameters
    ----------
    spectrum
        Transform of the coefficients on the padded grid (px, py // 2 + 1).
    cells
        Cells of the grid (across, along).
    padded
        Points (px, py) of the transforms.
    """

    spectrum: ComplexField
    cells: tuple[int, int]
    padded: tuple[int, int]

    def scaled(self, factors: float | ComplexField) -> "GeneralConvolution":
        """Return the convolution whose waves are multiplied by `factors`, which broadcast over the spectrum."""
        return replace(self, spectrum=self.spectrum * factors)

    def __call__(self, field: Array) -> Array:
        """Return `field` (x, y) convolved with the coefficients."""
        waves = TRANSFORMS.forward(field, self.padded)
        waves *= self.spectrum
        return TRANSFORMS.backward(waves, self.cells, self.padded)


def convolution(contact_modulus: float, grid: Grid, padding: Padding | Paddings, datum: float) -> Convolution:
    """Return the operator of two half-spaces in contact.

    Along an axis that wraps the convolution is circular. An axis that does not is padded to at least twice its cells,
    which makes the convolution linear there (Liu, Wang & Liu 2000).

    Parameters
    ----------
    contact_modulus
        E* [Pa].
    grid
        Cells and extent.
    padding
        Padding along the length, or (across, along).
    datum
        Distance from the axis [m] at which displacement is zero; used where the padding leaves the zero open.

    Returns
    -------
    Convolution
        Map from pressure (x, y) [Pa] to displacement (x, y) [m].

    Raises
    ------
    InvalidInput
        If the datum is not above 0 m, or `padding` is not a padding.
    """
    datum = valid("datum", datum, Metres)
    return superposed({BoussinesqCoefficients(datum): 1 / (np.pi * contact_modulus)}, grid, padding)


def superposed(response: Mapping[Coefficients, float], grid: Grid, padding: Padding | Paddings) -> Convolution:
    """Return the operator whose influence coefficients are a weighted sum.

    Parameters
    ----------
    response
        Weight [1/Pa] of each kind of coefficients [m], which are even along both axes.
    grid
        Cells and extent.
    padding
        Padding along the length, or (across, along).

    Returns
    -------
    Convolution
        Map from pressure (x, y) [Pa] to displacement (x, y) [m].
    """
    paddings = across_and_along(padding)
    spectrum = sum(weight * spectrum_of(kind, grid, paddings) for kind, weight in response.items())
    across, along = (axis.window == range(1) and not axis.wraps for axis in paddings)
    return Convolution(spectrum.real, grid.cells, padded_cells(grid, paddings), ends=(across, along))


def spectrum_of(kind: Coefficients, grid: Grid, paddings: Paddings) -> Any:
    """Return the spectrum of coefficients, real where they are even along both axes, else complex; it is kept."""

    def transform() -> Any:
        """Return the spectrum, computed anew."""
        padded, quadrant = padded_cells(grid, paddings), influence_coefficients(grid, paddings, kind)
        if kind.parity == (1, 1):
            return even_spectrum(quadrant, padded)
        return TRANSFORMS.forward(mirrored_by_parity(quadrant, padded, kind.parity), padded)

    return cached_array((kind, grid, paddings), transform)


def even_spectrum(half: Array, padded: tuple[int, int]) -> Array:
    """Return the spectrum on `padded` points of coefficients, even along both axes, at known offsets `half` (x, y)."""
    return TRANSFORMS.forward(mirrored_by_parity(half, padded, (1, 1)), padded).real.copy()


def general_convolutions(
    responses: Iterable[Mapping[Coefficients, float]], grid: Grid, padding: Padding | Paddings
) -> list[GeneralConvolution]:
    """Return for each of the `responses` the convolution with a weighted sum of coefficients of any parity.

    A response has the weight of each kind of coefficients, as for :func:`superposed`. A sum that is odd along one axis
    is an antisymmetric operator, which conjugate gradients do not solve: solvers take its displacement from the iterate
    before.
    """
    paddings = across_and_along(padding)
    padded = padded_cells(grid, paddings)
    nothing: ComplexField = np.zeros((padded[0], padded[1] // 2 + 1), np.complex128)
    return [
        GeneralConvolution(
            sum((weight * spectrum_of(kind, grid, paddings) for kind, weight in response.items()), start=nothing),
            grid.cells,
            padded,
        )
        for response in responses
    ]


def on_padded_grid(terms: Iterable[tuple[Coefficients, float]], grid: Grid, paddings: Paddings) -> Array:
    """Return a weighted sum of influence coefficients of any parity at every point (px, py) of the padded grid."""
    padded = padded_cells(grid, paddings)
    around: Array = np.zeros(padded)
    for kind, weight in terms:
        quadrant = influence_coefficients(grid, paddings, kind)
        around += weight * mirrored_by_parity(quadrant, padded, kind.parity)
    return around


def by_symmetry(
    response: Mapping[Coefficients, float],
) -> tuple[Mapping[Coefficients, float], Mapping[Coefficients, float]]:
    """Return the part of `response` with coefficients that are even along both axes, and the part with all others."""
    even = {kind: weight for kind, weight in response.items() if kind.parity == (1, 1)}
    return even, {kind: weight for kind, weight in response.items() if kind not in even}


def weighted_sum(operators: Iterable[tuple[float, Convolution]], local_compliance: float = 0.0) -> Convolution:
    """Return the sum of `operators` on one grid, each times its weight.

    `local_compliance` [m/Pa] times the pressure itself is added: a constant in the spectrum, also on coarser grids.
    """
    first, *others = (operator.scaled(weight, Precision.DOUBLE) for weight, operator in operators)
    spectrum = sum((operator.spectrum for operator in others), start=first.spectrum)
    return replace(first, spectrum=spectrum + local_compliance)


def padded_cells(grid: Grid, paddings: Paddings) -> tuple[int, int]:
    """Return the number of points (px, py) of the transforms on `grid`."""
    px, py = (
        n if padding.wraps else 2 * fft.next_fast_len(n, real=real)
        for n, padding, real in zip(grid.cells, paddings, (False, True), strict=True)
    )
    return px, py


def mirrored_by_parity(coefficients: Array, padded: tuple[int, int], parity: tuple[int, int]) -> Array:
    """Return `coefficients` at known offsets (x, y), extended by parity to all points (px, py) of a padded grid."""
    around = coefficients[np.ix_(*map(_offset_indices, coefficients.shape, padded))]
    for axis, even in enumerate(parity):
        if even < 0:  # odd: zero at the origin and at half the period
            n = padded[axis]
            index = np.arange(n)
            sign = np.sign(n - 2 * index) * (index > 0)
            around *= np.expand_dims(sign, 1 - axis)
    return around


def _offset_indices(known: int, padded: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Return the distance in cells of each point (padded,) of a periodic axis from its first one, at most ``known - 1``.

    Offsets that no pair of cells has repeat the last known one.
    """
    index = np.arange(padded)
    return np.minimum(np.minimum(index, padded - index), known - 1)

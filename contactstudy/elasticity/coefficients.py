"""Influence coefficients on a grid: every offset within one period, all images that a padding includes."""

from collections.abc import Callable
from dataclasses import dataclass
from math import log
from typing import ClassVar, Protocol

import numpy as np

from contactstudy.domain.grid import Array, Grid, Padding, Paddings
from contactstudy.elasticity.kernels.displacement import (
    boussinesq_cell,
    boussinesq_cell_doubly_periodic,
    boussinesq_cell_periodic,
)


class Coefficients(Protocol):
    """Influence coefficients: the response to one loaded cell at offsets x and y, alone or with its periodic images.

    Methods take offsets and lengths in one unit and return one coefficient for each offset. `dx` and `dy` are the sides
    of the cell, `width` and `period` the distances between images along x and y.
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
        Lateral distance [m] from which displacement is counted, where an infinite row of images leaves that open; with a
        lattice of images it is counted from its mean.
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
        """Return what the datum adds to the response to a row of images, whose area is `line` [m] per length."""
        return 2 * line * log(self.datum)

    def lattice(self, x: Array, y: Array, dx: float, dy: float, width: float, period: float) -> Array:
        """Return the response to an infinite lattice of images along both axes; x is a column, y a row."""
        return boussinesq_cell_doubly_periodic(x, y, dx, dy, width, period)


# Distance from the axis at which the row of mirrored loads does not displace a body with free faces, over its length.
# The loads beyond the two neighbouring ones then do not displace the middle.
DATUM_OVER_LENGTH = 3.0


@dataclass(frozen=True)
class FreeFaceCoefficients(BoussinesqCoefficients):
    """Coefficients of a body with two free faces; :mod:`~contactstudy.elasticity.free_faces` makes its operator of them.

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
        """Return those of a body, with the datum `DATUM_OVER_LENGTH`."""
        return cls(DATUM_OVER_LENGTH * length, length, poisson_ratio)


@dataclass(frozen=True)
class _Axis:
    """Axis of a grid: number of `cells`, their size `step` [m], the `period` [m] of its images, and its padding."""

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
        if along.padding.window is None:
            return coefficients.row(x[:, None], along.offsets, *cell, along.period)
        return _summed(lambda y: coefficients.cell(x, y[:, None], *cell), along, even_y).T

    return _summed(columns, across, even_x)


def _summed(coefficients: Callable[[Array], Array], axis: _Axis, parity: int) -> Array:
    """Return the sum of ``coefficients(d + m L)`` over the periods m of the axis's window, for its known offsets d.

    `coefficients` is even or odd in its argument, so that the offsets of one period serve two images: the one ahead and,
    reversed, the next one behind. Far images are added first: small terms are summed before large ones.
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

"""Influence coefficients on a grid: every offset within one period, all images that a padding includes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Padding, Paddings
from contactstudy.elasticity.kernels.displacement import (
    boussinesq_cell,
    boussinesq_cell_doubly_periodic,
    boussinesq_cell_periodic,
)


class Coefficients(Protocol):
    """The response to one loaded cell at offsets x and y: alone, in a row of images, in a lattice of images."""

    @property
    def parity(self) -> tuple[int, int]:
        """For each axis, 1 if even along it and -1 if odd."""
        ...

    def turned(self) -> "Coefficients":
        """Return these coefficients with the axes exchanged."""
        ...

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Coefficients of a single cell at offsets x and y, which broadcast."""
        ...

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """An infinite row of images along y; x is a column, y a row."""
        ...

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """An infinite lattice of images along both axes; x is a column, y a row."""
        ...


@dataclass(frozen=True)
class Displacement:
    """pi E* times the displacement [m] under unit pressure.

    ``datum`` [m]: the lateral distance from which displacement is counted, where an infinite row of images
    leaves that open; with a lattice of images it is counted from its mean.
    """

    datum: float
    parity: ClassVar[tuple[int, int]] = (1, 1)

    def turned(self) -> "Displacement":
        """Itself: the coefficients do not change when the axes are exchanged."""
        return self

    def cell(self, x: Array, y: Array, dx: float, dy: float) -> Array:
        """Coefficients of a single cell at offsets x and y, which broadcast."""
        return boussinesq_cell(x, y, dx, dy)

    def row(self, x: Array, y: Array, dx: float, dy: float, period: float) -> Array:
        """An infinite row of images along y."""
        shift = 2 * dx * dy / period * np.log(self.datum)
        return np.asarray(shift + boussinesq_cell_periodic(x, y, dx, dy, period))

    def lattice(
        self, x: Array, y: Array, dx: float, dy: float, width: float, period: float
    ) -> Array:
        """An infinite lattice of images."""
        return boussinesq_cell_doubly_periodic(x, y, dx, dy, width, period)


@dataclass(frozen=True)
class _Axis:
    cells: int
    step: float
    period: float
    padding: Padding

    @property
    def known(self) -> int:
        """The number of offsets to evaluate: the others on a circle follow by symmetry."""
        return self.cells // 2 + 1 if self.padding.wraps else self.cells

    @property
    def offsets(self) -> Array:
        return np.arange(float(self.known)) * self.step


def kernel(grid: Grid, paddings: Paddings, coefficients: Coefficients) -> Array:
    """``coefficients`` at offsets of 0, 1, 2 ... cells, summed over the images that the paddings include.

    An axis of n cells that wraps has ``n // 2 + 1`` offsets, any other axis n.
    """
    axes = zip(grid.cells, grid.cell, grid.extent, paddings, strict=True)
    across, along = (_Axis(*axis) for axis in axes)
    return _kernel(across, along, coefficients)


def _kernel(across: _Axis, along: _Axis, coefficients: Coefficients) -> Array:
    cell = across.step, along.step
    if across.padding.window is None:
        if along.padding.window is not None:
            return _kernel(along, across, coefficients.turned()).T
        x, y = across.offsets[:, None], along.offsets
        return coefficients.lattice(x, y, *cell, across.period, along.period)
    even_x, even_y = coefficients.parity

    def columns(x: Array) -> Array:
        if along.padding.window is None:
            return coefficients.row(x[:, None], along.offsets, *cell, along.period)
        return _summed(lambda y: coefficients.cell(x, y[:, None], *cell), along, even_y).T

    return _summed(columns, across, even_x)


def _summed(at: Callable[[Array], Array], axis: _Axis, parity: int) -> Array:
    """The sum of ``at(d + m L)`` over the periods m of the axis's window, for its known offsets d.

    ``at`` is even or odd, and takes distances along its first axis. The offsets of one period therefore serve
    two images: the one ahead and, reversed, the next one behind. Far images are added first, so that
    small terms are summed before large ones.
    """
    window, count = axis.padding.window, axis.cells
    assert window is not None
    total: Array | float = 0.0
    for period in range(max(window[-1], -window[0] - 1), -1, -1):
        is_ahead, is_behind = period in window, -period - 1 in window
        distances = np.arange(count + 1.0) if is_behind else np.arange(float(axis.known))
        block = at((period * count + distances) * axis.step)
        if is_ahead:
            total = total + block[: axis.known]
        if is_behind:
            total = total + parity * block[: -axis.known - 1 : -1]
    return np.asarray(total)

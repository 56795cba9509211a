"""How the length direction is represented: which images of the pressure a point sees.

A padding is a value that knows two things: its influence coefficients at all offsets within one
period, and whether the convolution along the length closes on itself (``wraps``, ny points) or is
padded with zeros (2 ny points).
"""

from dataclasses import dataclass
from math import inf
from typing import ClassVar, Protocol

import numpy as np

from contactstudy.arrays import Array
from contactstudy.checks import whole
from contactstudy.grid import Grid
from contactstudy.influence import boussinesq_cell, boussinesq_cell_periodic


class Padding(Protocol):
    """A representation of the periodic direction."""

    @property
    def wraps(self) -> bool:
        """Whether the convolution along the length is circular."""
        ...

    def reach(self, period: float) -> float:
        """How far to each side a point in the middle sees pressure; unit of ``period``."""
        ...

    def influence(self, grid: Grid, datum: float) -> Array:
        """Influence coefficients [m] at offsets of 0, 1, ... cells, even along both axes.

        Shape (nx, ny), or (nx, ny // 2 + 1) where the length wraps. ``datum`` [m] is the lateral
        distance at which the displacement is counted as zero, where images leave that open.
        """
        ...


@dataclass(frozen=True)
class ZeroPadding:
    """No neighbours: the classical DC-FFT, not periodic (Liu, Wang & Liu 2000)."""

    wraps: ClassVar[bool] = False

    def reach(self, period: float) -> float:
        """Half a period: the domain itself."""
        return period / 2

    def influence(self, grid: Grid, datum: float) -> Array:
        """The coefficient of the cell alone."""
        return boussinesq_cell(*_offsets(grid, grid.cells[1]), *grid.cell)


@dataclass(frozen=True)
class DuplicatedPadding:
    """The padded half of the length filled with a copy of the pressure (the paper's Figure 2b).

    Every point then sees the pressure within one period to either side of itself. The doubled
    transform of the paper is the same as a circular one over the folded coefficients
    ``K(d) + K(d - period)``, which is what is done here.
    """

    wraps: ClassVar[bool] = True

    def reach(self, period: float) -> float:
        """One period, from any point."""
        return period

    def influence(self, grid: Grid, datum: float) -> Array:
        """The cell and its copy one period back."""
        x, y = _offsets(grid, grid.cells[1] // 2 + 1)
        return boussinesq_cell(x, y, *grid.cell) + boussinesq_cell(x, grid.period - y, *grid.cell)


@dataclass(frozen=True)
class Superposition:
    """Coefficients summed over ``images`` periods on each side (the paper's eq. 5), zero-padded.

    The window of images is centred on the domain and not on the observer, so that points near the
    ends of the domain see more pressure on one side. ``images`` is a whole number from 0 on;
    0 is :class:`ZeroPadding`.
    """

    images: int

    wraps: ClassVar[bool] = False

    def __post_init__(self) -> None:
        whole("Superposition.images", self.images, 0, "give a whole number of periods from 0 on")

    def reach(self, period: float) -> float:
        """Half a period and ``images`` more."""
        return (self.images + 0.5) * period

    def influence(self, grid: Grid, datum: float) -> Array:
        """The sum over ``2 images + 1`` periods."""
        x, y = _offsets(grid, grid.cells[1] + 1)
        total = np.zeros((grid.cells[0], grid.cells[1]))
        # Far images first: small terms add up before they meet the large ones. One block of offsets
        # serves the image ahead and, read backwards, the next one behind.
        for m in range(self.images, -1, -1):
            block = boussinesq_cell(x, y + m * grid.period, *grid.cell)
            total += block[:, :-1]
            if m < self.images:
                total += block[:, :0:-1]
        return total


@dataclass(frozen=True)
class ExactPeriodicity:
    """All images, in closed form.

    The displacement under infinitely many loads is bounded only up to a rigid shift; here it is
    counted from a lateral distance of the scene's length scale (for a cylinder, the Hertz
    half-width), where the mean line load concentrated on the axis would move nothing.
    """

    wraps: ClassVar[bool] = True

    def reach(self, period: float) -> float:
        """Without end."""
        return inf

    def influence(self, grid: Grid, datum: float) -> Array:
        """The lattice sum, its zero moved to the lateral distance ``datum`` [m]."""
        x, y = _offsets(grid, grid.cells[1] // 2 + 1)
        shift = 2 * grid.cell_area / grid.period * np.log(datum)
        return np.asarray(boussinesq_cell_periodic(x, y, *grid.cell, grid.period) + shift)


def _offsets(grid: Grid, along: int) -> tuple[Array, Array]:
    """Offsets [m] of 0, 1, ... cells: across as a column, and ``along`` of them as a row."""
    dx, dy = grid.cell
    return np.arange(0.0, grid.cells[0])[:, None] * dx, np.arange(0.0, along)[None, :] * dy

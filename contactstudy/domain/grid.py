"""A grid of equal rectangular cells over the width and one period of the length."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.checks import InvalidInput, answers_typos, in_range, pair, whole
from contactstudy.domain.fields import Array
from contactstudy.domain.units import Metres

LONGEST = 1e9  # times as long as wide


@answers_typos
@dataclass(frozen=True)
class Grid:
    """Grid of equal rectangular cells, centred on the origin.

    x runs across the contact, y along it. Fields are constant in a cell and have the shape (nx, ny).

    Parameters
    ----------
    cells
        Number of cells (nx, ny), across and along; ``ny = 1`` is plane strain.
    extent
        Width and period (across, along) [m].

    Raises
    ------
    InvalidInput
        If there are fewer than two cells across or none along, if the extent is no positive length, or if the
        aspect ratio of a cell exceeds 1e9, where its influence coefficients would be lost in rounding.
    """

    cells: tuple[int, int]
    extent: tuple[Metres, Metres]

    def __post_init__(self) -> None:
        nx, ny = pair("Grid.cells", self.cells, "give two whole numbers, (across, along)")
        width, period = pair("Grid.extent", self.extent, "give two lengths, (width, period) [m]")
        cells = (
            whole("Grid.cells[0]", nx, 2, "give at least 2 cells across the width"),
            whole("Grid.cells[1]", ny, 1, "give at least 1 cell along the length"),
        )
        extent = (
            in_range("Grid.extent[0]", width, "give a width above 0 m"),
            in_range("Grid.extent[1]", period, "give a period above 0 m"),
        )
        object.__setattr__(self, "cells", cells)
        object.__setattr__(self, "extent", extent)
        elongation = self.cell[1] / self.cell[0]
        if not 1 / LONGEST <= elongation <= LONGEST:
            raise InvalidInput(
                f"Grid.extent is {extent!r}: give lengths whose cells are no more than {LONGEST:g} times as "
                f"long as wide, or as wide as long; these are {elongation:g} times as long."
            )

    @property
    def cell(self) -> tuple[float, float]:
        """Sides of a cell (dx, dy) [m]."""
        return self.extent[0] / self.cells[0], self.extent[1] / self.cells[1]

    @property
    def cell_area(self) -> float:
        """Area of a cell, dx dy [m^2]."""
        return self.cell[0] * self.cell[1]

    @property
    def period(self) -> float:
        """Extent along the length [m]."""
        return self.extent[1]

    @property
    def x(self) -> Array:
        """Cell centres across the width, shape (nx,) [m], antisymmetric to the last bit."""
        return _centres(self.cells[0], self.cell[0])

    @property
    def y(self) -> Array:
        """Cell centres along the length, shape (ny,) [m], antisymmetric to the last bit."""
        return _centres(self.cells[1], self.cell[1])


def _centres(count: int, step: float) -> Array:
    """Return the centres of `count` cells of size `step`, antisymmetric to the last bit."""
    return np.asarray((2 * np.arange(count) - (count - 1)) * (step / 2))

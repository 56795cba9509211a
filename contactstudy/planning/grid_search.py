"""Error and cost expected of a grid, and grids that follow from them."""

from dataclasses import dataclass
from math import inf

import numpy as np

from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.planning.cost import (
    memory,
)
from contactstudy.planning.grid_requirements import (
    halvable,
)
from contactstudy.solvers.solution import Solution

# Largest factor by which the cells along an axis are extrapolated at once.
MAX_EXTRAPOLATION = 16.0


@dataclass(frozen=True)
class GridForecast:
    """Error and cost to expect of a solve on a grid.

    Attributes
    ----------
    grid
        The grid.
    errors
        Contributions (across, along) to the relative L1 error of the pressure; infinite if they are not known.
    orders
        Orders of convergence along each axis.
    min_cells
        Least cells along each axis that resolve the surface.
    outgrows_grid
        Whether the contact outgrows the grid.
    message
        A fault that no grid corrects, such as an infinite pressure; empty without one.
    seconds
        Seconds of a solve with its estimate on one thread, and of the coarser grids of a solve to an error.
    """

    grid: Grid
    errors: tuple[float, float]
    orders: tuple[float, float]
    min_cells: tuple[int, int]
    outgrows_grid: bool
    message: str
    seconds: float

    @property
    def error(self) -> float:
        """Relative L1 error of the pressure to expect on the grid."""
        return sum(self.errors)

    def errors_of(self, cell: tuple[float, float]) -> tuple[float, float]:
        """Return the contributions (across, along) to the error to expect of another cell (dx, dy) [m]."""
        parts = zip(self.errors, self.orders, cell, self.grid.cell, strict=True)
        across, along = (
            error * (size / present) ** order if error else 0.0
            for error, order, size, present in parts
        )
        return across, along

    def error_of(self, cell: tuple[float, float]) -> float:
        """Return the relative L1 error of the pressure to expect of another cell (dx, dy) [m]."""
        return sum(self.errors_of(cell))

    def grid_for(self, error: float) -> Grid:
        """Return the grid of min_cells cells and the same extent whose expected error is `error`.

        With errors ``e_x n_x^-r_x + e_y n_y^-r_y``, the product of both counts is least where ``r_x`` times the error
        across equals ``r_y`` times that along. An axis at its least cells leaves the remaining error to the other.
        """
        (across, along), (order_x, order_y) = self.errors, self.orders
        if self.grid.cells[1] == 1 or not along:
            return self._with(self._count(0, error), self.grid.cells[1])
        nx = self._count(0, error * order_y / (order_x + order_y))
        ny = self._count(1, error - across * (self.grid.cells[0] / nx) ** order_x)
        return self._with(self._count(0, error - along * (self.grid.cells[1] / ny) ** order_y), ny)

    def _count(self, axis: int, error: float) -> float:
        """Return the cells along an axis for the contribution `error` to the error."""
        count, fraction, order = self.grid.cells[axis], self.errors[axis], self.orders[axis]
        needed = count * (fraction / error) ** (1 / order) if error > 0 else inf
        return max(min(needed, MAX_EXTRAPOLATION * count), self.min_cells[axis])

    def _with(self, across: float, along: float) -> Grid:
        """Return a grid of at least these cells and the same extent."""
        ny = 1 if self.grid.cells[1] == 1 else halvable(along, self.min_cells[1])
        return Grid((halvable(across, self.min_cells[0]), ny), self.grid.extent)


def contact_width(solution: Solution) -> float:
    """Return the width [m] about the axis within which all cells in contact lie."""
    grid = solution.problem.grid
    touching = np.abs(grid.x[solution.pressure.any(axis=1)])
    return float(2 * touching.max(initial=0.0)) + grid.cell[0]


def with_width(grid: Grid, width: float) -> Grid:
    """Return a grid with cells of the same size over the width `width` [m]."""
    across = halvable(grid.cells[0] * width / grid.extent[0])
    return Grid((across, grid.cells[1]), (width, grid.period))


def affordable(grid: Grid, padding: Padding | Paddings, bytes_at_most: float) -> Grid:
    """Return `grid`, or the finest of the same extent and elongation whose solve holds within `bytes_at_most`."""
    needed = memory(grid, padding)
    while needed > bytes_at_most:
        shrink = (bytes_at_most / needed) ** (1 if grid.cells[1] == 1 else 0.5) * 0.99
        across, along = (max(2, int(count * shrink)) for count in grid.cells)
        grid = Grid((across, along if grid.cells[1] > 1 else 1), grid.extent)
        needed = memory(grid, padding)
    return grid

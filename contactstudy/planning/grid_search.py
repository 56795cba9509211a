"""Error and cost to expect of a grid, from solutions on coarser grids, halved along each axis."""

from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, inf, log2, prod, sqrt

import numpy as np

from contactstudy.accuracy.coarser import change
from contactstudy.accuracy.estimate import SHARP_EDGE, error_estimate
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.planning.cost import (
    DIGITS,
    SMOOTH_CONVOLUTIONS,
    CostModel,
    memory,
    timed,
)
from contactstudy.planning.grid_requirements import (
    MIN_CELLS_PER_AXIS,
    ROUGH_ORDER,
    GridRequirements,
    halvable,
)
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact


@dataclass(frozen=True)
class ForecastConstants:
    """Constants of a forecast for a grid.

    Attributes
    ----------
    max_cells_1d
        Most cells of a coarse solution in plane strain.
    max_cells_2d
        Most cells of a coarse solution that varies along the length.
    max_cells_fine
        The same where a surface needs more to be resolved.
    tolerance
        Tolerance of solutions on cells halved along one axis.
    min_order
        Least order of convergence, as at a step in height.
    usual_order
        Order where it is not observed.
    max_order
        Largest order, that of a smooth contact.
    bound_rough
        Ratio of an error's upper estimate to the error expected, on rough surfaces; it is exceeded in few cases of the
        accuracy study.
    bound_smooth
        The same on smooth surfaces.
    min_cells
        Least cells along an axis of a coarse solution.
    min_cells_of_roller
        The same along a roller.
    estimate_cost
        Seconds of a solve with its error estimate, which takes another on cells of twice the size, over those of one
        solve.
    widening
        Factor on a width that the contact outgrows.
    max_extrapolation
        Largest factor by which the cells along an axis are extrapolated at once.
    unresolved_factor
        Factor on the law of rough contacts, a mean over surfaces, where coarse solutions do not resolve the surface.
    """

    max_cells_1d: int = 2**13
    max_cells_2d: int = 2**16
    max_cells_fine: int = 2**19
    tolerance: float = 1e-5
    min_order: float = 0.5
    usual_order: float = 1.0
    max_order: float = 1.5
    bound_rough: float = 1.5
    bound_smooth: float = 1.2
    min_cells: int = 8
    min_cells_of_roller: int = 16
    estimate_cost: float = 1.6
    widening: float = 1.5
    max_extrapolation: float = 16.0
    unresolved_factor: float = 2.0


CONSTANTS = ForecastConstants()


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
        return max(min(needed, CONSTANTS.max_extrapolation * count), self.min_cells[axis])

    def _with(self, across: float, along: float) -> Grid:
        """Return a grid of at least these cells and the same extent."""
        ny = 1 if self.grid.cells[1] == 1 else halvable(along, self.min_cells[1])
        return Grid((halvable(across, self.min_cells[0]), ny), self.grid.extent)


def forecast(scene: Scene, requirements: GridRequirements, grid: Grid) -> GridForecast:
    """Return the error and the cost to expect of `grid`, extrapolated from solutions on coarser grids.

    The estimated error of the finest of them is divided between the axes in proportion to the changes of the pressure
    when the cells are halved along one axis alone, which also give the orders.
    """
    padding = requirements.padding()
    min_cells = _min_cells(requirements, grid)
    small = _coarse(grid, min_cells)
    # to the default tolerance, so that its time is that of a solve
    fine, timing = timed(lambda grid: scene.problem(grid, padding), small, 10.0**-DIGITS)
    estimate = error_estimate(fine)
    sharp = next((warning for warning in estimate.warnings if SHARP_EDGE in warning), "")
    error = estimate.l1.by_cause["discretisation"] / bound_factor(requirements)
    changes, orders = [0.0, 0.0], [CONSTANTS.usual_order, CONSTANTS.usual_order]
    for axis in range(2 if error < inf else 0):
        solutions = [fine]
        while len(solutions) < 3 and small.cells[axis] >= CONSTANTS.min_cells * 2 ** len(solutions):
            halved = list(small.cells)
            halved[axis] = ceil(halved[axis] / 2 ** len(solutions))
            coarser = Grid((halved[0], halved[1]), small.extent)
            solutions.append(
                solve_contact(scene.problem(coarser, padding), SolveOptions(CONSTANTS.tolerance))
            )
        steps = [change(fine, coarse).l1 for fine, coarse in pairwise(solutions)]
        changes[axis] = steps[0] if steps else 0.0
        is_resolved = small.cells[axis] >= 4 * min_cells[axis] or not requirements.rough
        if len(steps) > 1 and min(steps) > 0 and is_resolved:
            orders[axis] = float(
                np.clip(log2(steps[1] / steps[0]), CONSTANTS.min_order, CONSTANTS.max_order)
            )
    fractions = np.array(changes) / sum(changes) if sum(changes) else np.array([1.0, 0.0])
    coarse_forecast = GridForecast(
        small,
        (error, 0.0) if error == inf else (error * fractions[0], error * fractions[1]),
        (orders[0], orders[1]),
        min_cells,
        fine.status is Status.CONTACT_AT_EDGE,
        sharp,
        CONSTANTS.estimate_cost * CostModel((timing,)).seconds(grid, padding, timing.convolutions),
    )
    return replace(coarse_forecast, grid=grid, errors=coarse_forecast.errors_of(grid.cell))


def bound_factor(requirements: GridRequirements) -> float:
    """Return the ratio of an error's upper estimate to the error expected."""
    return CONSTANTS.bound_rough if requirements.rough else CONSTANTS.bound_smooth


def _min_cells(requirements: GridRequirements, grid: Grid) -> tuple[int, int]:
    """Return the least cells (across, along) that resolve the surface."""
    least = CONSTANTS.min_cells_of_roller if requirements.roller else MIN_CELLS_PER_AXIS
    across, along = (
        max(least, ceil(extent / length * (1 - 1e-9)))
        for extent, length in zip(grid.extent, requirements.finest, strict=True)
    )
    return across, along if grid.cells[1] > 1 else 1


def _coarse(grid: Grid, min_cells: tuple[int, int]) -> Grid:
    """Return `grid` with few enough cells to be solved quickly, if so few resolve the surface."""
    max_cells = CONSTANTS.max_cells_1d if grid.cells[1] == 1 else CONSTANTS.max_cells_2d
    counts = [float(count) for count in grid.cells]
    # both axes alike; then each loses the cells that the other cannot
    for axis, power in ((0, 0.5 if grid.cells[1] > 1 else 1.0), (1, 1.0), (0, 1.0)):
        excess = max(prod(counts) / max_cells, 1.0)
        counts[axis] = max(counts[axis] / excess**power, min(min_cells[axis], counts[axis]))
    shrink = sqrt(max(prod(counts) / CONSTANTS.max_cells_fine, 1.0))
    across, along = (
        max(ceil(count / shrink), min(2, present))
        for count, present in zip(counts, grid.cells, strict=True)
    )
    return Grid((max(across, min(CONSTANTS.min_cells, grid.cells[0])), along), grid.extent)


def contact_width(solution: Solution) -> float:
    """Return the width [m] about the axis within which all cells in contact lie."""
    grid = solution.problem.grid
    touching = np.abs(grid.x[solution.pressure.any(axis=1)])
    return float(2 * touching.max(initial=0.0)) + grid.cell[0]


def has_error_law(scene: Scene, requirements: GridRequirements) -> bool:
    """Return whether the contact is Hertz's, whose error has a closed law."""
    return requirements.smooth and scene.hardness > requirements.hertz.peak_pressure


def forecast_or_law(scene: Scene, requirements: GridRequirements, grid: Grid) -> GridForecast:
    """Return the error and the cost to expect of `grid`: by the law of a smooth contact, else from coarse solutions.

    Parameters
    ----------
    scene
        The scene.
    requirements
        Its requirements.
    grid
        The grid.
    """
    padding = requirements.padding()
    if has_error_law(scene, requirements):
        seconds = CONSTANTS.estimate_cost * CostModel().seconds(grid, padding, SMOOTH_CONVOLUTIONS)
        width = 2 * requirements.hertz.half_width
        return GridForecast(
            grid,
            (requirements.error(grid.cell), 0.0),
            (ROUGH_ORDER, ROUGH_ORDER),
            (MIN_CELLS_PER_AXIS, 1),
            grid.extent[0] < width,
            "",
            seconds,
        )
    min_cells = _min_cells(requirements, grid)
    try:
        result = forecast(scene, requirements, grid)
    except InvalidInput as error:  # such as a period that is no whole number of a shape's
        orders = ROUGH_ORDER, ROUGH_ORDER
        return GridForecast(
            grid,
            (inf, 0.0),
            orders,
            min_cells,
            outgrows_grid=False,
            message=str(error),
            seconds=inf,
        )
    if result.error == inf and not result.outgrows_grid:
        across, along = requirements.errors(grid.cell)
        return replace(
            result,
            errors=(CONSTANTS.unresolved_factor * across, CONSTANTS.unresolved_factor * along),
            orders=(ROUGH_ORDER, ROUGH_ORDER),
        )
    return result


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

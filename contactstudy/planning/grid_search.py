"""Error and cost to expect of a grid, by small solutions and what they show along each axis."""

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
    COARSEST,
    ROUGH_ORDER,
    GridRequirements,
    halvable,
)
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Cells of a small solution at most, in one and in two dimensions, more of them where the surface is finer; and the
# tolerance that it is solved to.
MAX_CELLS_1D, MAX_CELLS_2D, MAX_CELLS_FINE, TOLERANCE = 2**13, 2**16, 2**19, 1e-5
# Powers of the cell with which an error falls: at a step in height, where it is not observed, and of a smooth contact.
MIN_RATE, USUAL_RATE, MAX_RATE = 0.5, 1.0, 1.5
# Ratio of an error's upper estimate to the error expected, of rough and of smooth surfaces: exceeded in all but a few
# cases of the accuracy matrix.
BOUND_ROUGH, BOUND_SMOOTH = 1.5, 1.2
# Least cells along an axis of a small solution, and of a roller.
MIN_CELLS, MIN_CELLS_OF_ROLLER = 8, 16
# Seconds of a solve with its error estimate, which takes another on cells of twice the size, over those of one solve.
ESTIMATE_COST = 1.6
# Factor on a width that is too narrow.
WIDENING = 1.5
# Largest factor by which the cells along an axis are extrapolated at once.
MAX_EXTRAPOLATION = 16.0
# The law of rough contacts, a mean over surfaces, is multiplied by this where small solutions do not show the surface.
UNRESOLVED_FACTOR = 2.0


@dataclass(frozen=True)
class GridForecast:
    """Error and cost to expect of a solve on a grid.

    Attributes
    ----------
    grid
        The grid.
    errors
        Contributions (across, along) to the relative L1 error of the pressure; infinite if they are not known.
    rates
        Powers of the cell along each axis with which they fall.
    fewest
        Least cells along each axis that show the surface at all.
    cut_off
        Whether the contact outgrows the grid.
    message
        A fault that no grid corrects, such as an infinite pressure; empty without one.
    seconds
        Seconds of a solve with its estimate on one thread, and of the coarser grids of a solve to an error.
    """

    grid: Grid
    errors: tuple[float, float]
    rates: tuple[float, float]
    fewest: tuple[int, int]
    cut_off: bool
    message: str
    seconds: float

    @property
    def error(self) -> float:
        """Relative L1 error of the pressure to expect on the grid."""
        return sum(self.errors)

    def errors_of(self, cell: tuple[float, float]) -> tuple[float, float]:
        """Return the contributions (across, along) to the error to expect of another cell (dx, dy) [m]."""
        parts = zip(self.errors, self.rates, cell, self.grid.cell, strict=True)
        across, along = (
            error * (size / present) ** rate if error else 0.0
            for error, rate, size, present in parts
        )
        return across, along

    def error_of(self, cell: tuple[float, float]) -> float:
        """Return the relative L1 error of the pressure to expect of another cell (dx, dy) [m]."""
        return sum(self.errors_of(cell))

    def grid_for(self, error: float) -> Grid:
        """Return the grid of fewest cells and the same extent whose expected error is `error`.

        With errors ``e_x n_x^-r_x + e_y n_y^-r_y``, the product of both counts is least where ``r_x`` times the error
        across equals ``r_y`` times that along. An axis at its fewest cells leaves the remaining error to the other.
        """
        (across, along), (rate_x, rate_y) = self.errors, self.rates
        if self.grid.cells[1] == 1 or not along:
            return self._with(self._count(0, error), self.grid.cells[1])
        nx = self._count(0, error * rate_y / (rate_x + rate_y))
        ny = self._count(1, error - across * (self.grid.cells[0] / nx) ** rate_x)
        return self._with(self._count(0, error - along * (self.grid.cells[1] / ny) ** rate_y), ny)

    def _count(self, axis: int, error: float) -> float:
        """Return the cells along an axis for the contribution `error` to the error."""
        count, fraction, rate = self.grid.cells[axis], self.errors[axis], self.rates[axis]
        needed = count * (fraction / error) ** (1 / rate) if error > 0 else inf
        return max(min(needed, MAX_EXTRAPOLATION * count), self.fewest[axis])

    def _with(self, across: float, along: float) -> Grid:
        """Return a grid of at least these cells and the same extent."""
        ny = 1 if self.grid.cells[1] == 1 else halvable(along, self.fewest[1])
        return Grid((halvable(across, self.fewest[0]), ny), self.grid.extent)


def forecast(scene: Scene, requirements: GridRequirements, grid: Grid) -> GridForecast:
    """Return the error and the cost to expect of `grid`, extrapolated from solutions on coarser grids.

    The estimated error of the finest of them is shared between the axes in proportion to the changes of the pressure
    when the cells are halved along one axis alone, which also show the rates.
    """
    padding = requirements.padding()
    fewest = _fewest(requirements, grid)
    small = _coarse(grid, fewest)
    # to the default tolerance, so that its time shows the cost of a solve
    fine, timing = timed(lambda grid: scene.problem(grid, padding), small, 10.0**-DIGITS)
    estimate = error_estimate(fine)
    sharp = next((warning for warning in estimate.warnings if SHARP_EDGE in warning), "")
    error = estimate.l1.by_cause["discretisation"] / bound_factor(requirements)
    changes, rates = [0.0, 0.0], [USUAL_RATE, USUAL_RATE]
    for axis in range(2 if error < inf else 0):
        solutions = [fine]
        while len(solutions) < 3 and small.cells[axis] >= MIN_CELLS * 2 ** len(solutions):
            halved = list(small.cells)
            halved[axis] = ceil(halved[axis] / 2 ** len(solutions))
            coarser = Grid((halved[0], halved[1]), small.extent)
            solutions.append(
                solve_contact(scene.problem(coarser, padding), SolveOptions(TOLERANCE))
            )
        steps = [change(fine, coarse).l1 for fine, coarse in pairwise(solutions)]
        changes[axis] = steps[0] if steps else 0.0
        is_resolved = small.cells[axis] >= 4 * fewest[axis] or not requirements.rough
        if len(steps) > 1 and min(steps) > 0 and is_resolved:
            rates[axis] = float(np.clip(log2(steps[1] / steps[0]), MIN_RATE, MAX_RATE))
    fractions = np.array(changes) / sum(changes) if sum(changes) else np.array([1.0, 0.0])
    coarse_forecast = GridForecast(
        small,
        (error, 0.0) if error == inf else (error * fractions[0], error * fractions[1]),
        (rates[0], rates[1]),
        fewest,
        fine.status is Status.CONTACT_AT_EDGE,
        sharp,
        ESTIMATE_COST * CostModel((timing,)).seconds(grid, padding, timing.convolutions),
    )
    return replace(coarse_forecast, grid=grid, errors=coarse_forecast.errors_of(grid.cell))


def bound_factor(requirements: GridRequirements) -> float:
    """Return the ratio of an error's upper estimate to the error expected."""
    return BOUND_ROUGH if requirements.rough else BOUND_SMOOTH


def _fewest(requirements: GridRequirements, grid: Grid) -> tuple[int, int]:
    """Return the cells (across, along) below which a grid does not show the surface."""
    least = MIN_CELLS_OF_ROLLER if requirements.roller else COARSEST
    across, along = (
        max(least, ceil(extent / length * (1 - 1e-9)))
        for extent, length in zip(grid.extent, requirements.finest, strict=True)
    )
    return across, along if grid.cells[1] > 1 else 1


def _coarse(grid: Grid, fewest: tuple[int, int]) -> Grid:
    """Return `grid` with few enough cells to be solved quickly, if so few show the surface."""
    max_cells = MAX_CELLS_1D if grid.cells[1] == 1 else MAX_CELLS_2D
    counts = [float(count) for count in grid.cells]
    # both axes alike; then each makes up for cells that the other cannot lose
    for axis, power in ((0, 0.5 if grid.cells[1] > 1 else 1.0), (1, 1.0), (0, 1.0)):
        excess = max(prod(counts) / max_cells, 1.0)
        counts[axis] = max(counts[axis] / excess**power, min(fewest[axis], counts[axis]))
    shrink = sqrt(max(prod(counts) / MAX_CELLS_FINE, 1.0))
    across, along = (
        max(ceil(count / shrink), min(2, present))
        for count, present in zip(counts, grid.cells, strict=True)
    )
    return Grid((max(across, min(MIN_CELLS, grid.cells[0])), along), grid.extent)


def contact_width(solution: Solution) -> float:
    """Return the width [m] about the axis within which all cells in contact lie."""
    grid = solution.problem.grid
    touching = np.abs(grid.x[solution.pressure.any(axis=1)])
    return float(2 * touching.max(initial=0.0)) + grid.cell[0]


def has_error_law(scene: Scene, requirements: GridRequirements) -> bool:
    """Return whether the contact is Hertz's, whose error has a closed law."""
    return requirements.smooth and scene.hardness > requirements.hertz.peak_pressure


def forecast_or_law(scene: Scene, requirements: GridRequirements, grid: Grid) -> GridForecast:
    """Return the error and the cost to expect of `grid`: by the law of a smooth contact, else by small solutions.

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
        seconds = ESTIMATE_COST * CostModel().seconds(grid, padding, SMOOTH_CONVOLUTIONS)
        width = 2 * requirements.hertz.half_width
        return GridForecast(
            grid,
            (requirements.error(grid.cell), 0.0),
            (ROUGH_ORDER, ROUGH_ORDER),
            (COARSEST, 1),
            grid.extent[0] < width,
            "",
            seconds,
        )
    fewest = _fewest(requirements, grid)
    try:
        result = forecast(scene, requirements, grid)
    except InvalidInput as error:  # such as a period that is no whole number of a shape's
        rates = ROUGH_ORDER, ROUGH_ORDER
        return GridForecast(
            grid, (inf, 0.0), rates, fewest, cut_off=False, message=str(error), seconds=inf
        )
    if result.error == inf and not result.cut_off:
        across, along = requirements.errors(grid.cell)
        return replace(
            result,
            errors=(UNRESOLVED_FACTOR * across, UNRESOLVED_FACTOR * along),
            rates=(ROUGH_ORDER, ROUGH_ORDER),
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

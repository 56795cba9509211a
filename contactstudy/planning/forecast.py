"""Forecasts of error and cost, from the first grids of a refinement."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, prod
from time import process_time

from contactstudy.accuracy.discretisation.bound import SHARP_EDGE
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import Cpu
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.domain.imports import loaded
from contactstudy.planning.bounded_solution import BoundedSolution
from contactstudy.planning.cost import memory
from contactstudy.planning.grid_requirements import CONSTANTS as GRID
from contactstudy.planning.grid_requirements import GridRequirements, halvable_count
from contactstudy.planning.refinement import MOST_CELLS, OTHER_CAUSES, GridRefinement, contact_width
from contactstudy.scene.loads.resulting_load import Approach
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Status
from contactstudy.solvers.solve import SolveOptions, solve_contact


@dataclass(frozen=True)
class ForecastConstants:
    """Constants of a forecast.

    Attributes
    ----------
    max_cells
        Maximum number of cells of the grids that are solved for a forecast.
    given_error
        Relative L1 error up to which the first grids of a given grid are refined.
    unresolved_factor
        Factor on the law of rough contacts, which is a mean over surfaces, where coarse grids do not resolve this
        one.
    """

    max_cells: int = 2**14
    given_error: float = 1e-3
    unresolved_factor: float = 2.0


CONSTANTS = ForecastConstants()
# Largest numbers of cells (across, along) of the contact that says what images contribute, which vary little in a cell.
IMAGE_CELLS = 64, 32


# Largest factor on the cells along an axis of a grid for an error: no machine holds so many along both axes, and a Grid
# has a largest aspect ratio of its cells.
MAX_EXTRAPOLATION = 1024.0


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
        Minimum number of cells along each axis that resolve the surface.
    contact_exceeds_grid
        Whether the contact is wider than the grid.
    message
        A fault that no grid corrects, such as an infinite pressure; empty without one.
    half_width
        Half-width of the contact [m] on the finest grid that was solved; infinite where it is cut off.
    seconds
        Seconds on one thread of the grids that a solve begins with; 0 where they are none of a solve's.
    is_extrapolated
        Whether the grid is extrapolated from coarser grids.
    """

    grid: Grid
    errors: tuple[float, float]
    orders: tuple[float, float]
    min_cells: tuple[int, int]
    contact_exceeds_grid: bool
    message: str
    half_width: float
    seconds: float = 0.0
    is_extrapolated: bool = False

    @property
    def error(self) -> float:
        """Relative L1 error of the pressure to expect on the grid."""
        return sum(self.errors)

    def errors_of(self, cell: tuple[float, float]) -> tuple[float, float]:
        """Return the contributions (across, along) to the error to expect of another cell (dx, dy) [m]."""
        parts = zip(self.errors, self.orders, cell, self.grid.cell_size, strict=True)
        across, along = (
            error * (size / present_size) ** order if error else 0.0
            for error, order, size, present_size in parts
        )
        return across, along

    def error_of(self, cell: tuple[float, float]) -> float:
        """Return the relative L1 error of the pressure to expect of another cell (dx, dy) [m]."""
        return sum(self.errors_of(cell))

    def grid_for(self, error: float) -> Grid:
        """Return the grid of fewest cells and the same extent whose expected error is `error`.

        It has at most MAX_EXTRAPOLATION times the cells along an axis, where its expected error may be larger.
        With errors ``e_x n_x^-r_x + e_y n_y^-r_y``, the product of both counts is least where ``r_x`` times the error
        across equals ``r_y`` times that along. An axis at its minimum leaves the remaining error to the other.
        """
        (across, along), (order_x, order_y) = self.errors, self.orders
        if self.grid.cells[1] == 1 or not along:
            return self._with(self._count(0, error), self.grid.cells[1])
        nx = self._count(0, error * order_y / (order_x + order_y))
        ny = self._count(1, error - across * (self.grid.cells[0] / nx) ** order_x)
        return self._with(self._count(0, error - along * (self.grid.cells[1] / ny) ** order_y), ny)

    def _count(self, axis: int, error: float) -> float:
        """Return the cells along an axis for the contribution `error` to the error."""
        count, present_error, order = self.grid.cells[axis], self.errors[axis], self.orders[axis]
        needed = count * (present_error / error) ** (1 / order) if error > 0 else inf
        return max(min(needed, MAX_EXTRAPOLATION * count), self.min_cells[axis])

    def _with(self, across: float, along: float) -> Grid:
        """Return a grid of at least these cells and the same extent."""
        ny = 1 if self.grid.cells[1] == 1 else halvable_count(along, self.min_cells[1])
        return Grid((halvable_count(across, self.min_cells[0]), ny), self.grid.extent)


def forecast_of_refinement(
    scene: Scene, requirements: GridRequirements, error: float, period: float | None, limit: float
) -> GridForecast:
    """Return the forecast of the grid on which :func:`~contactstudy.planning.refinement.solve_to` is expected to end.

    Parameters
    ----------
    scene
        The scene.
    requirements
        Its requirements.
    error
        Relative L1 error of the pressure.
    period
        Length of the grid [m]; chosen if None.
    limit
        Bytes that a solve may hold.
    """
    stamps: list[float] = []
    refinement = replace(
        _refinement(scene, requirements, requirements.pressure_error(error)),
        most_cells=MOST_CELLS,
        most_solved=CONSTANTS.max_cells,
        progress=lambda *_: stamps.append(process_time()),
    )
    extent = requirements.grid(0.1, period).extent
    before, levels = 0, list[BoundedSolution]()
    while before < loaded():  # what is imported or compiled is not counted
        before = loaded()
        stamps[:] = [process_time()]
        levels = refinement.solve_levels(extent)
    seconds, last = stamps[-1] - stamps[0], levels[-1]
    grid = last.grid
    if not refinement.meets_error(last):
        following, is_last = refinement.next_grid(levels)
        if following is None or not is_last:
            if following is not None:  # a grid between
                finer = prod(following.cells) / prod(last.grid.cells)
                seconds += finer * (stamps[-1] - stamps[-2])
            cells = refinement.required_cells(levels)
            following = refinement.grid_of_fast_lengths(*cells, grid.extent)
        grid = within_memory(following, requirements.padding(), limit)
    forecast = _extrapolated(refinement, levels, grid)
    return replace(forecast, seconds=seconds, is_extrapolated=not refinement.meets_error(last))


def forecast_of_grid(scene: Scene, requirements: GridRequirements, grid: Grid) -> GridForecast:
    """Return the forecast of a `grid`: by the law of a smooth contact, else from the first grids of a refinement.

    Where these give no bound, it is a multiple of the law of rough contacts.

    Parameters
    ----------
    scene
        The scene.
    requirements
        Its requirements.
    grid
        The grid.
    """
    orders = (GRID.rough_order, GRID.rough_order)
    # the law is that of Hertz's contact under a given load
    is_hertz = requirements.is_smooth and not isinstance(scene.load, Approach)
    if is_hertz and scene.hardness > requirements.hertz.peak_pressure:
        return GridForecast(
            grid,
            (requirements.error(grid.cell_size), 0.0),
            orders,
            (GRID.min_cells, 1),
            grid.extent[0] < 2 * requirements.hertz.half_width,
            "",
            requirements.hertz.half_width,
        )
    refinement = replace(
        _refinement(scene, requirements, CONSTANTS.given_error),
        most_cells=min(prod(grid.cells), CONSTANTS.max_cells),
        keeps_width=True,
    )
    try:
        levels = refinement.solve_levels(grid.extent)
    except InvalidInput as error:  # such as a period that is no whole number of a shape's
        return GridForecast(
            grid,
            (inf, 0.0),
            orders,
            (1, 1),
            contact_exceeds_grid=False,
            message=str(error),
            half_width=requirements.half_width,
        )
    forecast = _extrapolated(refinement, levels, grid)
    if forecast.error == inf and not forecast.contact_exceeds_grid:
        errors = requirements.errors(grid.cell_size)
        factor = CONSTANTS.unresolved_factor
        return replace(forecast, errors=(factor * errors[0], factor * errors[1]), orders=orders)
    return forecast


def images_error(scene: Scene, grid: Grid, padding: Padding | Paddings) -> float:
    """Return the relative L1 error by the images that `padding` leaves out, from few cells; infinite if not known."""
    across, along = (min(count, most) for count, most in zip(grid.cells, IMAGE_CELLS, strict=True))
    try:
        problem = scene.problem(Grid((across, along), grid.extent), padding)
        return error_estimate(solve_contact(problem)).l1.images or 0.0
    except InvalidInput:
        return inf


def images_warning(padding: Padding | Paddings, images: float, error: float) -> Iterator[str]:
    """Yield a sentence where the `images` that a padding leaves out contribute more than an `error`."""
    if images > error:
        cause, remedy = OTHER_CAUSES["images"]
        part = "an amount not known" if images == inf else f"{100 * images:.2g} %"
        yield f"plan.padding is {padding!r}: {cause} {part} to the error, {remedy}."


def _refinement(scene: Scene, requirements: GridRequirements, error: float) -> GridRefinement:
    """Return the refinement to an `error` on the few cells of a forecast."""
    options, padding = SolveOptions(), requirements.padding()
    return GridRefinement(scene, requirements, padding, error, options, Cpu(), CONSTANTS.max_cells)


def _extrapolated(
    refinement: GridRefinement, levels: list[BoundedSolution], grid: Grid
) -> GridForecast:
    """Return the forecast of a `grid` from the grids solved, the last of which is the finest."""
    last = levels[-1]
    error = last.discretisation_error
    is_cut_off = last.solution.status is Status.CONTACT_AT_EDGE and bool(
        last.solution.pressure[[0, -1]].any()
    )
    forecast = GridForecast(
        last.grid,
        (inf, 0.0) if error == inf else (error * last.fractions[0], error * last.fractions[1]),
        (refinement.order(levels, 0), refinement.order(levels, 1)),
        refinement.min_cells(grid.extent),
        is_cut_off,
        next((text for text in last.estimate.warnings if SHARP_EDGE in text), ""),
        inf if is_cut_off else contact_width(last.solution) / 2,
    )
    return replace(forecast, grid=grid, errors=forecast.errors_of(grid.cell_size))


def with_width(grid: Grid, width: float) -> Grid:
    """Return a grid with cells of the same size over the width `width` [m]."""
    across = halvable_count(grid.cells[0] * width / grid.extent[0])
    return Grid((across, grid.cells[1]), (width, grid.length))


def within_memory(grid: Grid, padding: Padding | Paddings, bytes_at_most: float) -> Grid:
    """Return `grid`, or the finest of the same extent and aspect ratio whose solve holds within `bytes_at_most`."""
    needed = memory(grid, padding)
    while needed > bytes_at_most and max(grid.cells) > 2:
        shrink = (bytes_at_most / needed) ** (1 if grid.cells[1] == 1 else 0.5) * 0.99
        across, along = (max(2, int(count * shrink)) for count in grid.cells)
        grid = Grid((across, along if grid.cells[1] > 1 else 1), grid.extent)
        needed = memory(grid, padding)
    return grid

"""Solve a static scene to a requested error: coarse grids first, each the start of the next and part of its bound."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, inf, log, prod
from time import process_time

import numpy as np
from scipy import fft

from contactstudy.accuracy.bounded_solution import CONSTANTS as BOUND
from contactstudy.accuracy.bounded_solution import (
    BoundedSolution,
    bounded,
)
from contactstudy.accuracy.coarser import halved
from contactstudy.accuracy.estimate import SHARP_EDGE
from contactstudy.domain.device import Cpu, Device
from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Padding, Paddings, on_cells
from contactstudy.domain.reuse import ArrayCache, caching, current_cache
from contactstudy.planning.grid_requirements import WIDTH_FACTOR, GridRequirements, requirements_of
from contactstudy.planning.grid_search import GridForecast, affordable, contact_width
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Least cells of the first grid (across, along), and of the shortest wavelength; most cells of the first grid.
FIRST_CELLS, CELLS_PER_WAVE, MAX_FIRST_CELLS = (16, 12), 2, 2**14
# Fraction of the requested error for which the next grid is chosen: its bound is only expected.
SAFETY = 0.93
# Largest factor on the cells along an axis to the last grid, beyond which a grid of half the cells is solved between,
# and to any other grid.
MAX_CELL_RATIO, MAX_GROWTH = 2.6, 4.0
# Factor on the cells along each axis where the error has no bound; otherwise the least factor on all cells.
GROWTH_WITHOUT_BOUND, MIN_GROWTH = 2.0, 1.15
# Where the error on the most cells is OUT_OF_REACH times that requested, MAX_CELLS_OUT_OF_REACH cells are used at most.
OUT_OF_REACH, MAX_CELLS_OUT_OF_REACH = 1.5, 2**17
# Factor on a width that the contact outgrows, and the fraction of the width below which a narrower one is taken.
WIDENING, NARROWING = 1.4, 0.8
# Tolerance over the requested error of all grids but those whose bound may keep it.
LOOSE_TOLERANCE = 1e-3
# Relative cost of a roller's end that divides a cell, for a misfit over the requested error. Largest ratio of the cells
# along to those required.
MISFIT_COST, MAX_LENGTHENING = 40.0, 8.0
# Cells of the grids that are solved for a plan, at most.
MAX_PLAN_CELLS = 2**14
# Seconds of the last grid of a solve over those of its last grid for a plan: the power of the ratio of their cells, and
# the factor for the grids between. From 18 solves on 7,000 to 480,000 cells, rough, coated, textured and rollers.
TIME_POWER, TIME_FACTOR = 1.1, 1.4
# What other causes of the error than the cells cost, and their remedy.
OTHER_CAUSES = {
    "truncation": ("the images that the padding leaves out cost", "give ExactPeriodicity()"),
    "residual": ("the residual of the solver costs", "give a smaller tolerance"),
}
# Changes of the width to that of the contact, at most.
MAX_WIDTH_CHANGES = 8


@dataclass(frozen=True)
class Refined:
    """A scene solved to an accuracy, as far as it can be.

    Attributes
    ----------
    solution
        Solution on the finest grid.
    estimate
        Its bounds, from all grids. Where the L1 bound of the pressure is above the error asked for,
        its reason says what stands in the way.
    grids
        Grids that were solved, the last one that of the solution.
    """

    solution: Solution
    estimate: ErrorEstimate
    grids: tuple[Grid, ...]


def solve_to(
    scene: Scene,
    error: float,
    *,
    period: float | None = None,
    padding: Padding | Paddings | None = None,
    options: SolveOptions | None = None,
    start: Array | None = None,
    on: Device = Cpu(),  # noqa: B008 (a frozen value)
    most_cells: int = 2_000_000,
    progress: Callable[[BoundedSolution], object] | None = None,
) -> Refined:
    """Solve a dry scene that neither changes in time nor rolls, to a relative L1 error of the pressure.

    Coarse grids come first. Each gives the start of the next, and contributes to its bound; the errors that the cells
    show along each axis determine which axis to refine. It ends at the first grid whose bound meets the error.

    Parameters
    ----------
    scene
        The scene.
    error
        Relative L1 error of the pressure, between 0 and 1.
    period
        Length of the grid [m]; chosen if None.
    padding
        Boundary conditions; chosen if None.
    options
        Options of the solver.
    start
        Pressure (x, y) [Pa] of a similar contact of the same extent, on any grid.
    on
        Device.
    most_cells
        Cells of a grid at most.
    progress
        Called with the solution and the bounds on each grid.

    Raises
    ------
    InvalidInput
        If the scene leaves open what a grid needs, see :func:`~contactstudy.plan`.
    """
    requirements = requirements_of(scene)
    refinement = GridRefinement(
        scene,
        requirements,
        padding or requirements.padding(),
        error,
        options or SolveOptions(),
        on,
        most_cells,
        progress,
    )
    levels = refinement.levels(requirements.grid(0.1, period).extent, start)
    last = levels[-1]
    l1 = replace(last.estimate.l1, reason=refinement.obstacle(levels))
    grids = tuple(level.grid for level in levels)
    return Refined(last.solution, replace(last.estimate, l1=l1), grids)


def forecast_of_refinement(
    scene: Scene, requirements: GridRequirements, error: float, period: float | None, limit: float
) -> GridForecast:
    """Return the forecast of the grid on which :func:`solve_to` is expected to end, from its first grids.

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
    padding = requirements.padding()
    stamps: list[float] = []
    refinement = GridRefinement(
        scene,
        requirements,
        padding,
        error,
        SolveOptions(),
        Cpu(),
        MAX_PLAN_CELLS,
        lambda _: stamps.append(process_time()),
    )
    extent = requirements.grid(0.1, period).extent
    # exclude the time of first imports
    replace(refinement, error=1.0, progress=None).levels(extent)
    stamps.append(process_time())
    levels = refinement.levels(extent)
    seconds, last = stamps[-1] - stamps[0], levels[-1]
    grid, rates = last.grid, (refinement.rate(levels, 0), refinement.rate(levels, 1))
    if not refinement.meets_error(last):
        grid = affordable(
            refinement.grid(*refinement.required_cells(levels), grid.extent), padding, limit
        )
        finer = prod(grid.cells) / prod(last.grid.cells)
        seconds += TIME_FACTOR * (stamps[-1] - stamps[-2]) * finer**TIME_POWER
    forecast = GridForecast(
        last.grid,
        (
            last.discretisation_error * last.fractions[0],
            last.discretisation_error * last.fractions[1],
        )
        if last.discretisation_error < inf
        else (inf, 0.0),
        rates,
        refinement.fewest(grid.extent),
        last.solution.status is Status.CONTACT_AT_EDGE,
        next((text for text in last.estimate.warnings if SHARP_EDGE in text), ""),
        seconds,
    )
    return replace(forecast, grid=grid, errors=forecast.errors_of(grid.cell))


@dataclass(frozen=True, eq=False)
class GridRefinement:
    """Refinement of the grid of a scene, from coarse to fine, until its error is met."""

    scene: Scene
    requirements: GridRequirements
    padding: Padding | Paddings
    error: float
    options: SolveOptions
    on: Device
    most_cells: int
    progress: Callable[[BoundedSolution], object] | None = None

    def levels(
        self, extent: tuple[float, float], start: Array | None = None
    ) -> list[BoundedSolution]:
        """Return the grids solved, the last of which meets the error or cannot be refined."""
        levels: list[BoundedSolution] = []
        grid: Grid | None = self.first(extent)
        solved: list[Solution] = []
        is_last, widths = False, 0
        with caching(current_cache() or ArrayCache(32 * self.most_cells)):
            while grid is not None:
                if not solved:
                    solved.append(self._solved(halved(grid), start, self._loose))
                options = self.options if is_last else self._loose
                solution = self._solved(grid, solved[-1].pressure, options)
                if widths < MAX_WIDTH_CHANGES and (width := self._width(solution)) is not None:
                    widths += 1
                    levels, solved, start, grid = [], [], None, self._with_width(grid, width)
                    continue
                level = bounded(solution, solved)
                if level.bound <= self.error and not is_last:
                    solution = self._solved(grid, solution.pressure, self.options)
                    level = bounded(solution, solved)
                levels.append(level)
                solved.append(solution)
                if self.progress is not None:
                    self.progress(level)
                grid, is_last = self.next_grid(levels)
        return levels

    @property
    def _loose(self) -> SolveOptions:
        """Options for grids that are not expected to meet the error."""
        return replace(
            self.options, tolerance=max(self.options.tolerance, LOOSE_TOLERANCE * self.error)
        )

    def _solved(self, grid: Grid, start: Array | None, options: SolveOptions) -> Solution:
        """Return the solution on `grid` from a pressure on another of the same extent."""
        begin = None if start is None else on_cells(start, grid.cells)
        return solve_contact(self.scene.problem(grid, self.padding), options, begin, self.on)

    def first(self, extent: tuple[float, float]) -> Grid:
        """Return the first grid: coarse, but fine enough to show the surface, where that takes few cells."""
        across, along = self.fewest(extent)
        shrink = max(1.0, across * along / MAX_FIRST_CELLS) ** (0.5 if along > 1 else 1.0)
        return self.grid(across / shrink, along / shrink, extent)

    def fewest(self, extent: tuple[float, float]) -> tuple[int, int]:
        """Return the cells (across, along) that show the surface."""
        across, along = (
            max(least, CELLS_PER_WAVE * length / wave)
            for least, length, wave in zip(
                FIRST_CELLS, extent, self.requirements.finest, strict=True
            )
        )
        if self.requirements.roller:
            along = max(along, extent[1] / self.requirements.hertz.half_width)
        return ceil(across), ceil(along) if self.requirements.varies else 1

    def grid(self, across: float, along: float, extent: tuple[float, float]) -> Grid:
        """Return a grid of at least these cells, in numbers that transform quickly; a roller ends between two."""
        nx = 2 * fft.next_fast_len(ceil(across / 2), real=True)
        if along <= 1:
            return Grid((nx, 1), extent)
        ny = 2 * fft.next_fast_len(ceil(along / 2), real=True)
        roller = self.requirements.roller
        if not 0 < roller < extent[1] * (1 - 1e-9):
            return Grid((nx, ny), extent)
        fraction = roller / extent[1]
        longest = (
            ceil(max(GROWTH_WITHOUT_BOUND * along, along + 2 / (1 - fraction)))
            if fraction < 1
            else ceil(GROWTH_WITHOUT_BOUND * along)
        )
        ny = min(
            range(ceil(along), min(longest, ceil(MAX_LENGTHENING * along)) + 1),
            key=lambda count: count * (1 + MISFIT_COST * _misfit(count, fraction) / self.error),
        )
        return Grid((nx, ny), extent)

    def _width(self, solution: Solution) -> float | None:
        """Return the width that suits the contact, if that of the grid does not."""
        width, widest = solution.problem.grid.extent[0], self.requirements.widest
        # the end of a free length does not depend on the width
        if solution.pressure[[0, -1]].any() and width < widest:
            return min(WIDENING * width, widest)
        # random heights depend on the extent
        if any(getattr(shape, "extent", ()) is None for shape in self.scene.shapes):
            return None
        needed = WIDTH_FACTOR * contact_width(solution)
        return needed if needed < NARROWING * width else None

    def _with_width(self, grid: Grid, width: float) -> Grid:
        """Return `grid` with another width, and cells no larger."""
        wider = max(width / grid.extent[0], 1.0)
        return self.grid(grid.cells[0] * wider, grid.cells[1], (width, grid.extent[1]))

    def next_grid(self, levels: list[BoundedSolution]) -> tuple[Grid | None, bool]:
        """Return the next grid to solve, None where the error is met or out of reach; and whether it should meet it."""
        last, limit = levels[-1], float(self.most_cells)
        present = prod(last.grid.cells)
        if self.meets_error(last) or present >= limit:
            return None, True
        required_cells = self.required_cells(levels)
        if prod(required_cells) > limit:
            missed = (
                last.discretisation_error
                / self._allowed(last)
                * (present / limit) ** self._overall(levels)
            )
            limit = min(MAX_CELLS_OUT_OF_REACH, limit) if OUT_OF_REACH < missed < inf else limit
            required_cells = _scaled(required_cells, SAFETY * limit / prod(required_cells))
        axes = 1 if required_cells[1] == 1 else 2
        is_last = (prod(required_cells) / present) ** (1 / axes) <= MAX_CELL_RATIO
        if not is_last:
            required_cells = _at_most(_scaled(required_cells, 0.5**axes), last.grid.cells)
        grid = self.grid(*required_cells, last.grid.extent)
        while prod(grid.cells) > self.most_cells:  # counts are rounded up
            required_cells = _scaled(required_cells, SAFETY)
            grid = self.grid(*required_cells, last.grid.extent)
        return (grid if prod(grid.cells) > present else None), is_last

    def meets_error(self, level: BoundedSolution) -> bool:
        """Return whether the discretisation error is no larger than allowed."""
        return level.discretisation_error <= self._allowed(level)

    def _allowed(self, level: BoundedSolution) -> float:
        """Return the error that the cells may have: what the other parts leave, but no less than half of these."""
        other_causes = level.bound - level.discretisation_error if level.bound < inf else 0.0
        return max(self.error - other_causes, 0.5 * other_causes)

    def required_cells(self, levels: list[BoundedSolution]) -> tuple[float, float]:
        """Return the fewest cells (across, along) whose bound is expected to meet the error."""
        last = levels[-1]
        nx, ny = last.grid.cells
        fewest = self.fewest(last.grid.extent)
        present = last.discretisation_error
        if present == inf:
            return max(GROWTH_WITHOUT_BOUND * nx, fewest[0]), max(
                GROWTH_WITHOUT_BOUND * ny, fewest[1]
            ) if ny > 1 else 1.0
        factor = present / (SAFETY * self._allowed(last))
        if ny == 1:
            return max(nx * factor ** (1 / self.rate(levels, 0)), MIN_GROWTH * nx), 1.0
        (across, along), (rate_x, rate_y) = (
            last.fractions,
            (self.rate(levels, axis) for axis in (0, 1)),
        )
        # least product of both counts under the sum of both errors: r_x times the error across is r_y times that along
        remaining = [
            1 / factor * rate_y / (rate_x + rate_y),
            1 / factor * rate_x / (rate_x + rate_y),
        ]
        counts = [
            count * max(fraction / allowed, 1e-3) ** (1 / rate)
            for count, fraction, allowed, rate in zip(
                (nx, ny), (across, along), remaining, (rate_x, rate_y), strict=True
            )
        ]
        counts = [
            max(count, half) for count, half in zip(counts, (0.5 * nx, 0.5 * ny), strict=True)
        ]
        grown = prod(counts) / (nx * ny)
        if grown < MIN_GROWTH:
            counts = [count * (MIN_GROWTH / grown) ** 0.5 for count in counts]
        return max(counts[0], fewest[0]), max(counts[1], fewest[1])

    def rate(self, levels: list[BoundedSolution], axis: int) -> float:
        """Return the expected order of convergence along an axis."""
        at_ends = self.requirements.roller > 0 and axis == 0  # the edges across a roller are smooth
        usual = BOUND.step_order if levels[-1].is_sharp and not at_ends else BOUND.smooth_order
        if len(levels) < 2 or levels[-1].grid.cells[1] == 1:
            return usual
        (coarse, fine) = (
            (level.cell_errors[axis], level.grid.cells[axis]) for level in levels[-2:]
        )
        if fine[1] < 1.2 * coarse[1] or not 0 < fine[0] < coarse[0]:
            return usual
        observed = log(coarse[0] / fine[0]) / log(fine[1] / coarse[1])
        return float(np.clip((observed + usual) / 2, BOUND.min_order, BOUND.smooth_order))

    def _overall(self, levels: list[BoundedSolution]) -> float:
        """Return the expected power of the number of cells with which the error falls."""
        rates = [self.rate(levels, axis) for axis in (0, 1)]
        return rates[0] if levels[-1].grid.cells[1] == 1 else 1 / (1 / rates[0] + 1 / rates[1])

    def obstacle(self, levels: list[BoundedSolution]) -> str:
        """Return what stands in the way of the error; empty where the last grid meets it."""
        last = levels[-1]
        if last.bound <= self.error:
            return ""
        if last.bound == inf:
            return " ".join(last.estimate.warnings)
        for cause, fraction in last.estimate.l1.by_cause.items():
            if cause in OTHER_CAUSES and fraction >= self.error:
                return f"{OTHER_CAUSES[cause][0]} {100 * fraction:.2g} %: {OTHER_CAUSES[cause][1]}."
        grown = (last.discretisation_error / self._allowed(last)) ** (1 / self._overall(levels))
        cells = f"{prod(last.grid.cells) * grown:.1g}"
        return f"it would take about {cells} cells, and {self.most_cells:,} are allowed."


def _misfit(count: int, fraction: float) -> float:
    """Return the length over its own by which rows of cells miss an end of a roller, of this `fraction` of theirs."""
    rows = count * fraction
    nearest = round((rows - count % 2) / 2) * 2 + count % 2
    return abs(nearest - rows) / 2 / rows


def _scaled(required_cells: tuple[float, float], factor: float) -> tuple[float, float]:
    """Return cells (across, along) whose product is `factor` times that of `required_cells`."""
    if required_cells[1] == 1:
        return required_cells[0] * factor, 1.0
    return required_cells[0] * factor**0.5, required_cells[1] * factor**0.5


def _at_most(required_cells: tuple[float, float], cells: tuple[int, int]) -> tuple[float, float]:
    """Return `required_cells` (across, along), no fewer than `cells` and no more than MAX_GROWTH times as many."""
    across, along = (
        float(max(min(count, MAX_GROWTH * present), present))
        for count, present in zip(required_cells, cells, strict=True)
    )
    return across, along

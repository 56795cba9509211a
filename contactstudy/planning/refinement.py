"""Solve a scene at rest to an accuracy: coarse grids first, each the start and the evidence of the next."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, inf, log, prod
from time import process_time

import numpy as np
from scipy import fft

from contactstudy.accuracy.coarser import halved
from contactstudy.accuracy.estimate import SHARP_EDGE
from contactstudy.accuracy.evidence import (
    MIN_ORDER,
    SMOOTH_ORDER,
    STEP_ORDER,
    BoundedSolution,
    bounded,
)
from contactstudy.domain.device import Cpu, Device
from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Padding, Paddings, on_cells
from contactstudy.domain.reuse import ArrayCache, caching, current_cache
from contactstudy.planning.grid_requirements import ROOM, Needs, needs_of
from contactstudy.planning.grid_search import GridForecast, affordable, contact_width
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions

# Cells of the first grid (across, along), at least, and of the shortest wave; cells of it at most.
FIRST, PER_WAVE, MOST_FIRST = (16, 12), 2, 2**14
# Share of the requested error for which the next grid is chosen: its bound is only expected.
ALMOST = 0.93
# Largest factor on the cells along an axis from one grid to the next: beyond it, one of half the cells comes between.
JUMP, FURTHEST = 2.6, 4.0
# A bound that cannot be given falls at twice the cells along each axis; otherwise they grow by LEAST_STEP.
TWICE, LEAST_STEP = 2.0, 1.15
# Where the error is this many times out of reach, the answer has at most so many cells.
OUT_OF_REACH, ENOUGH = 1.5, 2**17
# Factor on a width that the contact outgrows, and the share of the width below which a narrower one is taken.
WIDER, NARROWER = 1.4, 0.8
# Tolerance over the requested error of all grids but those whose bound may keep it.
LOOSE = 1e-3
# Price of a roller's end that divides a cell: cells along over their number, for a misfit over the requested error.
# Cells along at most over those wanted.
BY_PLACE, LONGER = 40.0, 8.0
# Cells of the grids that are solved for a plan, at most.
LOOK = 2**14
# Seconds of the last grid of a solve over those of its last grid for a plan: the power of the ratio of their cells, and
# the factor for the grids between. From 18 solves on 7,000 to 480,000 cells, rough, coated, textured and rollers.
BY_CELLS, BETWEEN = 1.1, 1.4
# What other causes of the error than the cells cost, and their remedy.
OTHERS = {
    "truncation": ("the images that the padding leaves out cost", "give ExactPeriodicity()"),
    "residual": ("the residual of the solver costs", "give a smaller tolerance"),
}
# Changes of the width to that of the contact, at most.
MOST_WIDTHS = 8


@dataclass(frozen=True)
class Refined:
    """A scene solved to an accuracy, as far as it can be.

    Attributes
    ----------
    solution
        Solution on the finest grid.
    estimate
        Its bounds, with the evidence of all grids. Where the L1 bound of the pressure is above the error asked for,
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

    Coarse grids come first. Each gives the start of the next, and beside it the evidence for its bound; the errors that
    the cells show along each axis say which one to refine. It ends at the first grid whose bound keeps the error.

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
    needs = needs_of(scene)
    climb = Climb(
        scene,
        needs,
        padding or needs.padding(),
        error,
        options or SolveOptions(),
        on,
        most_cells,
        progress,
    )
    rungs = climb.rungs(needs.grid(0.1, period).extent, start)
    last = rungs[-1]
    l1 = replace(last.estimate.l1, reason=climb.obstacle(rungs))
    grids = tuple(rung.grid for rung in rungs)
    return Refined(last.solution, replace(last.estimate, l1=l1), grids)


def reaching(
    scene: Scene, needs: Needs, error: float, period: float | None, limit: float
) -> GridForecast:
    """Return the forecast of the grid on which :func:`solve_to` is expected to end, from its first grids.

    Parameters
    ----------
    scene
        The scene.
    needs
        Its requirements.
    error
        Relative L1 error of the pressure.
    period
        Length of the grid [m]; chosen if None.
    limit
        Bytes that a solve may hold.
    """
    padding = needs.padding()
    marks: list[float] = []
    climb = Climb(
        scene,
        needs,
        padding,
        error,
        SolveOptions(),
        Cpu(),
        LOOK,
        lambda _: marks.append(process_time()),
    )
    extent = needs.grid(0.1, period).extent
    # what is imported on first use is no time of a solve
    replace(climb, error=1.0, progress=None).rungs(extent)
    marks.append(process_time())
    rungs = climb.rungs(extent)
    seconds, last = marks[-1] - marks[0], rungs[-1]
    grid, rates = last.grid, (climb.rate(rungs, 0), climb.rate(rungs, 1))
    if not climb.is_kept(last):
        grid = affordable(climb.grid(*climb.wanted(rungs), grid.extent), padding, limit)
        finer = prod(grid.cells) / prod(last.grid.cells)
        seconds += BETWEEN * (marks[-1] - marks[-2]) * finer**BY_CELLS
    found = GridForecast(
        last.grid,
        (
            last.discretisation_error * last.fractions[0],
            last.discretisation_error * last.fractions[1],
        )
        if last.discretisation_error < inf
        else (inf, 0.0),
        rates,
        climb.fewest(grid.extent),
        last.solution.status is Status.CONTACT_AT_EDGE,
        next((text for text in last.estimate.warnings if SHARP_EDGE in text), ""),
        seconds,
    )
    return replace(found, grid=grid, errors=found.errors_of(grid.cell))


@dataclass(frozen=True, eq=False)
class Climb:
    """Grids of a scene from coarse to fine."""

    scene: Scene
    needs: Needs
    padding: Padding | Paddings
    error: float
    options: SolveOptions
    on: Device
    most_cells: int
    progress: Callable[[BoundedSolution], object] | None = None

    def rungs(
        self, extent: tuple[float, float], start: Array | None = None
    ) -> list[BoundedSolution]:
        """Return the grids solved, the last of which keeps the error or cannot be refined."""
        rungs: list[BoundedSolution] = []
        grid: Grid | None = self.first(extent)
        solved: list[Solution] = []
        is_last, widths = False, 0
        with caching(current_cache() or ArrayCache(32 * self.most_cells)):
            while grid is not None:
                if not solved:
                    solved.append(self._solved(halved(grid), start, self._loose))
                options = self.options if is_last else self._loose
                solution = self._solved(grid, solved[-1].pressure, options)
                if widths < MOST_WIDTHS and (width := self._width(solution)) is not None:
                    widths += 1
                    rungs, solved, start, grid = [], [], None, self._as_wide(grid, width)
                    continue
                rung = bounded(solution, solved)
                if rung.bound <= self.error and not is_last:
                    solution = self._solved(grid, solution.pressure, self.options)
                    rung = bounded(solution, solved)
                rungs.append(rung)
                solved.append(solution)
                if self.progress is not None:
                    self.progress(rung)
                grid, is_last = self.next_grid(rungs)
        return rungs

    @property
    def _loose(self) -> SolveOptions:
        """Options for grids that are not expected to keep the error."""
        return replace(self.options, tolerance=max(self.options.tolerance, LOOSE * self.error))

    def _solved(self, grid: Grid, start: Array | None, options: SolveOptions) -> Solution:
        """Return the solution on `grid` from a pressure on another of the same extent."""
        begin = None if start is None else on_cells(start, grid.cells)
        return options.solved(self.scene.problem(grid, self.padding), begin, self.on)

    def first(self, extent: tuple[float, float]) -> Grid:
        """Return the first grid: coarse, but fine enough to show the surface, where that takes few cells."""
        across, along = self.fewest(extent)
        shrink = max(1.0, across * along / MOST_FIRST) ** (0.5 if along > 1 else 1.0)
        return self.grid(across / shrink, along / shrink, extent)

    def fewest(self, extent: tuple[float, float]) -> tuple[int, int]:
        """Return the cells (across, along) that show the surface."""
        across, along = (
            max(least, PER_WAVE * length / wave)
            for least, length, wave in zip(FIRST, extent, self.needs.finest, strict=True)
        )
        if self.needs.roller:
            along = max(along, extent[1] / self.needs.hertz.half_width)
        return ceil(across), ceil(along) if self.needs.varies else 1

    def grid(self, across: float, along: float, extent: tuple[float, float]) -> Grid:
        """Return a grid of at least these cells, in numbers that transform quickly; a roller ends between two."""
        nx = 2 * fft.next_fast_len(ceil(across / 2), real=True)
        if along <= 1:
            return Grid((nx, 1), extent)
        ny = 2 * fft.next_fast_len(ceil(along / 2), real=True)
        roller = self.needs.roller
        if not 0 < roller < extent[1] * (1 - 1e-9):
            return Grid((nx, ny), extent)
        share = roller / extent[1]
        furthest = (
            ceil(max(TWICE * along, along + 2 / (1 - share))) if share < 1 else ceil(TWICE * along)
        )
        ny = min(
            range(ceil(along), min(furthest, ceil(LONGER * along)) + 1),
            key=lambda count: count * (1 + BY_PLACE * _misfit(count, share) / self.error),
        )
        return Grid((nx, ny), extent)

    def _width(self, solution: Solution) -> float | None:
        """Return the width that suits the contact, if that of the grid does not."""
        width, widest = solution.problem.grid.extent[0], self.needs.widest
        # the end of a free length is no matter of the width
        if solution.pressure[[0, -1]].any() and width < widest:
            return min(WIDER * width, widest)
        # random heights depend on the extent
        if any(getattr(shape, "extent", ()) is None for shape in self.scene.shapes):
            return None
        needed = ROOM * contact_width(solution)
        return needed if needed < NARROWER * width else None

    def _as_wide(self, grid: Grid, width: float) -> Grid:
        """Return `grid` with another width, and cells no larger."""
        wider = max(width / grid.extent[0], 1.0)
        return self.grid(grid.cells[0] * wider, grid.cells[1], (width, grid.extent[1]))

    def next_grid(self, rungs: list[BoundedSolution]) -> tuple[Grid | None, bool]:
        """Return the next grid to solve, None where the error is kept or out of reach; and whether it should keep it."""
        last, limit = rungs[-1], float(self.most_cells)
        present = prod(last.grid.cells)
        if self.is_kept(last) or present >= limit:
            return None, True
        wanted = self.wanted(rungs)
        if prod(wanted) > limit:
            missed = (
                last.discretisation_error
                / self._allowed(last)
                * (present / limit) ** self._overall(rungs)
            )
            limit = min(ENOUGH, limit) if OUT_OF_REACH < missed < inf else limit
            wanted = _scaled(wanted, ALMOST * limit / prod(wanted))
        axes = 1 if wanted[1] == 1 else 2
        is_last = (prod(wanted) / present) ** (1 / axes) <= JUMP
        if not is_last:
            wanted = _at_most(_scaled(wanted, 0.5**axes), last.grid.cells)
        grid = self.grid(*wanted, last.grid.extent)
        while prod(grid.cells) > self.most_cells:  # counts are rounded up
            wanted = _scaled(wanted, ALMOST)
            grid = self.grid(*wanted, last.grid.extent)
        return (grid if prod(grid.cells) > present else None), is_last

    def is_kept(self, rung: BoundedSolution) -> bool:
        """Return whether the error by the cells is no larger than it may be."""
        return rung.discretisation_error <= self._allowed(rung)

    def _allowed(self, rung: BoundedSolution) -> float:
        """Return the error that the cells may have: what the other parts leave, but no less than half of these."""
        others = rung.bound - rung.discretisation_error if rung.bound < inf else 0.0
        return max(self.error - others, 0.5 * others)

    def wanted(self, rungs: list[BoundedSolution]) -> tuple[float, float]:
        """Return the fewest cells (across, along) whose bound is expected to keep the error."""
        last = rungs[-1]
        nx, ny = last.grid.cells
        fewest = self.fewest(last.grid.extent)
        present = last.discretisation_error
        if present == inf:
            return max(TWICE * nx, fewest[0]), max(TWICE * ny, fewest[1]) if ny > 1 else 1.0
        factor = present / (ALMOST * self._allowed(last))
        if ny == 1:
            return max(nx * factor ** (1 / self.rate(rungs, 0)), LEAST_STEP * nx), 1.0
        (across, along), (rate_x, rate_y) = (
            last.fractions,
            (self.rate(rungs, axis) for axis in (0, 1)),
        )
        # least product of both counts under the sum of both errors: r_x times the error across is r_y times that along
        remaining = [
            1 / factor * rate_y / (rate_x + rate_y),
            1 / factor * rate_x / (rate_x + rate_y),
        ]
        counts = [
            count * max(share / left, 1e-3) ** (1 / rate)
            for count, share, left, rate in zip(
                (nx, ny), (across, along), remaining, (rate_x, rate_y), strict=True
            )
        ]
        counts = [
            max(count, half) for count, half in zip(counts, (0.5 * nx, 0.5 * ny), strict=True)
        ]
        grown = prod(counts) / (nx * ny)
        if grown < LEAST_STEP:
            counts = [count * (LEAST_STEP / grown) ** 0.5 for count in counts]
        return max(counts[0], fewest[0]), max(counts[1], fewest[1])

    def rate(self, rungs: list[BoundedSolution], axis: int) -> float:
        """Return the power of the cell with which the error along an axis is expected to fall."""
        at_ends = self.needs.roller > 0 and axis == 0  # the edges across a roller are smooth
        usual = STEP_ORDER if rungs[-1].is_sharp and not at_ends else SMOOTH_ORDER
        if len(rungs) < 2 or rungs[-1].grid.cells[1] == 1:
            return usual
        (coarse, fine) = ((rung.cell_errors[axis], rung.grid.cells[axis]) for rung in rungs[-2:])
        if fine[1] < 1.2 * coarse[1] or not 0 < fine[0] < coarse[0]:
            return usual
        observed = log(coarse[0] / fine[0]) / log(fine[1] / coarse[1])
        return float(np.clip((observed + usual) / 2, MIN_ORDER, SMOOTH_ORDER))

    def _overall(self, rungs: list[BoundedSolution]) -> float:
        """Return the power of the number of cells with which the error is expected to fall."""
        rates = [self.rate(rungs, axis) for axis in (0, 1)]
        return rates[0] if rungs[-1].grid.cells[1] == 1 else 1 / (1 / rates[0] + 1 / rates[1])

    def obstacle(self, rungs: list[BoundedSolution]) -> str:
        """Return what stands in the way of the error; empty where the last grid keeps it."""
        last = rungs[-1]
        if last.bound <= self.error:
            return ""
        if last.bound == inf:
            return " ".join(last.estimate.warnings)
        for cause, share in last.estimate.l1.by_cause.items():
            if cause in OTHERS and share >= self.error:
                return f"{OTHERS[cause][0]} {100 * share:.2g} %: {OTHERS[cause][1]}."
        grown = (last.discretisation_error / self._allowed(last)) ** (1 / self._overall(rungs))
        cells = f"{prod(last.grid.cells) * grown:.1g}"
        return f"it would take about {cells} cells, and {self.most_cells:,} are allowed."


def _misfit(count: int, share: float) -> float:
    """Return the length over its own by which rows of cells miss an end of a roller, of this `share` of theirs."""
    rows = count * share
    nearest = round((rows - count % 2) / 2) * 2 + count % 2
    return abs(nearest - rows) / 2 / rows


def _scaled(wanted: tuple[float, float], factor: float) -> tuple[float, float]:
    """Return cells (across, along) whose product is `factor` times that of `wanted`."""
    if wanted[1] == 1:
        return wanted[0] * factor, 1.0
    return wanted[0] * factor**0.5, wanted[1] * factor**0.5


def _at_most(wanted: tuple[float, float], cells: tuple[int, int]) -> tuple[float, float]:
    """Return `wanted` cells (across, along), no fewer than `cells` and no more than FURTHEST times as many."""
    across, along = (
        float(max(min(count, FURTHEST * present), present))
        for count, present in zip(wanted, cells, strict=True)
    )
    return across, along

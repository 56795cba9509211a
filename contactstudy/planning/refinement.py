"""Solve a static scene to a requested error: coarse grids first, each the start of the next and part of its bound.

Errors are bounds of the relative L1 error of the pressure. The discretisation error, that of the cells, is met by finer
grids; other causes are not (`OTHER_CAUSES`). The contributions of both axes to it say which axis to refine. Effects of
constants that are stated are those on the cells that seven contacts take, summed over all of their grids: smooth, wavy,
rough, crowned, coated, with sharp ends and with a hardness, solved to 0.2 to 8 %.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil, inf, isclose, prod
from time import process_time

import numpy as np
from scipy import fft

from contactstudy.accuracy.bound import shown_errors
from contactstudy.accuracy.coarser import coarsened
from contactstudy.accuracy.error_terms import IMAGES_REMEDY
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.domain.device import Cpu, Device, cache_of, caching
from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.grid import Array, Grid, Padding, Paddings, cells_text, on_cells
from contactstudy.domain.imports import loaded
from contactstudy.planning.grid_requirements import WIDTH_FACTOR, GridRequirements, halvable_count, with_requirements
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact


@dataclass(frozen=True)
class BoundedSolution:
    """A solution with its bounds.

    Attributes
    ----------
    solution
        The solution.
    estimate
        Bounds by cause.
    seconds
        Seconds of processor time of its solve and its bounds.
    """

    solution: Solution
    estimate: ErrorEstimate
    seconds: float

    @property
    def grid(self) -> Grid:
        """Grid of the solution."""
        return self.solution.problem.grid

    @property
    def bound(self) -> float:
        """Bound of the relative L1 error of the pressure, which is calibrated and not proven."""
        return self.estimate.l1.total

    @property
    def discretisation_error(self) -> float:
        """Part of the bound by the cells; infinite where it is not known."""
        part = self.estimate.l1.discretisation
        return inf if part is None else part

    @cached_property
    def fractions(self) -> tuple[float, float]:
        """Contributions (across, along) to the discretisation error that the pressure shows, as fractions of it."""
        across, along = shown_errors(self.solution)[1]
        fraction = across / (across + along) if across + along else 1.0
        return fraction, 1 - fraction


# Largest number of cells of a grid, a solve of which takes seconds and some gigabytes.
MOST_CELLS = 2_000_000
# Causes of the error other than the cells, by their names in an estimate: what they do in words, and the remedy.
OTHER_CAUSES = {
    "images": ("the images that the padding omits contribute", IMAGES_REMEDY),
    "range": ("the range of the attraction that the grid chooses contributes", "give Adhesion.range, or finer cells"),
    "residual": ("the residual of the solver contributes", "give a smaller tolerance"),
}


# Minimum number of cells of the first grid (across, along): with half or twice as many, 0.4 to 1.6 times the cells.
FIRST_CELLS = 16, 12
# Minimum number of cells in the shortest wavelength, below which a wave is not resolved; with 4, up to 1.3 times the
# cells.
CELLS_IN_WAVE = 2
# Maximum number of cells of the first grid, which an error of many per cent may not need, and of the grids that are
# solved for a plan, each in some tenths of a second.
MAX_FIRST_CELLS, MAX_PLANNED_CELLS = 2**14, 2**15
# Order of convergence that is expected: it is 1.5 in plane strain where all edges are smooth, and 1 at corners. With
# these, 0.8 to 1.7 and 0.4 to 1.2 times the cells.
CONVERGENCE_ORDER = 1.25
# Fraction of the requested error for which the next grid is chosen, whose bound is only expected: with 0.8 and 0.95,
# 0.4 to 1.25 and 0.6 to 1 times the cells.
AIMED_FRACTION = 0.9
# Fraction of the cells required on which a solve is expected to end: its bound falls faster than is planned for.
EXPECTED_FRACTION = 0.7
# Least and largest factor on the cells along an axis to the next grid, as the geometric mean of both axes. With a
# largest of 1.8, up to 1.4 times the cells; with 4, 0.6 to 1 times, but bounds on cells so much coarser tell less of
# them.
GROWTH = 1.1, 2.6
# Factor on the cells along each axis where the error has no bound, and so does not tell how many are needed.
GROWTH_WITHOUT_BOUND = 2.0
# Ratio of the error expected on the finest grid to the requested one, above which the latter is out of reach: an
# expected error is known to about that factor.
OUT_OF_REACH = 1.5
# Maximum number of cells of a grid where the error is out of reach: it takes a second, and says how far off it is.
MAX_CELLS_OUT_OF_REACH = 2**17
# Factor on a width that is too small for the contact; heights may widen it to any multiple, in several steps.
WIDENING = 1.4
# Fraction of the width of the grid below which a narrower one is taken, since empty cells cost as much as others: with
# 0.6, up to 2.2 times the cells.
NARROWING = 0.8
# Weight of the distance between a roller's end and the nearest cell edge, relative to the length and over the requested
# error, in the choice of cells along: a misfit of a fortieth of the error counts as much as twice the cells, since the
# error by it is some times the misfit.
MISFIT_COST = 40.0
# Largest ratio of the cells along to those required, for a count with which an end lies between two cells.
MAX_LENGTHENING = 8.0
# Largest number of changes of the width to that of the contact, of which two or three are usual.
MAX_WIDTH_CHANGES = 8
# Notes on a start that is given, with its cells in words.
ON_START = "The refinement of the grid began with solve.start, on {}."
NOT_ON_START = "The grid of solve.start is not one of this scene or has few cells: it served the coarsest grid alone."
# Relative difference of extents that are the same: files have them with seven digits or more.
SAME_EXTENT = 1e-6


def solve_to(
    scene: Scene,
    error: float,
    *,
    period: float | None = None,
    padding: Padding | Paddings | None = None,
    options: SolveOptions | None = None,
    start: Array | None = None,
    start_grid: Grid | None = None,
    device: Device = Cpu(),  # noqa: B008 (a frozen value)
    progress: Callable[[Solution, float], object] | None = None,
) -> BoundedSolution:
    """Solve a dry scene that neither changes in time nor rolls, to a relative L1 error of the pressure.

    Coarse grids come first. Each gives the start of the next, and contributes to its bound; the errors by the cells'
    pressure along each axis determine which axis to refine. It ends at the first grid whose bound meets the error, or
    where finer cells would change the bound little beside its other causes, or at `MOST_CELLS`; the L1 error of the
    answer then says why in its reason.

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
    start_grid
        Its grid, on which the refinement begins if it suits the scene (:meth:`GridRefinement.grid_of_start`).
    device
        Device.
    progress
        Called with the solution on each grid and its bound in L1.

    Raises
    ------
    InvalidInput
        If the scene does not determine a grid, see :func:`~contactstudy.plan`.
    """
    scene, requirements = with_requirements(scene, padding, period)
    refinement = GridRefinement(scene, requirements, error, period, options or SolveOptions(), device, progress)
    last = refinement.solve_levels(start=start, start_grid=start_grid)[-1]
    reason = refinement.reason_not_met(last) if last.bound > error else ""
    l1 = replace(last.estimate.l1, reason=reason)
    if start is not None and start_grid is not None:
        began = refinement.grid_of_start(start_grid)
        note = NOT_ON_START if began is None else ON_START.format(cells_text(began.cells))
        solution = replace(last.solution, note=f"{last.solution.note} {note}".lstrip())
        last = replace(last, solution=solution)
    return replace(last, estimate=replace(last.estimate, l1=l1))


@dataclass(frozen=True, eq=False)
class FirstGrids:
    """The first grids of the solve of a static contact, and those that are expected to follow.

    Attributes
    ----------
    levels
        Solutions with their bounds on the first grids.
    required
        Number of cells whose bound is expected to meet the error.
    between
        Grids that are expected to follow, the last one that on which the solve ends; empty if the last level does.
    """

    levels: tuple[BoundedSolution, ...]
    required: float
    between: tuple[Grid, ...]

    @property
    def grid(self) -> Grid:
        """Grid on which the solve is expected to end."""
        return self.between[-1] if self.between else self.levels[-1].grid


def first_grids(scene: Scene, requirements: GridRequirements, error: float, period: float | None) -> FirstGrids:
    """Solve a scene on the first grids of its refinement to a relative L1 error, of `MAX_PLANNED_CELLS` cells at most.

    The length of the grid is the `period` [m], chosen if that is None.
    """
    refinement = GridRefinement(scene, requirements, error, period)
    before, levels = 0, list[BoundedSolution]()
    # once more if something was imported, compiled or tabulated, which is not to count in the seconds
    while before < loaded():
        before = loaded()
        levels = refinement.solve_levels(MAX_PLANNED_CELLS)
    last, between = levels[-1], list[Grid]()
    required = float(prod(last.grid.cells))
    if not refinement.meets_error(last):
        required = prod(refinement.required_cells(last))
    grid = refinement.next_grid(last)
    while grid is not None:
        between.append(grid)
        grid = refinement.next_grid(last, grid)
    return FirstGrids(tuple(levels), required, tuple(between))


@dataclass(frozen=True, eq=False)
class GridRefinement:
    """Refinement of the grid of a scene, from coarse to fine, until its error is met.

    Attributes
    ----------
    scene, requirements
        The scene, and what it asks of a grid.
    error
        Relative L1 error of the pressure to meet.
    period
        Length of the grid [m]; chosen if None.
    options, device
        How and on what device each grid is solved.
    progress
        Called with the solution on each grid and its bound in L1.
    """

    scene: Scene
    requirements: GridRequirements
    error: float
    period: float | None
    options: SolveOptions = field(default_factory=SolveOptions)
    device: Device = Cpu()  # noqa: RUF009 (a frozen value)
    progress: Callable[[Solution, float], object] | None = None

    def solve_levels(
        self, most_solved: int = MOST_CELLS, start: Array | None = None, start_grid: Grid | None = None
    ) -> list[BoundedSolution]:
        """Return the solutions on all grids with their bounds; the last one meets the error or cannot be refined.

        The first grid starts from a solution on half of its cells, each other from that before. Where the width does not
        suit the contact, all begins anew on another one.

        Parameters
        ----------
        most_solved
            Number of cells beyond which a grid is not solved, other than the first one.
        start
            Pressure (x, y) [Pa] to begin with, on any grid.
        start_grid
            Its grid, on which to begin if it suits the scene.
        """
        levels: list[BoundedSolution] = []
        coarse: Solution | None = None
        grid: Grid | None = self.first_grid(self.requirements.extent(self.period))
        if start_grid is not None:
            grid = self.grid_of_start(start_grid) or grid
        widths, begin = 0, process_time()
        with caching(cache_of(32 * MOST_CELLS)):  # bytes of two spectra of the largest grid
            while grid is not None and (not levels or prod(grid.cells) <= most_solved):
                if coarse is None:
                    coarse = self._solve_on(coarsened(grid, 2), start)
                solution = self._solve_on(grid, coarse.pressure)
                width = self._width(solution) if widths < MAX_WIDTH_CHANGES else None
                if width is not None:
                    widths += 1
                    levels, coarse, start, grid = [], None, None, self._with_width(grid, width)
                    continue
                half = coarse if coarse.problem.grid == coarsened(grid, 2) else None
                estimate = error_estimate(solution, coarse=half)
                levels.append(BoundedSolution(solution, estimate, process_time() - begin))
                coarse, begin = solution, process_time()
                if self.progress is not None:
                    self.progress(solution, levels[-1].bound)
                grid = self.next_grid(levels[-1])
        return levels

    def _solve_on(self, grid: Grid, start: Array | None) -> Solution:
        """Return the solution on `grid`, from the pressure `start` (x, y) [Pa] on another grid of the same extent."""
        begin = None if start is None else on_cells(start, grid.cells)
        problem = self.scene.problem(grid, self.requirements.padding())
        return solve_contact(problem, self.options, begin, self.device)

    def first_grid(self, extent: tuple[float, float]) -> Grid:
        """Return the first grid on an `extent` (width, length) [m]: as coarse as resolves the surface.

        It has at most about `MAX_FIRST_CELLS` cells, even if these do not resolve it.
        """
        across, along = self.min_cells(extent)
        shrink = max(1.0, across * along / MAX_FIRST_CELLS) ** (0.5 if along > 1 else 1.0)
        return self.grid_of_fast_lengths(across / shrink, along / shrink, extent)

    def grid_of_start(self, given: Grid) -> Grid | None:
        """Return the grid to begin with in place of the first one: the `given` one of a start; None if it does not suit.

        It suits if it is as long as the scene, has at least the cells of the first grid, and its width is that of the
        scene where random heights depend on that.
        """
        first = self.first_grid(self.requirements.extent(self.period))
        varies = first.cells[1] > 1
        same_width, same_length = (
            isclose(there, here, rel_tol=SAME_EXTENT) for there, here in zip(given.extent, first.extent, strict=True)
        )
        suits = (same_width or not self._has_heights_of_grid) and (same_length or not varies)
        has_cells = prod(first.cells) <= prod(given.cells) <= MOST_CELLS and varies is (given.cells[1] > 1)
        return self.grid_of_fast_lengths(*given.cells, (given.extent[0], first.length)) if suits and has_cells else None

    @property
    def _has_heights_of_grid(self) -> bool:
        """True if heights of the scene, which are random, depend on the extent of the grid."""
        return any(getattr(shape, "extent", ()) is None for shape in self.scene.shapes)

    def min_cells(self, extent: tuple[float, float]) -> tuple[int, int]:
        """Return the minimum number of cells (across, along) that resolve the surface on an `extent` [m]."""
        axes = zip(FIRST_CELLS, extent, self.requirements.shortest_wavelengths, strict=True)
        across, along = (max(least, CELLS_IN_WAVE * length / wave) for least, length, wave in axes)
        if self.requirements.roller_length:
            along = max(along, extent[1] / self.requirements.hertz.half_width)
        across = max(across, min(extent[0] / self.requirements.stress_cell, MAX_FIRST_CELLS))
        return ceil(across), ceil(along) if self.requirements.varies else 1

    def grid_of_fast_lengths(self, across: float, along: float, extent: tuple[float, float]) -> Grid:
        """Return a grid on an `extent` [m] of at least these cells `across` and `along`, so many that an FFT is fast.

        Where a roller ends within the grid, the number along is one whose cell edges lie near its ends.
        """
        nx = 2 * fft.next_fast_len(ceil(across / 2), real=True)
        if along <= 1:
            return Grid((nx, 1), extent)
        ny = 2 * fft.next_fast_len(ceil(along / 2), real=True)
        roller = self.requirements.roller_length
        if not 0 < roller < extent[1] * (1 - 1e-9):
            return Grid((nx, ny), extent)
        fraction = roller / extent[1]
        # up to twice as many, or to one more row beyond each end: some count between has a cell edge near the ends
        longest = ceil(max(2 * along, along + 2 / (1 - fraction)))
        ny = min(
            range(ceil(along), min(longest, ceil(MAX_LENGTHENING * along)) + 1),
            key=lambda n: n * (1 + MISFIT_COST * _end_misfit(n, fraction) / self.error),
        )
        return Grid((nx, ny), extent)

    def _width(self, solution: Solution) -> float | None:
        """Return the width [m] that suits the contact if that of the grid does not, else None."""
        width, widest = solution.problem.grid.extent[0], self.requirements.known_width
        if solution.pressure[[0, -1]].any() and width < widest:
            return self.requirements.width(WIDENING * width)
        if self._has_heights_of_grid:
            return None
        needed = WIDTH_FACTOR * contact_width(solution)
        return needed if needed < NARROWING * width else None

    def _with_width(self, grid: Grid, width: float) -> Grid:
        """Return `grid` with another width, and cells no larger."""
        wider = max(width / grid.extent[0], 1.0)
        return self.grid_of_fast_lengths(grid.cells[0] * wider, grid.cells[1], (width, grid.extent[1]))

    def next_grid(self, last: BoundedSolution, after: Grid | None = None) -> Grid | None:
        """Return the grid to solve next; None where the error is met or out of reach.

        Parameters
        ----------
        last
            The last solution.
        after
            A finer grid that is not solved, after which the next is expected; the grid of the last solution if None.
        """
        present, most = prod((after or last.grid).cells), MOST_CELLS
        required = self.required_cells(last)
        axes = 1 if required[1] == 1 else 2
        # the error expected on the finest grid, over the requested one
        expected_error = (prod(required) / most) ** (CONVERGENCE_ORDER / axes)
        if expected_error > OUT_OF_REACH and last.discretisation_error < inf:
            most = min(MAX_CELLS_OUT_OF_REACH, most)
        is_enough = self.meets_error(last) if after is None else present >= EXPECTED_FRACTION * prod(required)
        # no width of a surface that is resolved holds the contact
        is_resolved = present >= prod(self.min_cells(last.grid.extent))
        is_cut_off = is_resolved and last.solution.status is Status.CONTACT_AT_EDGE
        if is_enough or is_cut_off or present >= most:
            return None
        least, largest = (present * growth**axes for growth in GROWTH)
        cells = min(max(prod(required), least), largest, most)
        while True:  # counts are rounded up
            factor = (cells / prod(required)) ** (1 / axes)
            across, along = (count * factor for count in required)
            grid = self.grid_of_fast_lengths(across, along, last.grid.extent)
            if prod(grid.cells) <= MOST_CELLS:
                return grid if prod(grid.cells) > present else None
            cells *= AIMED_FRACTION

    def meets_error(self, level: BoundedSolution) -> bool:
        """Return whether the discretisation error of a `level` is no larger than allowed."""
        return level.discretisation_error <= self._allowed_error(level)

    def _allowed_error(self, level: BoundedSolution) -> float:
        """Return the allowed discretisation error of a `level`: the requested one less other causes.

        It is at least half of the other causes, since finer cells would then change the bound little.
        """
        other_causes = level.bound - level.discretisation_error if level.bound < inf else 0.0
        return max(self.error - other_causes, 0.5 * other_causes)

    def required_cells(self, last: BoundedSolution) -> tuple[float, float]:
        """Return the minimum number of cells (across, along) whose bound is expected to meet the error, from the `last`.

        Each axis may then contribute half of it, so that its cells grow by ``(2 e f / e0)^(1 / order)``: f is the
        fraction of the error e that it contributes, and e0 is `AIMED_FRACTION` of the allowed error. Each keeps at least
        half of its cells. Along a row of cells the axis across may contribute all.
        """
        nx, ny = last.grid.cells
        across, along = self.min_cells(last.grid.extent)
        error = last.discretisation_error
        factor = error / (AIMED_FRACTION * self._allowed_error(last))
        axes = 1 if ny == 1 else 2
        grown = [
            GROWTH_WITHOUT_BOUND if error == inf else max((axes * factor * fraction) ** (1 / CONVERGENCE_ORDER), 0.5)
            for fraction in last.fractions
        ]
        return max(nx * grown[0], across), max(ny * grown[1], along) if ny > 1 else 1

    def reason_not_met(self, last: BoundedSolution) -> str:
        """Return why the bound of the `last` level is above the error."""
        if last.bound == inf:
            return last.estimate.l1.reason or next(iter(last.estimate.warnings), "")
        for cause, fraction in last.estimate.l1.by_cause.items():
            if cause in OTHER_CAUSES and fraction >= self.error:
                return f"{OTHER_CAUSES[cause][0]} {100 * fraction:.2g} %: {OTHER_CAUSES[cause][1]}."
        cells = f"{prod(self.required_cells(last)):.1g}"
        return f"the error needs about {cells} cells; at most {MOST_CELLS:,} are allowed."


def contact_width(solution: Solution) -> float:
    """Return the width [m] about the axis within which all cells in contact lie."""
    grid = solution.problem.grid
    touching = np.abs(grid.x[solution.pressure.any(axis=1)])
    return float(2 * touching.max(initial=0.0)) + grid.cell_size[0]


def _end_misfit(count: int, fraction: float) -> float:
    """Return the distance from a roller's end to the nearest border of cells, over its length.

    The grid has `count` cells along, of which the roller covers a `fraction` in the middle.
    """
    rows = count * fraction
    nearest = round((rows - count % 2) / 2) * 2 + count % 2
    return abs(nearest - rows) / 2 / rows


def with_width(grid: Grid, width: float) -> Grid:
    """Return `grid` over another `width` [m], with cells of the same size, or a little smaller."""
    across = halvable_count(grid.cells[0] * width / grid.extent[0])
    return Grid((across, grid.cells[1]), (width, grid.length))

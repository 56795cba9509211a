"""Solve a static scene to a requested error: coarse grids first, each the start of the next and part of its bound."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, inf, log, prod

import numpy as np
from scipy import fft

from contactstudy.accuracy.discretisation.coarser import halved
from contactstudy.accuracy.image_errors import IMAGES_REMEDY
from contactstudy.domain.device import Cpu, Device
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Padding, Paddings, on_cells
from contactstudy.domain.reuse import cache_of, caching
from contactstudy.planning.bounded_solution import BoundedSolution, bounded
from contactstudy.planning.grid_requirements import CONSTANTS as GRID
from contactstudy.planning.grid_requirements import (
    GridRequirements,
    grid_requirements,
    with_random_extents,
)
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Cells of a grid at most.
MOST_CELLS = 2_000_000
# Causes of the error other than the cells, in words, and their remedies.
OTHER_CAUSES = {
    "images": ("the images that the padding omits contribute", IMAGES_REMEDY),
    "residual": ("the residual of the solver contributes", "give a smaller tolerance"),
}


@dataclass(frozen=True)
class RefinementConstants:
    """Constants of the refinement.

    Attributes
    ----------
    first_cells
        Minimum number of cells of the first grid (across, along).
    cells_per_wave
        Minimum number of cells in the shortest wavelength.
    max_first_cells
        Maximum number of cells of the first grid.
    safety
        Fraction of the requested error for which the next grid is chosen, whose bound is only expected.
    max_cell_ratio
        Largest factor on the cells along an axis, as the geometric mean of both axes, to the last grid. Beyond it a grid
        of half the required cells along each axis is an intermediate one.
    max_growth
        Largest factor on the cells along an axis to an intermediate grid.
    growth_without_bound
        Factor on the cells along each axis where the error has no bound.
    min_growth
        Least factor on the number of cells where the error has a bound.
    out_of_reach
        Ratio of the error expected on the finest grid to the requested one, above which that is out of reach.
    max_cells_out_of_reach
        Maximum number of cells of a grid where the error is out of reach.
    widening
        Factor on a width that is too small for the contact.
    narrowing
        Fraction of the width below which a narrower one is taken.
    loose_tolerance
        Tolerance over the requested error on all grids but those whose bound may meet it.
    misfit_cost
        Weight of the distance between a roller's end and the nearest cell edge, over the requested error, in the choice
        of cells along.
    max_lengthening
        Largest ratio of the cells along to those required, for an end between two cells.
    max_width_changes
        Largest number of changes of the width to that of the contact.
    min_order
        Least order of convergence.
    smooth_order
        Order where all edges of the contact are smooth.
    step_order
        Order where a corner or a roller's end is in contact.
    """

    first_cells: tuple[int, int] = (16, 12)
    cells_per_wave: int = 2
    max_first_cells: int = 2**14
    safety: float = 0.93
    max_cell_ratio: float = 2.6
    max_growth: float = 4.0
    growth_without_bound: float = 2.0
    min_growth: float = 1.15
    out_of_reach: float = 1.5
    max_cells_out_of_reach: int = 2**17
    widening: float = 1.4
    narrowing: float = 0.8
    loose_tolerance: float = 1e-3
    misfit_cost: float = 40.0
    max_lengthening: float = 8.0
    max_width_changes: int = 8
    min_order: float = 0.5
    smooth_order: float = 1.5
    step_order: float = 1.0


CONSTANTS = RefinementConstants()


def solve_to(
    scene: Scene,
    error: float,
    *,
    period: float | None = None,
    padding: Padding | Paddings | None = None,
    options: SolveOptions | None = None,
    start: Array | None = None,
    device: Device = Cpu(),  # noqa: B008 (a frozen value)
    most_cells: int = MOST_CELLS,
    progress: Callable[[Solution, float], object] | None = None,
) -> BoundedSolution:
    """Solve a dry scene that neither changes in time nor rolls, to a relative L1 error of the pressure.

    Coarse grids come first. Each gives the start of the next, and contributes to its bound; the errors by the cells'
    pressure along each axis determine which axis to refine. It ends at the first grid whose bound meets the error, or
    where finer cells would change the bound little beside its other causes, or at `most_cells`; the L1 error of the
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
    device
        Device.
    most_cells
        Cells of a grid at most.
    progress
        Called with the solution on each grid and its bound in L1.

    Raises
    ------
    InvalidInput
        If the scene does not determine a grid, see :func:`~contactstudy.plan`.
    """
    requirements = grid_requirements(scene)
    # a random surface keeps the extent of its plan on the grids of other widths
    scene = with_random_extents(scene, requirements.grid(0.1, period).extent)
    requirements = grid_requirements(scene)
    refinement = GridRefinement(
        scene,
        requirements,
        padding or requirements.padding(),
        requirements.pressure_error(error),
        options or SolveOptions(),
        device,
        most_cells,
        progress,
    )
    levels = refinement.solve_levels(requirements.grid(0.1, period).extent, start)
    last = levels[-1]
    reason = refinement.reason_not_met(levels) if last.bound > error else ""
    l1 = replace(last.estimate.l1, reason=reason)
    return replace(last, estimate=replace(last.estimate, l1=l1))


@dataclass(frozen=True, eq=False)
class GridRefinement:
    """Refinement of the grid of a scene, from coarse to fine, until its error is met.

    Attributes
    ----------
    scene, requirements, padding
        The scene, what it asks of a grid, and its boundary conditions.
    error
        Relative L1 error of the pressure to meet.
    options, device
        How and on what device each grid is solved, with a looser tolerance where the bound is not expected to meet the
        error.
    most_cells
        Maximum number of cells of a grid.
    progress
        Called with the solution on each grid and its bound in L1.
    most_solved
        Number of cells beyond which a grid is not solved, other than the first one.
    keeps_width
        True if the width stays as it is, whatever that of the contact.
    """

    scene: Scene
    requirements: GridRequirements
    padding: Padding | Paddings
    error: float
    options: SolveOptions
    device: Device
    most_cells: int
    progress: Callable[[Solution, float], object] | None = None
    most_solved: int = 2**62
    keeps_width: bool = False

    def solve_levels(
        self, extent: tuple[float, float], start: Array | None = None
    ) -> list[BoundedSolution]:
        """Return the solutions on all grids with their bounds; the last one meets the error or cannot be refined."""
        levels: list[BoundedSolution] = []
        grid: Grid | None = self.first_grid(extent)
        solutions: list[Solution] = []
        is_last, widths = False, 0
        with caching(cache_of(32 * self.most_cells)):
            while grid is not None:
                if not solutions:
                    solutions.append(self._solve_on(halved(grid), start, self._loose))
                options = self.options if is_last else self._loose
                solution = self._solve_on(grid, solutions[-1].pressure, options)
                width = self._width(solution) if widths < CONSTANTS.max_width_changes else None
                if width is not None:
                    widths += 1
                    levels, solutions, start, grid = [], [], None, self._with_width(grid, width)
                    continue
                level = bounded(solution, solutions[-1])
                if level.bound <= self.error and not is_last:
                    solution = self._solve_on(grid, solution.pressure, self.options)
                    level = bounded(solution, solutions[-1])
                levels.append(level)
                solutions.append(solution)
                if self.progress is not None:
                    self.progress(solution, level.bound)
                grid, is_last = self.next_grid(levels)
                if grid is not None and prod(grid.cells) > self.most_solved:
                    break
        return levels

    @property
    def _loose(self) -> SolveOptions:
        """Options for grids that are not expected to meet the error."""
        tolerance = max(self.options.tolerance, CONSTANTS.loose_tolerance * self.error)
        return replace(self.options, tolerance=tolerance)

    def _solve_on(self, grid: Grid, start: Array | None, options: SolveOptions) -> Solution:
        """Return the solution on `grid` from a pressure on another of the same extent."""
        begin = None if start is None else on_cells(start, grid.cells)
        return solve_contact(self.scene.problem(grid, self.padding), options, begin, self.device)

    def first_grid(self, extent: tuple[float, float]) -> Grid:
        """Return the first grid: coarse, but fine enough to resolve the surface, where that takes few cells."""
        across, along = self.min_cells(extent)
        shrink = max(1.0, across * along / CONSTANTS.max_first_cells) ** (0.5 if along > 1 else 1.0)
        return self.grid_of_fast_lengths(across / shrink, along / shrink, extent)

    def min_cells(self, extent: tuple[float, float]) -> tuple[int, int]:
        """Return the minimum number of cells (across, along) that resolve the surface."""
        axes = zip(
            CONSTANTS.first_cells, extent, self.requirements.shortest_wavelengths, strict=True
        )
        across, along = (
            max(least, CONSTANTS.cells_per_wave * length / wave) for least, length, wave in axes
        )
        if self.requirements.roller_length:
            along = max(along, extent[1] / self.requirements.hertz.half_width)
        across = max(across, self.requirements.cells_for_stress(extent[0]))
        return ceil(across), ceil(along) if self.requirements.varies else 1

    def grid_of_fast_lengths(
        self, across: float, along: float, extent: tuple[float, float]
    ) -> Grid:
        """Return a grid of at least these cells, in numbers of which an FFT is fast, unless a roller ends on it."""
        nx = 2 * fft.next_fast_len(ceil(across / 2), real=True)
        if along <= 1:
            return Grid((nx, 1), extent)
        ny = 2 * fft.next_fast_len(ceil(along / 2), real=True)
        roller = self.requirements.roller_length
        if not 0 < roller < extent[1] * (1 - 1e-9):
            return Grid((nx, ny), extent)
        fraction = roller / extent[1]
        longest = ceil(max(CONSTANTS.growth_without_bound * along, along + 2 / (1 - fraction)))
        ny = min(
            range(ceil(along), min(longest, ceil(CONSTANTS.max_lengthening * along)) + 1),
            key=lambda n: n * (1 + CONSTANTS.misfit_cost * _end_misfit(n, fraction) / self.error),
        )
        return Grid((nx, ny), extent)

    def _width(self, solution: Solution) -> float | None:
        """Return the width that suits the contact, if that of the grid does not."""
        if self.keeps_width:
            return None
        width, widest = solution.problem.grid.extent[0], self.requirements.known_width
        if solution.pressure[[0, -1]].any() and width < widest:
            return self.requirements.width(CONSTANTS.widening * width)
        # random heights depend on the extent
        if any(getattr(shape, "extent", ()) is None for shape in self.scene.shapes):
            return None
        needed = GRID.width_factor * contact_width(solution)
        return needed if needed < CONSTANTS.narrowing * width else None

    def _with_width(self, grid: Grid, width: float) -> Grid:
        """Return `grid` with another width, and cells no larger."""
        wider = max(width / grid.extent[0], 1.0)
        return self.grid_of_fast_lengths(
            grid.cells[0] * wider, grid.cells[1], (width, grid.extent[1])
        )

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
                / self._allowed_error(last)
                * (present / limit) ** self._order_in_cells(levels)
            )
            if CONSTANTS.out_of_reach < missed < inf:
                limit = min(CONSTANTS.max_cells_out_of_reach, limit)
            factor = CONSTANTS.safety * limit / prod(required_cells)
            required_cells = _scaled(required_cells, factor)
        axes = 1 if required_cells[1] == 1 else 2
        is_last = (prod(required_cells) / present) ** (1 / axes) <= CONSTANTS.max_cell_ratio
        if not is_last:
            required_cells = _at_most(_scaled(required_cells, 0.5**axes), last.grid.cells)
        grid = self.grid_of_fast_lengths(*required_cells, last.grid.extent)
        while prod(grid.cells) > self.most_cells:  # counts are rounded up
            required_cells = _scaled(required_cells, CONSTANTS.safety)
            grid = self.grid_of_fast_lengths(*required_cells, last.grid.extent)
        return (grid if prod(grid.cells) > present else None), is_last

    def meets_error(self, level: BoundedSolution) -> bool:
        """Return whether the discretisation error is no larger than allowed."""
        return level.discretisation_error <= self._allowed_error(level)

    def _allowed_error(self, level: BoundedSolution) -> float:
        """Return the allowed discretisation error: the requested one minus the other causes, at least half of these."""
        other_causes = level.bound - level.discretisation_error if level.bound < inf else 0.0
        return max(self.error - other_causes, 0.5 * other_causes)

    def required_cells(self, levels: list[BoundedSolution]) -> tuple[float, float]:
        """Return the minimum number of cells (across, along) whose bound is expected to meet the error."""
        last = levels[-1]
        nx, ny = last.grid.cells
        min_cells = self.min_cells(last.grid.extent)
        present = last.discretisation_error
        if present == inf:
            grown = [CONSTANTS.growth_without_bound * count for count in (nx, ny)]
            return max(grown[0], min_cells[0]), max(grown[1], min_cells[1]) if ny > 1 else 1.0
        factor = present / (CONSTANTS.safety * self._allowed_error(last))
        if ny == 1:
            return max(nx * factor ** (1 / self.order(levels, 0)), CONSTANTS.min_growth * nx), 1.0
        order_x, order_y = (self.order(levels, axis) for axis in (0, 1))
        # least product of both counts under the sum of both errors: r_x times the error across is r_y times that along
        remaining = [1 / factor * order / (order_x + order_y) for order in (order_y, order_x)]
        counts = [
            max(count * max(fraction / allowed, 1e-3) ** (1 / order), 0.5 * count)
            for count, fraction, allowed, order in zip(
                (nx, ny), last.fractions, remaining, (order_x, order_y), strict=True
            )
        ]
        growth = prod(counts) / (nx * ny)
        if growth < CONSTANTS.min_growth:
            counts = [count * (CONSTANTS.min_growth / growth) ** 0.5 for count in counts]
        return max(counts[0], min_cells[0]), max(counts[1], min_cells[1])

    def order(self, levels: list[BoundedSolution], axis: int) -> float:
        """Return the expected order of convergence along an axis."""
        # the edges across a roller are smooth
        is_smooth = not levels[-1].is_sharp or (self.requirements.roller_length > 0 and axis == 0)
        usual = CONSTANTS.smooth_order if is_smooth else CONSTANTS.step_order
        if len(levels) < 2 or levels[-1].grid.cells[1] == 1:
            return usual
        coarse, fine = ((level.cell_errors[axis], level.grid.cells[axis]) for level in levels[-2:])
        if fine[1] < 1.2 * coarse[1] or not 0 < fine[0] < coarse[0]:
            return usual
        observed = log(coarse[0] / fine[0]) / log(fine[1] / coarse[1])
        return float(np.clip((observed + usual) / 2, CONSTANTS.min_order, CONSTANTS.smooth_order))

    def _order_in_cells(self, levels: list[BoundedSolution]) -> float:
        """Return the expected order of convergence in the number of cells."""
        orders = [self.order(levels, axis) for axis in (0, 1)]
        return orders[0] if levels[-1].grid.cells[1] == 1 else 1 / (1 / orders[0] + 1 / orders[1])

    def reason_not_met(self, levels: list[BoundedSolution]) -> str:
        """Return why the bound on the last grid is above the error."""
        last = levels[-1]
        if last.bound == inf:
            return " ".join(last.estimate.warnings)
        for cause, fraction in last.estimate.l1.by_cause.items():
            if cause in OTHER_CAUSES and fraction >= self.error:
                return f"{OTHER_CAUSES[cause][0]} {100 * fraction:.2g} %: {OTHER_CAUSES[cause][1]}."
        missed = last.discretisation_error / self._allowed_error(last)
        grown = missed ** (1 / self._order_in_cells(levels))
        cells = f"{prod(last.grid.cells) * grown:.1g}"
        return f"the error needs about {cells} cells; at most {self.most_cells:,} are allowed."


def contact_width(solution: Solution) -> float:
    """Return the width [m] about the axis within which all cells in contact lie."""
    grid = solution.problem.grid
    touching = np.abs(grid.x[solution.pressure.any(axis=1)])
    return float(2 * touching.max(initial=0.0)) + grid.cell_size[0]


def _end_misfit(count: int, fraction: float) -> float:
    """Return the distance from a roller's end to the nearest border of cells, over its length."""
    rows = count * fraction
    nearest = round((rows - count % 2) / 2) * 2 + count % 2
    return abs(nearest - rows) / 2 / rows


def _scaled(required_cells: tuple[float, float], factor: float) -> tuple[float, float]:
    """Return cells (across, along) whose product is `factor` times that of `required_cells`."""
    if required_cells[1] == 1:
        return required_cells[0] * factor, 1.0
    return required_cells[0] * factor**0.5, required_cells[1] * factor**0.5


def _at_most(required_cells: tuple[float, float], cells: tuple[int, int]) -> tuple[float, float]:
    """Return `required_cells` (across, along), no fewer than `cells` and no more than the largest factor allows."""
    across, along = (
        float(max(min(count, CONSTANTS.max_growth * present), present))
        for count, present in zip(required_cells, cells, strict=True)
    )
    return across, along

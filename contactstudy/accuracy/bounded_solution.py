"""Discretisation error from several grids: changes between solutions, and the errors that their cells show."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, log, sqrt

import numpy as np

from contactstudy.accuracy.coarser import change, halved
from contactstudy.accuracy.contact_edge import edge_error_of_means
from contactstudy.accuracy.discretisation import around_contact, with_ends
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.accuracy.subcell import SubgridHeights
from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, axis_first
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import Solution

# Orders of convergence: the least, of smooth edges, and where a corner or a roller's end is in contact.
MIN_ORDER, SMOOTH_ORDER, STEP_ORDER = 0.5, 1.5, 1.0
# Fraction of a coarser grid's error that remains, up to which its change is used to estimate the error.
MAX_REMAINING_ERROR = 0.65
# Fraction of the peak pressure that a corner adds at each halving of the cells, from which convergence is of first
# order.
CORNER_RISE = 0.01
# Bound over the errors that the cells show, where all edges are smooth and where they are not, over the error that the
# changes give, and over the fraction of the load whose cells hide heights: set on 260 random scenes, where true errors
# were half of the bound in the median, and judged on 220 others with slightly smaller ones, where none was larger than
# the bound.
CELL_ERRORS_MARGIN, CELL_ERRORS_MARGIN_AT_STEPS, CHANGE_MARGIN, HIDDEN_MARGIN = 0.8, 1.05, 1.6, 0.35
# Relative L1 error over the length by which the cells make either end of a roller too long or too short.
END_ERROR = 4.0
# Error in the end row of a roller over its rise above the next row, where the cell is as long as the half-width.
END_RISE_ERROR = 0.4


@dataclass(frozen=True)
class BoundedSolution:
    """A solution with the bounds that all grids solved so far give.

    Attributes
    ----------
    solution
        The solution.
    estimate
        Bounds by cause.
    cell_errors
        Errors (across, along) that the cells show, see :func:`cell_errors`.
    is_sharp
        Whether a corner or a roller's end is in contact, so that convergence is of first order.
    """

    solution: Solution
    estimate: ErrorEstimate
    cell_errors: tuple[float, float]
    is_sharp: bool

    @property
    def grid(self) -> Grid:
        """Grid of the solution."""
        return self.solution.problem.grid

    @property
    def bound(self) -> float:
        """Upper estimate of the relative L1 error of the pressure."""
        return self.estimate.l1.total

    @property
    def discretisation_error(self) -> float:
        """Discretisation error, as part of the bound."""
        part = self.estimate.l1.discretisation
        return inf if part is None else part

    @property
    def fractions(self) -> tuple[float, float]:
        """Contributions (across, along) to the discretisation error, as fractions of it."""
        across, along = self.cell_errors
        fraction = across / (across + along) if across + along else 1.0
        return fraction, 1 - fraction


def bounded(solution: Solution, coarser: Sequence[Solution]) -> BoundedSolution:
    """Return `solution` with bounds by its own cells and by its change from `coarser` grids.

    The discretisation error in L1 is at most the estimate from one solution. In two dimensions many edges share in it,
    so that what changes from grid to grid, with its order of convergence, and the errors that the cells show give a
    sharper bound together. In one dimension a change may be small by the place of two edges in their cells, and is not
    used.

    Parameters
    ----------
    solution
        The solution on the finest grid.
    coarser
        The same contact on coarser grids, the finest of them last.
    """
    problem = solution.problem
    heights = SubgridHeights.from_problem(problem)
    is_halved = bool(coarser) and coarser[-1].problem.grid == halved(problem.grid)
    coarse = coarser[-1] if is_halved else None
    estimate = error_estimate(solution, coarse=coarse, heights=heights)
    inside = heights.effect_under(problem, solution.pressure) if heights else None
    is_sharp = (inside is not None and inside.corner > CORNER_RISE) or bool(_loaded_ends(solution))
    result = BoundedSolution(solution, estimate, cell_errors(solution), is_sharp)
    present = result.discretisation_error
    if inside is None or not coarser or solution.pressure.shape[1] == 1 or present == inf:
        return result
    # the end of a roller within the grid hides a step as high as the roller is long
    hidden = 0.0 if _row_lengths(problem) is not None else inside.uncertain
    by_cells = (CELL_ERRORS_MARGIN_AT_STEPS if is_sharp else CELL_ERRORS_MARGIN) * sum(
        result.cell_errors
    )
    by_change = min(present, CHANGE_MARGIN * error_by_change(result, coarser))
    bound = max(by_cells, by_change, HIDDEN_MARGIN * hidden)
    if not _loaded_ends(solution):  # of a sharp end the estimate from one solution shows little
        bound = min(present, bound)
    return replace(
        result, estimate=replace(estimate, l1=replace(estimate.l1, discretisation=bound))
    )


def error_by_change(fine: BoundedSolution, coarser: Sequence[Solution]) -> float:
    """Return the relative L1 error of the finest grid, estimated from the changes of the pressure from coarser grids.

    With errors ``s_x h_x^r + s_y h_y^r`` that are as good as random from grid to grid, the change between two grids has
    the square of both errors. The order r is the larger of those of the changes from two grids and of the errors that
    the cells show, within the limits of smooth edges and of steps. The last grid counts that is coarser along both axes.
    """
    errors: list[tuple[float, float]] = []
    for number in reversed(range(len(coarser))):
        order = _convergence_order(fine, coarser[max(number - 1, 0) : number + 1])
        remaining = sum(
            fraction * (finer / coarse) ** order
            for fraction, finer, coarse in zip(
                fine.fractions, fine.grid.cell, coarser[number].problem.grid.cell, strict=True
            )
        )
        if remaining < 1:
            last_change = change(fine.solution, coarser[number]).l1
            errors.append((remaining, last_change * remaining / sqrt(1 - remaining**2)))
        if remaining <= MAX_REMAINING_ERROR:
            return errors[-1][1]
    return min(errors, default=(inf, inf))[1]


def _convergence_order(fine: BoundedSolution, coarser: Sequence[Solution]) -> float:
    """Return the order of convergence from one or two `coarser` grids to the finest."""
    changes = [change(fine.solution, solution).l1 for solution in coarser]
    by_cell_errors = [sum(cell_errors(coarser[-1])), sum(fine.cell_errors)]
    areas = [solution.problem.grid.cell_area for solution in coarser]
    orders = [MIN_ORDER]
    for errors, area in (
        (changes, areas[0] / areas[-1]),
        (by_cell_errors, areas[-1] / fine.grid.cell_area),
    ):
        if len(errors) == 2 and min(errors) > 0 and area > 1:
            orders.append(2 * log(errors[0] / errors[1]) / log(area))
    return min(max(orders), STEP_ORDER if fine.is_sharp else SMOOTH_ORDER)


def cell_errors(solution: Solution) -> tuple[float, float]:
    """Return the relative L1 error of the pressure that each axis (across, along) shows in the cells of `solution`.

    These are the ends of rows of touching cells, by the law of the edge, and a 12th of the second differences within.
    Cells that bear the hardness count as exact, as do those beside them. At the loaded end of a roller, see
    :func:`_end_error`.
    """
    problem, lengths = solution.problem, _row_lengths(solution.problem)
    assert problem.paddings is not None
    pressure = solution.pressure[around_contact(solution.pressure)]
    if lengths is not None:  # a roller ends there as at the end of the grid
        pressure = pressure[:, lengths > 0]
    limited = (problem.constraint.free(pressure) == 0) & (pressure > 0)
    across, along = (
        _axis_error(axis_first(pressure, axis), axis_first(limited, axis), wraps=padding.wraps)
        if pressure.shape[axis] > 1
        else 0.0
        for axis, padding in enumerate(problem.paddings)
    )
    total = float(pressure.sum())
    return across / total, along / total + _end_error(solution)


def _axis_error(along: Array, limited: Array, *, wraps: bool) -> float:
    """Return the sum of the pressure errors that `along` (n, lines) shows along its first axis."""
    padded = with_ends(along, 1, wraps=wraps)
    exact = with_ends(limited, 1, wraps=wraps) > 0
    touching = padded > 0
    before, after = slice(None, -2), slice(2, None)
    second_differences = np.abs(padded[before] + padded[after] - 2 * along)
    within = touching[before] & touching[1:-1] & touching[after]
    within &= ~(exact[before] | exact[1:-1] | exact[after])
    error = float(second_differences[within].sum()) / 12
    for beyond, inward in ((before, after), (after, before)):
        ends = touching[1:-1] & ~touching[beyond] & ~exact[inward]
        error += float(edge_error_of_means(along[ends], padded[inward][ends]).sum())
    return error


def _end_error(solution: Solution) -> float:
    """Return the relative L1 error at the loaded ends of a roller, beyond that of second differences.

    Towards a sharp end the pressure rises like the inverse root of the distance from it, within about a half-width a.
    The end row misses ``END_RISE_ERROR (dy / a)^(1/2)`` of its rise above the next one. Cells that an end divides make
    the roller too long or too short.
    """
    ends, grid, pressure = _loaded_ends(solution), solution.problem.grid, solution.pressure
    if not ends:
        return 0.0
    total, error = float(pressure.sum()), 0.0
    for row, inner in ends:
        half_width = np.count_nonzero(pressure[:, row]) * grid.cell[0] / 2
        rise = float(np.abs(pressure[:, row] - pressure[:, inner]).sum()) / total
        error += (END_RISE_ERROR * sqrt(grid.cell[1] / half_width) - 1 / 12) * rise
    lengths = _row_lengths(solution.problem)
    if lengths is None:
        return error
    length = float(lengths.sum())
    return error + END_ERROR * abs(np.count_nonzero(lengths) - length) / 2 / length


def _loaded_ends(solution: Solution) -> list[tuple[int, int]]:
    """Return the rows at the loaded ends of a roller, each with the next one inward."""
    problem, count = solution.problem, solution.pressure.shape[1]
    if count < 2 or problem.source is None or not problem.source.ends_along:
        return []
    lengths = _row_lengths(problem)
    rows = np.arange(count) if lengths is None else np.flatnonzero(lengths)
    pairs = ((int(rows[0]), int(rows[1])), (int(rows[-1]), int(rows[-2]))) if len(rows) > 1 else ()
    return [pair for pair in pairs if solution.pressure[:, pair[0]].any()]


def _row_lengths(problem: Problem) -> Array | None:
    """Return the fraction of each row of cells that a roller covers (y,); None where none ends within the grid."""
    lengths = getattr(problem.source, "row_lengths", lambda _: None)(problem.grid)
    return None if lengths is None else np.asarray(lengths)

"""Error by the cells from several grids: changes between solutions beside the law of the cells."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, log, sqrt

import numpy as np

from contactstudy.accuracy.coarser import change, halved
from contactstudy.accuracy.contact_edge import edge_renderings
from contactstudy.accuracy.discretisation import around_contact, axis_first, with_ends
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.accuracy.subcell import HeightsInside
from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import Solution

# Powers of the cell with which errors fall: least, of smooth edges, and where a corner or a roller's end bears pressure.
LEAST, SMOOTH, STEP = 0.5, 1.5, 1.0
# Share of a coarser grid's error that remains, up to which its change tells of the error.
COARSER = 0.65
# Share of the peak pressure that a corner adds at each halving of the cells, from which errors fall as at a step.
CORNER = 0.01
# Bound over the law of the cells, where all edges are smooth and where they are not, over the error that the changes
# give, and over the share of the load whose cells hide heights: set on 260 random scenes, where true errors were half of
# the bound in the median, and judged on 220 others with slightly smaller ones, where none was larger than the bound.
BY_LAW, BY_LAW_AT_STEPS, BY_CHANGE, BY_HIDDEN = 0.8, 1.05, 1.6, 0.35
# Relative L1 error over the length by which the cells make either end of a roller too long or too short.
BY_END = 4.0
# Error in the end row of a roller over its rise above the next row, where the cell is as long as the half-width.
BY_RISE = 0.4


@dataclass(frozen=True)
class Judged:
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
        Whether a corner or a roller's end bears pressure, so that errors fall as slowly as at a step.
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
    def cells_error(self) -> float:
        """Part of the bound that the cells cause."""
        part = self.estimate.l1.discretisation
        return inf if part is None else part

    @property
    def shares(self) -> tuple[float, float]:
        """Shares (across, along) of the error by the cells."""
        across, along = self.cell_errors
        share = across / (across + along) if across + along else 1.0
        return share, 1 - share


def judged(solution: Solution, coarser: Sequence[Solution]) -> Judged:
    """Return `solution` with bounds by its own cells and by its change from `coarser` grids.

    The L1 error by the cells is at most the estimate from one solution. In two dimensions many edges share in it, so
    that what changes from grid to grid, with the rate at which it falls, and the law of the cells give a sharper bound
    together. In one dimension a change may be small by the place of two edges in their cells, and is not used.

    Parameters
    ----------
    solution
        The solution on the finest grid.
    coarser
        The same contact on coarser grids, the finest of them last.
    """
    problem = solution.problem
    heights = HeightsInside.from_problem(problem)
    is_halved = bool(coarser) and coarser[-1].problem.grid == halved(problem.grid)
    coarse = coarser[-1] if is_halved else None
    estimate = error_estimate(solution, coarse=coarse, heights=heights)
    inside = heights.under(problem, solution.pressure) if heights else None
    is_sharp = (inside is not None and inside.corner > CORNER) or bool(_bearing_ends(solution))
    found = Judged(solution, estimate, cell_errors(solution), is_sharp)
    present = found.cells_error
    if inside is None or not coarser or solution.pressure.shape[1] == 1 or present == inf:
        return found
    # the end of a roller within the grid hides a step as high as the roller is long
    hidden = 0.0 if _row_lengths(problem) is not None else inside.uncertain
    by_cells = (BY_LAW_AT_STEPS if is_sharp else BY_LAW) * sum(found.cell_errors)
    by_change = min(present, BY_CHANGE * error_by_change(found, coarser))
    bound = max(by_cells, by_change, BY_HIDDEN * hidden)
    if not _bearing_ends(solution):  # of a sharp end the estimate from one solution shows little
        bound = min(present, bound)
    return replace(found, estimate=replace(estimate, l1=replace(estimate.l1, discretisation=bound)))


def error_by_change(fine: Judged, coarser: Sequence[Solution]) -> float:
    """Return the relative L1 error that the changes of the pressure from coarser grids tell of the finest.

    With errors ``s_x h_x^r + s_y h_y^r`` that are as good as random from grid to grid, the change between two grids has
    the square of both errors. The power r is the larger of those with which the changes from two grids and the law of
    the cells fall, within the limits of smooth edges and of steps. The last grid counts that is coarser along both axes.
    """
    errors: list[tuple[float, float]] = []
    for number in reversed(range(len(coarser))):
        rate = _rate(fine, coarser[max(number - 1, 0) : number + 1])
        remaining = sum(
            share * (finer / coarse) ** rate
            for share, finer, coarse in zip(
                fine.shares, fine.grid.cell, coarser[number].problem.grid.cell, strict=True
            )
        )
        if remaining < 1:
            moved = change(fine.solution, coarser[number]).l1
            errors.append((remaining, moved * remaining / sqrt(1 - remaining**2)))
        if remaining <= COARSER:
            return errors[-1][1]
    return min(errors, default=(inf, inf))[1]


def _rate(fine: Judged, coarser: Sequence[Solution]) -> float:
    """Return the power of the cell with which the error falls from one or two `coarser` grids to the finest."""
    changes = [change(fine.solution, solution).l1 for solution in coarser]
    by_law = [sum(cell_errors(coarser[-1])), sum(fine.cell_errors)]
    areas = [solution.problem.grid.cell_area for solution in coarser]
    rates = [LEAST]
    for errors, area in (
        (changes, areas[0] / areas[-1]),
        (by_law, areas[-1] / fine.grid.cell_area),
    ):
        if len(errors) == 2 and min(errors) > 0 and area > 1:
            rates.append(2 * log(errors[0] / errors[1]) / log(area))
    return min(max(rates), STEP if fine.is_sharp else SMOOTH)


def cell_errors(solution: Solution) -> tuple[float, float]:
    """Return the relative L1 error of the pressure that each axis (across, along) shows in the cells of `solution`.

    These are the ends of rows of touching cells, by the law of the edge, and a 12th of the second differences within.
    Cells that bear the hardness count as exact, as do those beside them. At the end of a roller that bears pressure, see
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
    bends = np.abs(padded[before] + padded[after] - 2 * along)
    within = touching[before] & touching[1:-1] & touching[after]
    within &= ~(exact[before] | exact[1:-1] | exact[after])
    error = float(bends[within].sum()) / 12
    for beyond, inward in ((before, after), (after, before)):
        ends = touching[1:-1] & ~touching[beyond] & ~exact[inward]
        error += float(edge_error_of_means(along[ends], padded[inward][ends]).sum())
    return error


def edge_error_of_means(last: Array, inner: Array) -> Array:
    """Return the L1 error at an edge of a smooth contact against the means in the cells, from the two cells beside it.

    Other than :func:`~contactstudy.accuracy.contact_edge.edge_error`, which bounds a single edge, it is expected to hold
    in the mean over many edges.

    Parameters
    ----------
    last
        Pressure of the last touching cell at each edge.
    inner
        Pressure of the next cell inward; 0 where it does not touch.
    """
    _, _, error, outer, second = edge_renderings()
    ratio = outer / second
    inner = np.maximum(inner, last / ratio[-1])
    return np.asarray(np.interp(last / inner, ratio, error / second) * inner)


def _end_error(solution: Solution) -> float:
    """Return the relative L1 error at the ends of a roller that bear pressure, beyond that of second differences.

    Towards a sharp end the pressure rises like the inverse root of the distance from it, within about a half-width a.
    The end row misses ``BY_RISE (dy / a)^(1/2)`` of its rise above the next one. Cells that an end divides make the
    roller too long or too short.
    """
    ends, grid, pressure = _bearing_ends(solution), solution.problem.grid, solution.pressure
    if not ends:
        return 0.0
    total, error = float(pressure.sum()), 0.0
    for row, inner in ends:
        half_width = np.count_nonzero(pressure[:, row]) * grid.cell[0] / 2
        rise = float(np.abs(pressure[:, row] - pressure[:, inner]).sum()) / total
        error += (BY_RISE * sqrt(grid.cell[1] / half_width) - 1 / 12) * rise
    lengths = _row_lengths(solution.problem)
    if lengths is None:
        return error
    length = float(lengths.sum())
    return error + BY_END * abs(np.count_nonzero(lengths) - length) / 2 / length


def _bearing_ends(solution: Solution) -> list[tuple[int, int]]:
    """Return the rows at the ends of a roller that bear pressure, each with the next one inward."""
    problem, count = solution.problem, solution.pressure.shape[1]
    if count < 2 or problem.source is None or not problem.source.ends_along:
        return []
    lengths = _row_lengths(problem)
    rows = np.arange(count) if lengths is None else np.flatnonzero(lengths)
    pairs = ((int(rows[0]), int(rows[1])), (int(rows[-1]), int(rows[-2]))) if len(rows) > 1 else ()
    return [pair for pair in pairs if solution.pressure[:, pair[0]].any()]


def _row_lengths(problem: Problem) -> Array | None:
    """Return the length of a roller in each row of cells, over that of a cell; None where none ends within the grid."""
    lengths = getattr(problem.source, "row_lengths", lambda _: None)(problem.grid)
    return None if lengths is None else np.asarray(lengths)

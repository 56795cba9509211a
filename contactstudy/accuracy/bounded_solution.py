"""Discretisation error from several grids: changes between solutions, and the errors that their cells show."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, log, sqrt

import numpy as np

from contactstudy.accuracy.discretisation.cells import around_contact, errors_along, with_ends
from contactstudy.accuracy.discretisation.coarser import change_between_grids, halved
from contactstudy.accuracy.discretisation.contact_edge import edge_error_of_means
from contactstudy.accuracy.discretisation.subcell import SubgridHeights
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.grid import Grid, axis_first
from contactstudy.solvers.solution import Solution


@dataclass(frozen=True)
class BoundConstants:
    """Constants of the bound from several grids.

    Attributes
    ----------
    min_order
        Least order of convergence.
    smooth_order
        Order where all edges of the contact are smooth.
    step_order
        Order where a corner or a roller's end is in contact.
    max_remaining_error
        Fraction of a coarser grid's error that remains, up to which its change is used to estimate the error.
    corner_rise
        Fraction of the peak pressure that a corner adds at each halving of the cells, from which convergence is of
        first order.
    cell_errors_margin
        Bound over the errors that the cells show where all edges are smooth. Like the three next, it was set on 260
        random scenes, where true errors were half of the bound in the median, and judged on 220 others with slightly
        smaller margins, where no error was larger than the bound.
    cell_errors_margin_at_steps
        The same where not all edges are smooth.
    change_margin
        Bound over the error that follows from the changes between grids.
    hidden_margin
        Bound over the fraction of the load whose cells hide heights.
    end_error
        Relative L1 error over the relative length by which the cells make either end of a roller too long or too short.
    end_rise_error
        Error in the end cells of a roller over their rise above the next ones, in cells as long as the half-width.
    """

    min_order: float = 0.5
    smooth_order: float = 1.5
    step_order: float = 1.0
    max_remaining_error: float = 0.65
    corner_rise: float = 0.01
    cell_errors_margin: float = 0.8
    cell_errors_margin_at_steps: float = 1.05
    change_margin: float = 1.6
    hidden_margin: float = 0.35
    end_error: float = 4.0
    end_rise_error: float = 0.4


CONSTANTS = BoundConstants()


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
        Errors (across, along) by the pressure of the cells, see :func:`cell_errors`.
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
        """Bound of the relative L1 error of the pressure, as calibrated: it is not proven."""
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

    The discretisation error in L1 is at most the estimate from one solution, unless the end of a roller is loaded, of
    which that shows little. In two dimensions many edges share in it, so that the changes from grid to grid, with their
    order of convergence, and the errors by the cells' pressure give a sharper bound together. In one dimension a change
    may be small by chance, as two edges lie alike in their cells; it is not used.

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
    is_sharp = (inside is not None and inside.corner_rise > CONSTANTS.corner_rise) or bool(
        _loaded_ends(solution)
    )
    result = BoundedSolution(solution, estimate, cell_errors(solution), is_sharp)
    present = result.discretisation_error
    if inside is None or not coarser or solution.pressure.shape[1] == 1 or present == inf:
        return result
    # the end of a roller within the grid hides a step as high as the roller is long
    hidden = 0.0 if problem.covered_fractions is not None else inside.hidden_load
    by_cells = (
        CONSTANTS.cell_errors_margin_at_steps if is_sharp else CONSTANTS.cell_errors_margin
    ) * sum(result.cell_errors)
    by_change = min(present, CONSTANTS.change_margin * error_by_change(result, coarser))
    bound = max(by_cells, by_change, CONSTANTS.hidden_margin * hidden)
    if not _loaded_ends(solution):  # of a sharp end the estimate from one solution shows little
        bound = min(present, bound)
    return replace(
        result, estimate=replace(estimate, l1=replace(estimate.l1, discretisation=bound))
    )


def error_by_change(fine: BoundedSolution, coarser: Sequence[Solution]) -> float:
    """Return the relative L1 error of the finest grid, estimated from the changes of the pressure from coarser grids.

    The square of the coarse grid's error is taken as that of the fine grid's error plus that of the change between
    them, with errors ``s_x h_x^r + s_y h_y^r`` on each grid. The order r is the larger of those of the changes from two
    grids and of the errors that the cells show, within the limits of smooth edges and of steps. The grid taken is the
    finest of the `coarser` ones of whose error at most ``BoundConstants.max_remaining_error`` remains; without one,
    that which gives the smallest error. The error is infinite where no grid is coarser.
    """
    errors: list[tuple[float, float]] = []
    for number in reversed(range(len(coarser))):
        order = _convergence_order(fine, coarser[max(number - 1, 0) : number + 1])
        remaining = sum(
            fraction * (finer / coarse) ** order
            for fraction, finer, coarse in zip(
                fine.fractions,
                fine.grid.cell_size,
                coarser[number].problem.grid.cell_size,
                strict=True,
            )
        )
        if remaining < 1:
            last_change = change_between_grids(fine.solution, coarser[number]).l1
            errors.append((remaining, last_change * remaining / sqrt(1 - remaining**2)))
        if remaining <= CONSTANTS.max_remaining_error:
            return errors[-1][1]
    return min(errors, default=(inf, inf))[1]


def _convergence_order(fine: BoundedSolution, coarser: Sequence[Solution]) -> float:
    """Return the order of convergence from one or two `coarser` grids to the finest."""
    changes = [change_between_grids(fine.solution, solution).l1 for solution in coarser]
    by_cell_errors = [sum(cell_errors(coarser[-1])), sum(fine.cell_errors)]
    areas = [solution.problem.grid.cell_area for solution in coarser]
    orders = [CONSTANTS.min_order]
    for errors, area in (
        (changes, areas[0] / areas[-1]),
        (by_cell_errors, areas[-1] / fine.grid.cell_area),
    ):
        if len(errors) == 2 and min(errors) > 0 and area > 1:
            orders.append(2 * log(errors[0] / errors[1]) / log(area))
    return min(max(orders), CONSTANTS.step_order if fine.is_sharp else CONSTANTS.smooth_order)


def cell_errors(solution: Solution) -> tuple[float, float]:
    """Return the relative L1 error of the pressure along each axis (across, along), by the pressure of the cells alone.

    It is that of the edges, by their law, and a 12th of the second differences within the contact. Cells at the hardness
    count as exact, as do their neighbours. The error at the loaded end of a roller is added to that along.
    """
    problem, lengths = solution.problem, solution.problem.covered_fractions
    assert problem.paddings is not None
    pressure = solution.pressure[around_contact(solution.pressure)]
    if lengths is not None:  # a roller ends there as at the end of the grid
        pressure = pressure[:, lengths > 0]
    limited = (problem.constraint.active(pressure) == 0) & (pressure > 0)
    across, along = (
        errors_along(
            with_ends(axis_first(pressure, axis), 1, wraps=padding.wraps),
            edge_error_of_means,
            with_ends(axis_first(limited, axis), 1, wraps=padding.wraps) > 0,
        )[0]
        if pressure.shape[axis] > 1
        else 0.0
        for axis, padding in enumerate(problem.paddings)
    )
    total = float(pressure.sum())
    return across / total, along / total + _end_error(solution)


def _end_error(solution: Solution) -> float:
    """Return the relative L1 error at the loaded ends of a roller, in addition to that of second differences.

    Towards a sharp end the pressure rises like the inverse square root of the distance from it, within about a
    half-width a. The line of end cells misses ``0.4 (dy / a)^(1/2)`` of its rise above the next one. Cells that an end
    divides make the roller too long or too short.
    """
    ends, grid, pressure = _loaded_ends(solution), solution.problem.grid, solution.pressure
    if not ends:
        return 0.0
    total, error = float(pressure.sum()), 0.0
    for iy, inward in ends:
        half_width = np.count_nonzero(pressure[:, iy]) * grid.cell_size[0] / 2
        rise = float(np.abs(pressure[:, iy] - pressure[:, inward]).sum()) / total
        error += (CONSTANTS.end_rise_error * sqrt(grid.cell_size[1] / half_width) - 1 / 12) * rise
    lengths = solution.problem.covered_fractions
    if lengths is None:
        return error
    length = float(lengths.sum())
    return error + CONSTANTS.end_error * abs(np.count_nonzero(lengths) - length) / 2 / length


def _loaded_ends(solution: Solution) -> list[tuple[int, int]]:
    """Return the indices along y of the loaded ends of a roller, each with the next one inward."""
    problem, count = solution.problem, solution.pressure.shape[1]
    if count < 2 or problem.source is None or not problem.source.ends_along:
        return []
    lengths = problem.covered_fractions
    iy = np.arange(count) if lengths is None else np.flatnonzero(lengths)
    pairs = ((int(iy[0]), int(iy[1])), (int(iy[-1]), int(iy[-2]))) if len(iy) > 1 else ()
    return [pair for pair in pairs if solution.pressure[:, pair[0]].any()]

"""A field of cell means on another grid of the same extent."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.problem.problem import Problem, Source
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions


def on_cells(field: Array, cells: tuple[int, int]) -> Array:
    """The means over ``cells`` of a ``field`` (x, y) that is constant in each of its own cells."""
    for axis, count in enumerate(cells):
        along = np.moveaxis(field, axis, 0)
        own = len(along)
        if own == count:
            continue
        # the integral up to each border, linear inside a cell
        sums = np.concatenate([np.zeros((1, along.shape[1])), np.cumsum(along, axis=0)])
        border = np.arange(count + 1) * (own / count)
        whole = np.minimum(border.astype(int), own - 1)
        up_to = sums[whole] + (border - whole)[:, None] * along[whole]
        field = np.moveaxis(np.diff(up_to, axis=0) * (count / own), 0, axis)
    return field


# The difference is wanted to two digits.
TOLERANCE = 1e-4


@dataclass(frozen=True)
class Change:
    """What of a solution changes from cells of twice the size to its own, relative.

    ``l1`` is the difference of the pressure as means over the coarse cells; ``peak_pressure`` by what share
    the peak pressure grows; ``contact_area`` and ``mean_gap`` by what shares these differ.
    """

    l1: float
    peak_pressure: float
    contact_area: float
    mean_gap: float


def halved(grid: Grid) -> Grid:
    """``grid`` with half as many cells along each axis, rounded up."""
    nx, ny = grid.cells
    return Grid((max(2, (nx + 1) // 2), (ny + 1) // 2), grid.extent)


def coarser_problem(problem: Problem) -> Problem | None:
    """``problem`` on cells of twice the size; None without a source, or where the source refuses.

    Heights that the source does not know of are averaged.
    """
    source = problem.source
    if source is None:
        return None
    try:
        coarse = source.problem(halved(problem.grid))
    except InvalidInput:
        return None
    added = _unknown_to(source, problem)
    if added is None:
        return coarse
    from dataclasses import replace

    gap = coarse.undeformed_gap + on_cells(added, coarse.grid.cells)
    return replace(coarse, undeformed_gap=gap)


def change(fine: Solution, coarse: Solution) -> Change:
    """How ``fine`` differs from ``coarse``, the same contact on cells of twice the size."""
    means = on_cells(fine.pressure, coarse.pressure.shape)
    highest = float(fine.pressure.max() / coarse.pressure.max()) - 1
    areas = [float((one.pressure > 0).mean()) for one in (fine, coarse)]
    gaps = [float(one.gap.mean()) for one in (fine, coarse)]
    return Change(
        float(np.abs(means - coarse.pressure).sum() / means.sum()),
        highest,
        abs(areas[1] / areas[0] - 1),
        abs(gaps[1] / gaps[0] - 1) if gaps[0] else 0.0,
    )


def coarse_solution(problem: Problem) -> Solution | None:
    """The solution on cells of twice the size, to the digits that its difference needs."""
    coarse = coarser_problem(problem)
    return None if coarse is None else SolveOptions(TOLERANCE).solved(coarse)


def start_from(coarse: Solution, problem: Problem) -> Array:
    """The pressure of ``coarse`` on the cells of ``problem``, for :func:`~contactstudy.solve` to start from."""
    return on_cells(coarse.pressure, problem.grid.cells)


def _unknown_to(source: Source, problem: Problem) -> Array | None:
    """The heights in ``problem`` that its source does not have [m], or None."""
    added = problem.undeformed_gap - source.gap(problem.grid)
    known = np.abs(problem.undeformed_gap).max()
    return added if np.abs(added).max() > 1e-9 * known else None

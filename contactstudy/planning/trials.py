"""Trials of coarse grids, each judged by a solution on finer cells: they replace the margin of an estimate."""

from dataclasses import replace
from itertools import product
from math import ceil, hypot, inf, log, prod

import numpy as np

from contactstudy.accuracy.coarser import on_cells
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.domain.grid import Grid
from contactstudy.planning.cost import DIGITS, timed
from contactstudy.planning.grid_requirements import Needs
from contactstudy.planning.grid_search import (
    FASTEST,
    TOLERANCE,
    GridForecast,
    bound,
    by_law,
    contact_width,
)
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions

# Cells of the reference at most, and along an axis over those of the planned grid: at most, and at least.
REFERENCE, FINER, LEAST_FINER = 2**17, 12.0, 1.4
# Ratio of the cells along an axis from one tried grid to the next, of few and of many cells planned, and the number from
# which they are many; cells left free beside the contact.
STEP, LARGE_STEP, MANY, FREE = 2**0.25, 2**0.5, 2**12, 2.2
# Cells of a tried grid along an axis, at least, and at most over those planned.
LEAST, LARGER = 6, 2.5
# A measured error may be this many times smaller than forecast; from one grid to another that ratio varies by SCATTER,
# with the place of the contact's edges in their cells.
SLACK, SCATTER = 10.0, 1.5
# Cells of all tried grids together, half of them for grids that are expected to miss the error by less than SCATTER.
# A grid of less than CHEAP cells is tried though it is expected to miss it by SCATTER squared.
EFFORT, CHEAP = 2**17, 2**9
# Share of the requested error that a measured one may take: the error of the reference is only estimated.
KEPT = 0.9
# Share of the forecast error that each axis has at least.
LEAST_SHARE = 0.1
# Weight of the prior in the fit of measured errors, where a trial counts 1.
PRIOR = 0.5


def cheapest(scene: Scene, needs: Needs, planned: GridForecast, error: float) -> GridForecast:
    """Return the forecast of the grid of fewest cells, among those tried, whose measured error is at most `error`.

    Returns `planned` where that grid is not cheap to refine, or does not reach the error.

    Parameters
    ----------
    scene
        The scene, at rest.
    needs
        Its requirements.
    planned
        Forecast of a grid whose expected error is `error`.
    error
        Relative L1 error of the pressure.
    """
    present, padding = planned.grid, needs.padding()
    axes = 1 if present.cells[1] == 1 else 2
    finer = min(FINER, (REFERENCE / prod(present.cells)) ** (1 / axes))
    if by_law(scene, needs) or planned.error > error or finer < LEAST_FINER:
        return planned
    cells = ceil(finer * present.cells[0]), ceil(finer * present.cells[1]) if axes == 2 else 1
    options = SolveOptions(TOLERANCE)
    reference = options.solved(scene.problem(Grid(cells, present.extent), padding))
    reference_error = error_estimate(reference).l1.discretisation / bound(needs)
    if reference_error == inf:
        reference_error = planned.error_of(reference.problem.grid.cell)
    tried: list[tuple[float, float, float]] = []
    effort = 0
    for grid in _candidates(needs, planned, reference, SLACK * error):
        shares = _optimistic(planned, grid)
        # a few hundred cells cost nothing; at last only grids that are expected to reach the error
        cheap = prod(grid.cells) < CHEAP
        allowed = KEPT if effort > EFFORT else SCATTER**2 if cheap else SCATTER
        hopeless = tried and _expected(tried, *shares) > allowed * error
        if hopeless and grid != present:
            continue
        effort += prod(grid.cells)
        if effort > 2 * EFFORT:
            break
        trial = options.solved(scene.problem(grid, padding))
        if trial.status is not Status.CONVERGED:
            continue
        measured = hypot(_difference(trial, reference), reference_error)
        tried.append((*shares, measured))
        if measured <= KEPT * error:
            _, timing = timed(lambda grid: scene.problem(grid, padding), grid, 10.0**-DIGITS)
            across, along = planned.errors_of(grid.cell)
            ratio = float(measured / (across + along))
            return replace(
                planned,
                grid=grid,
                errors=(ratio * across, ratio * along),
                seconds=timing.setup + timing.solve,
                contact_width=contact_width(trial),
                reference=cells,
            )
    return planned


def _optimistic(planned: GridForecast, grid: Grid) -> tuple[float, float]:
    """Return the shares (across, along) of the error on `grid`, if both fall as those of smooth contacts."""
    across, along = (
        max(error, LEAST_SHARE * planned.error) * (size / present) ** FASTEST
        for error, size, present in zip(planned.errors, grid.cell, planned.grid.cell, strict=True)
    )
    return across, along if grid.cells[1] > 1 else 0.0


def _expected(tried: list[tuple[float, float, float]], across: float, along: float) -> float:
    """Return the error to expect of forecast shares (across, along), from `tried` ones with their measured errors.

    Each share is multiplied by a factor, by least squares of relative errors with a weak prior of one factor for both.
    """
    from scipy.optimize import nnls  # imported late: as slow to import as everything else

    shares, measured = np.array(tried)[:, :2], np.array(tried)[:, 2]
    usual = float(np.median(measured / shares.sum(axis=1)))
    rows = np.concatenate([shares / measured[:, None], PRIOR * np.eye(2) / usual])
    factors, _ = nnls(rows, np.append(np.ones(len(tried)), [PRIOR, PRIOR]))
    return float(factors @ (across, along))


def _candidates(
    needs: Needs, planned: GridForecast, reference: Solution, error: float
) -> list[Grid]:
    """Return grids about the contact with forecast errors up to `error`, those of fewest cells first."""
    fine = reference.problem.grid
    width = contact_width(reference)
    step = STEP if prod(planned.grid.cells) < MANY else LARGE_STEP
    counts = []
    for extent, finest, present in zip(
        (width, fine.period), needs.finest, planned.grid.cells, strict=True
    ):
        least = min(present, max(LEAST, ceil(extent / finest * (1 - 1e-9))))
        steps = int(log(LARGER * present / least) / log(step)) + 1 if present > 1 else 1
        counts.append(sorted({round(least * step**k) for k in range(steps)} | {present}))
    grids = []
    for nx, ny in product(*counts):
        # a whole number of cells of the reference, symmetric about the axis; random heights depend on the extent
        narrows = needs.roller and not needs.rough
        free = fine.extent[0] - width / (1 - FREE / nx) if narrows else 0.0
        beside = int(free / fine.cell[0] / 2)
        across = fine.cells[0] - 2 * max(beside, 0)
        grid = Grid((nx, ny), (across * fine.cell[0], fine.period))
        resolved = all(size <= wave for size, wave in zip(grid.cell, needs.finest, strict=True))
        if resolved:
            grids.append(grid)
    grids = [
        grid for grid in grids if planned.error_of(grid.cell) <= error and grid != planned.grid
    ]
    return sorted(
        [*grids, planned.grid], key=lambda grid: (prod(grid.cells), planned.error_of(grid.cell))
    )


def _difference(trial: Solution, reference: Solution) -> float:
    """Return the relative L1 difference of the pressure of `trial` from `reference`, of the same or a larger width."""
    fine, grid = reference.problem.grid, trial.problem.grid
    beside = (fine.cells[0] - round(grid.extent[0] / fine.cell[0])) // 2
    means = on_cells(reference.pressure[beside : fine.cells[0] - beside], grid.cells)
    return float(np.abs(trial.pressure - means).sum() / means.sum())

"""Small solutions of a scene, which show the error, the width and the time of a larger one."""

from dataclasses import dataclass
from math import ceil, inf, log2, prod
from time import process_time

import numpy as np

from contactstudy.accuracy.estimate import SHARP_EDGE, ErrorEstimate, error_estimate
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Padding, Paddings
from contactstudy.planning.cost import memory, padded
from contactstudy.planning.grid_requirements import halvable
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import solve

# Cells of a pilot at most, in one and in two dimensions, and the digits that it needs.
LINE, PLANE, TOLERANCE = 2**13, 2**16, 1e-5
# Powers of the cell with which an error falls: a step's, and a smooth contact's.
SLOWEST, FASTEST = 0.5, 1.5
# A bound over the error that it stands for: less than in all but a few cases of the accuracy matrix.
BOUND = 1.5
# Cells less than these show nothing.
FEWEST = 8


@dataclass(frozen=True)
class Forecast:
    """What pilots say of a solve on ``grid``.

    ``error`` is the relative L1 error to expect there, infinite where the pilots do not show the
    surface; it falls with the cell to the power ``rate``. ``cut_off`` says that the contact outgrows the grid;
    ``said`` is a sentence about what no grid mends, such as an infinite pressure, or
    empty; ``seconds`` of set-up and solve.
    """

    grid: Grid
    error: float
    rate: float
    cut_off: bool
    said: str
    seconds: float

    def error_of(self, cell: tuple[float, float]) -> float:
        """The error to expect of another ``cell`` (dx, dy) [m]."""
        steps = (size / own for size, own in zip(cell, self.grid.cell, strict=True))
        larger = max(steps) if self.grid.cells[1] > 1 else cell[0] / self.grid.cell[0]
        return float(self.error * larger**self.rate)

    def grid_for(self, error: float) -> Grid:
        """The coarsest grid of the same extent and elongation that keeps to ``error``."""
        return finer(self.grid, (self.error / error) ** (1 / self.rate))


def forecast(scene: Scene, grid: Grid, padding: Padding | Paddings) -> Forecast:
    """Solve ``scene`` on two coarse grids of the extent of ``grid``, and extrapolate to ``grid``."""
    most = LINE if grid.cells[1] == 1 else PLANE
    halvings = 0
    while prod(_coarsened(grid, halvings).cells) > most:
        halvings += 1
    fine, estimate, seconds = _pilot(scene, _coarsened(grid, halvings), padding)
    seconds *= _work(grid, padding) / _work(fine.problem.grid, padding)
    cut_off = fine.status is Status.CONTACT_AT_EDGE
    sharp = next((said for said in estimate.warnings if SHARP_EDGE in said), "")
    error, rate = estimate.l1.discretisation / BOUND, 1.0
    if halvings and error < inf:
        _, coarser, _ = _pilot(scene, _coarsened(grid, halvings + 1), padding)
        before = coarser.l1.discretisation / BOUND
        if before < inf:
            rate = float(np.clip(log2(before / error), SLOWEST, FASTEST))
        error *= 2 ** (-rate * halvings)
    return Forecast(grid, error, rate, cut_off, sharp, seconds)


def _pilot(
    scene: Scene, grid: Grid, padding: Padding | Paddings
) -> tuple[Solution, ErrorEstimate, float]:
    start = process_time()
    solution = solve(scene.problem(grid, padding), tolerance=TOLERANCE)
    seconds = process_time() - start
    return solution, error_estimate(solution), seconds


def _coarsened(grid: Grid, halvings: int) -> Grid:
    across, along = (ceil(count / 2**halvings) for count in grid.cells)
    least = FEWEST if grid.cells[1] > 1 else 1
    return Grid((max(across, FEWEST), max(along, min(least, grid.cells[1]))), grid.extent)


def _work(grid: Grid, padding: Padding | Paddings) -> float:
    points = padded(grid, padding)
    return points * log2(max(points, 2))


def finer(grid: Grid, times: float) -> Grid:
    """``grid`` with so many ``times`` as many cells along each axis, or a few more that halve often."""
    across, along = grid.cells
    return Grid(
        (halvable(across * times), halvable(along * times) if along > 1 else 1), grid.extent
    )


def affordable(grid: Grid, padding: Padding | Paddings, bytes_at_most: float) -> Grid:
    """``grid``, or the finest of its extent that a solve holds in so many bytes."""
    needed = memory(grid, padding)
    while needed > bytes_at_most:
        shrink = (bytes_at_most / needed) ** (1 if grid.cells[1] == 1 else 0.5) * 0.99
        across, along = (max(2, int(count * shrink)) for count in grid.cells)
        grid = Grid((across, along if grid.cells[1] > 1 else 1), grid.extent)
        needed = memory(grid, padding)
    return grid

"""The one model of cost: seconds of a solve from a timed one, and the bytes that it holds."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import exp, inf, log, pi, prod
from time import perf_counter, process_time

import numpy as np

from contactstudy.domain.device import ONE_THREAD, Device
from contactstudy.domain.grid import Grid, Padding, Paddings, across_and_along
from contactstudy.elasticity.convolution import padded_cells
from contactstudy.problem.memory import solve_bytes
from contactstudy.problem.problem import Problem
from contactstudy.scene.loads.constant_load import LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.roller import Cylinder
from contactstudy.scene.solids.bodies import HalfSpace
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions, solve_contact


@dataclass(frozen=True)
class TimingConstants:
    """Constants of timed solves and of the forecasts from them.

    Attributes
    ----------
    smooth_convolutions, rough_convolutions, tolerance
        FFT convolutions of the full grid in a solve of a smooth and of a rough contact to this tolerance, coarser grids
        included.
    sample_cells
        Cells along an axis of the solve that is timed where there is no timing.
    stress_cells
        Cells along an axis of the two grids on which stress is timed, at the most.
    large_sample
        Largest number of cells along an axis of the solve that is timed on a device.
    min_total_seconds
        Time for which quick solves are repeated, since the first fills caches and other processes
        interrupt.
    min_seconds
        Smallest time that is recorded.
    transform_overhead
        Overhead of a transform of any size, in units of N log N: the time of a transform of 80 x 80 cells.
    """

    smooth_convolutions: float = 35.0
    rough_convolutions: float = 42.0
    tolerance: float = 1e-8
    sample_cells: int = 128
    stress_cells: tuple[int, int] = (64, 256)
    large_sample: int = 512
    min_total_seconds: float = 0.02
    min_seconds: float = 1e-6
    transform_overhead: float = 5e4


CONSTANTS = TimingConstants()
SAMPLE_EXTENT = 2.4, 2.4


@dataclass(frozen=True)
class Timing:
    """Measured seconds of processor time of one solve.

    Attributes
    ----------
    grid, padding
        Cells and boundary conditions.
    convolutions
        FFT convolutions of the full grid.
    setup
        Seconds to set the problem up.
    solve
        Seconds to solve it.
    """

    grid: Grid
    padding: Padding | Paddings
    convolutions: float
    setup: float
    solve: float


def predicted_seconds(timing: Timing, grid: Grid, convolutions: float) -> float:
    """Return the seconds of set-up and solve on another `grid` with the padding of a timed solve, on one thread.

    They are in proportion to the work: of the set-up that of a transform of the cells, of the solve that of each of its
    FFT convolutions of the full grid.
    """

    def work(on: Grid, count: float) -> tuple[float, float]:
        return log_work(prod(on.cells)), log_work(padded_points(on, timing.padding), count)

    pairs = zip(work(grid, convolutions), work(timing.grid, timing.convolutions), strict=True)
    setup, solve = (exp(here - there) for here, there in pairs)
    return timing.setup * setup + timing.solve * solve


def timed(
    problem_on: Callable[[Grid], Problem], grid: Grid, tolerance: float
) -> tuple[Solution, Timing]:
    """Solve on `grid`, and return the solution with the mean seconds of as many runs as take twice `min_total_seconds`.

    Parameters
    ----------
    problem_on
        Returns the problem on a grid.
    grid
        The grid.
    tolerance
        Tolerance of the solver.
    """
    setup, solve, count = 0.0, 0.0, 0
    # some clocks tick every 4 to 16 ms: a single short run is not measurable
    while setup + solve < 2 * CONSTANTS.min_total_seconds:
        start = process_time()
        problem = problem_on(grid)
        ready = process_time()
        solution = solve_contact(problem, SolveOptions(tolerance))
        setup, solve, count = setup + ready - start, solve + process_time() - ready, count + 1
    assert problem.paddings is not None
    timing = Timing(
        grid,
        problem.paddings,
        max(solution.convolutions, 1.0),
        max(setup / count, CONSTANTS.min_seconds),
        max(solve / count, CONSTANTS.min_seconds),
    )
    return solution, timing


def stress_seconds(scene: Scene, grid: Grid, padding: Padding | Paddings) -> float:
    """Return the seconds of the stress that a scene names on a grid, from that at one depth on fewer of its cells.

    They have a part in proportion to the cells, from two such grids, and one that is the same on any. Each component of
    a tangential traction takes as long again as the pressure.
    """
    from contactstudy.scene.stress import SubsurfaceStressOperator

    paddings, seconds = across_and_along(padding), 0.0
    for output in scene.outputs:
        operator = output.of(scene.solids, grid, paddings)
        if not isinstance(operator, SubsurfaceStressOperator):
            continue
        count = len(operator.depths) or operator.count_searched(grid.extent[0])
        cells, durations = [], []
        for most in (CONSTANTS.stress_cells[0], *CONSTANTS.stress_cells):  # the first fills caches
            side = most if grid.cells[1] > 1 else most**2
            sample = Grid((min(grid.cells[0], side), min(grid.cells[1], most)), grid.extent)
            at_one_depth = replace(operator, grid=sample, depths=(grid.extent[0] / 8,))
            start = process_time()
            at_one_depth(np.ones(sample.cells))
            durations.append(process_time() - start)
            cells.append(prod(sample.cells))
        beyond = (prod(grid.cells) - cells[-1]) / max(cells[-1] - cells[-2], 1)
        seconds += count * (durations[-1] + max(durations[-1] - durations[-2], 0.0) * beyond)
    sticks = getattr(scene.friction, "sticks", False) and grid.cells[1] > 1
    return seconds * (1 if scene.friction is None else 2 + sticks)


def sample_timing(grid: Grid, padding: Padding | Paddings) -> Timing:
    """Time a smooth line contact on a small grid with as many dimensions as `grid`."""
    cells = CONSTANTS.sample_cells
    sample = Grid((cells, 1 if grid.cells[1] == 1 else cells), SAMPLE_EXTENT)
    problem_on = partial(_smooth_contact().problem, padding=padding)
    # what is imported or compiled once is not counted
    timed(problem_on, sample, CONSTANTS.tolerance)
    return timed(problem_on, sample, CONSTANTS.tolerance)[1]


def _smooth_contact() -> Scene:
    """Return a smooth line contact of modulus 1, 3.4 half-widths of which are in the sampled extent."""
    solids = HalfSpace(1.0, 0.0), HalfSpace(inf, 0.0)
    return Scene(LineLoad(pi / 800), solids, (Cylinder(100.0),))


def speedup(grid: Grid, padding: Padding | Paddings, device: Device) -> float:
    """Measure how many times faster a solve is on `device` than on one thread; 1 for one thread.

    A smooth line contact is solved on as many cells, at most `large_sample` along either axis.
    """
    if device == ONE_THREAD:
        return 1.0
    across, along = (min(count, CONSTANTS.large_sample) for count in grid.cells)
    problem = _smooth_contact().problem(Grid((across, along), SAMPLE_EXTENT), padding)
    return _seconds(problem, ONE_THREAD) / _seconds(problem, device)


def _seconds(problem: Problem, device: Device) -> float:
    """Return the wall time [s] of a solve on a device: the least of several, after a first one that fills caches."""
    options, durations = SolveOptions(CONSTANTS.tolerance), [inf]
    solve_contact(problem, options, device=device)
    while len(durations) < 3 or sum(durations[1:]) < CONSTANTS.min_total_seconds:
        start = perf_counter()
        solve_contact(problem, options, device=device)
        durations.append(perf_counter() - start)
    return min(durations)


def padded_points(grid: Grid, padding: Padding | Paddings) -> int:
    """Return the number of points of the padded transform."""
    return prod(padded_cells(grid, across_and_along(padding)))


def memory(grid: Grid, padding: Padding | Paddings) -> int:
    """Return the bytes that a solve holds at most."""
    return solve_bytes(grid, across_and_along(padding))


def log_work(points: float, repetitions: float = 1.0) -> float:
    """Return the logarithm of the work ``n N log N`` of N `points`, with a fixed overhead, n `repetitions` times."""
    return log(points * log(points) + CONSTANTS.transform_overhead) + log(repetitions)

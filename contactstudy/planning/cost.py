"""Cost of a solve: the bytes that it holds, and how much faster it is on a device."""

from math import inf, pi
from time import perf_counter

from contactstudy.domain.device import ONE_THREAD, Device
from contactstudy.domain.grid import Grid, Padding, Paddings, across_and_along
from contactstudy.problem.memory import solve_bytes
from contactstudy.problem.problem import Problem
from contactstudy.scene.loads.constant_load import LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.roller import Cylinder
from contactstudy.scene.solids.bodies import HalfSpace
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Largest number of cells along an axis of the solve that is timed on a device, its tolerance, and the seconds for which
# quick solves are repeated, since the first fills caches and other processes interrupt.
LARGE_SAMPLE, TOLERANCE, MIN_TOTAL_SECONDS = 512, 1e-8, 0.02
SAMPLE_EXTENT = 2.4, 2.4
# Fraction of the machine's free memory that a plan may take.
MEMORY_FRACTION = 0.8


def _smooth_contact() -> Scene:
    """Return a smooth line contact of modulus 1, 3.4 half-widths of which are in the sampled extent."""
    solids = HalfSpace(1.0, 0.0), HalfSpace(inf, 0.0)
    return Scene(LineLoad(pi / 800), solids, (Cylinder(100.0),))


def speedup(grid: Grid, padding: Padding | Paddings, device: Device) -> float:
    """Measure how many times faster a solve is on `device` than on one thread; 1 for one thread.

    A smooth line contact is solved on as many cells, at most 512 along either axis.
    """
    if device == ONE_THREAD:
        return 1.0
    across, along = (min(count, LARGE_SAMPLE) for count in grid.cells)
    problem = _smooth_contact().problem(Grid((across, along), SAMPLE_EXTENT), padding)
    return _seconds(problem, ONE_THREAD) / _seconds(problem, device)


def _seconds(problem: Problem, device: Device) -> float:
    """Return the wall time [s] of a solve on a device: the least of several, after a first one that fills caches."""
    options, durations = SolveOptions(TOLERANCE), [inf]
    solve_contact(problem, options, device=device)
    while len(durations) < 3 or sum(durations[1:]) < MIN_TOTAL_SECONDS:
        start = perf_counter()
        solve_contact(problem, options, device=device)
        durations.append(perf_counter() - start)
    return min(durations)


def memory(grid: Grid, padding: Padding | Paddings) -> int:
    """Return the bytes that a solve holds at most."""
    return solve_bytes(grid, across_and_along(padding))


def within_memory(grid: Grid, padding: Padding | Paddings, bytes_at_most: float) -> Grid:
    """Return `grid`, or the finest of the same extent and aspect ratio whose solve holds within `bytes_at_most`."""
    needed = memory(grid, padding)
    while needed > bytes_at_most and max(grid.cells) > 2:
        shrink = (bytes_at_most / needed) ** (1 if grid.cells[1] == 1 else 0.5) * 0.99
        across, along = (max(2, int(count * shrink)) for count in grid.cells)
        grid = Grid((across, along if grid.cells[1] > 1 else 1), grid.extent)
        needed = memory(grid, padding)
    return grid

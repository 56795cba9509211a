"""A plan: grid and padding for a scene, with expected error and cost, and the time and memory that a solve takes."""

from dataclasses import dataclass, field
from math import inf, pi
from time import perf_counter
from typing import TYPE_CHECKING

from contactstudy.domain.checks import set_fields
from contactstudy.domain.device import ONE_THREAD, Device
from contactstudy.domain.grid import Grid, Padding, Paddings, across_and_along
from contactstudy.domain.notebook import InNotebook
from contactstudy.problem.memory import solve_bytes
from contactstudy.problem.problem import Problem
from contactstudy.scene.loads.constant_load import LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.roller import Cylinder
from contactstudy.scene.solids.bodies import HalfSpace
from contactstudy.solvers.solve import SolveOptions, solve_contact

if TYPE_CHECKING:
    from contactstudy.planning.refinement import FirstGrids

# Largest number of cells along an axis of the solve that is timed on a device, its tolerance, and the seconds for which
# quick solves are repeated, since the first fills caches and other processes interrupt.
LARGE_SAMPLE, TOLERANCE, MIN_TOTAL_SECONDS = 512, 1e-8, 0.02
# Extent of that solve.
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
    durations = list[float]()
    while len(durations) < 4 or sum(durations[1:]) < MIN_TOTAL_SECONDS:
        start = perf_counter()
        solve_contact(problem, SolveOptions(TOLERANCE), device=device)
        durations.append(perf_counter() - start)
    return min(durations[1:])


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


@dataclass(frozen=True, kw_only=True)
class Plan(InNotebook):
    """A grid and a padding for a scene, with expected error and cost.

    Solve it with ``solve(plan.scene, plan.grid, plan.padding)``.

    Attributes
    ----------
    scene
        The scene. Its random surfaces have an extent: where the contact is narrower than they are, the grid is too.
    grid
        The grid on which a solve to the error is expected to end; a reason may name that on which it begins.
    padding
        The boundary conditions.
    dimension
        Dimension of the surface grid: 1 in plane strain, where nothing varies along the length; 2 of a contact in three
        dimensions.
    error
        Bound of the relative L1 error of the pressure to expect, with all its causes but the steps in time, from
        solutions on coarse grids. Of a film, the error requested. Infinite where they give none.
    seconds
        Seconds of processor time (with a device, of wall time) of a solve to the error: its plan, all grids and steps,
        their estimates, and the stress that a steady scene names, from solves on coarser grids just now. Imports,
        compilation, tables of a material, files and plots are not counted. Infinite where no coarser grid can be solved.
    bytes
        Bytes that a solve holds at most.
    period_check
        A sentence on how the period suits the scene.
    reasons
        A sentence for each choice.
    warnings
        A sentence for each fault of a grid that was given, and on a requested error that is out of reach.
    solves
        Number of contacts or films that are solved one after the other, where a scene changes in time or
        rolls.
    device
        Device that the seconds are for.
    first_grids
        Solutions of a static contact on the grids with which its solve begins; None of others, or on a given grid.
    """

    scene: Scene = field(repr=False)
    grid: Grid
    padding: Padding | Paddings
    dimension: int = field(init=False)
    error: float = inf
    seconds: float = inf
    bytes: int
    period_check: str
    reasons: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    solves: int = 1
    device: Device = ONE_THREAD
    first_grids: "FirstGrids | None" = field(default=None, repr=False)

    def __post_init__(self) -> None:
        set_fields(self, dimension=1 if self.grid.cells[1] == 1 else 2)

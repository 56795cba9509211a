"""A plan: grid and padding for a scene, with expected error and cost, and the time and memory that a solve takes.

How grid and error are found is not said here, but in `plan.py` and in ``forecast.py`` above this folder.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, pi, prod
from time import perf_counter
from typing import Any

from contactstudy.domain.device import ONE_THREAD, Device
from contactstudy.domain.errors import InNotebook
from contactstudy.domain.grid import Grid, Padding, Paddings, across_and_along
from contactstudy.elasticity.convolution import padded_cells
from contactstudy.planning.refinement import FirstGrids
from contactstudy.problem.problem import Problem, solve_bytes
from contactstudy.scene.loads import LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.roller import Cylinder
from contactstudy.scene.solids.bodies import HalfSpace
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Largest number of cells along an axis of the solve that is timed on a device, which then takes tenths of a second, and
# its tolerance, the default one.
LARGE_SAMPLE, TOLERANCE = 512, 1e-8
# Wall time [s] for which quick solves are repeated at least, since other processes interrupt them.
MIN_TOTAL_SECONDS = 0.02
# Fraction of the machine's free memory that a solve may take; the rest is for its estimate and for other programs.
MEMORY_FRACTION = 0.8


def speedup(grid: Grid, padding: Padding | Paddings, device: Device) -> float:
    """Return how many times faster a solve is on `device` than on one thread, as measured; 1 for one thread.

    A smooth line contact of the half-width 1, on a grid 3.4 half-widths wide, is solved on as many cells, at most 512
    along either axis.
    """
    if device == ONE_THREAD:
        return 1.0
    bodies = HalfSpace(1.0, 0.0), HalfSpace(inf, 0.0)
    across, along = (min(count, LARGE_SAMPLE) for count in grid.cells)
    smooth = Scene(LineLoad(pi / 4), bodies, (Cylinder(1.0),))
    problem = smooth.problem(Grid((across, along), (3.4, 3.4)), padding)
    return _seconds(problem, ONE_THREAD) / _seconds(problem, device)


def _seconds(problem: Problem, device: Device) -> float:
    """Return the wall time [s] of a solve on a device: the least of three or more, after one that fills caches."""
    durations = list[float]()
    while len(durations) < 4 or sum(durations[1:]) < MIN_TOTAL_SECONDS:
        start = perf_counter()
        solve_contact(problem, SolveOptions(TOLERANCE), device=device)
        durations.append(perf_counter() - start)
    return min(durations[1:])


def memory(grid: Grid, padding: Padding | Paddings) -> int:
    """Return the bytes that a solve on `grid` holds at most, the padded transforms included."""
    return solve_bytes(grid, prod(padded_cells(grid, across_and_along(padding))))


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
    error
        Bound of the relative L1 error of the pressure to expect, with all its causes but the steps in time, from
        solutions on coarse grids; infinite where these give none. Of a film, the error requested.
    seconds
        Seconds of processor time (with a device, of wall time) of a solve to the error, from the times of solves on
        coarser grids; infinite where none can be solved. Counted are the plan, all grids and steps, their estimates, and
        the stress that a steady scene names, and not imports, compilation, tables of a material, files and plots.
    bytes
        Bytes that a solve holds at most.
    reasons
        A sentence for each choice.
    warnings
        A sentence for each fault of a grid that was given, and on a requested error that is out of reach.
    device
        Device that the seconds are for.
    first_grids
        Solutions of a static contact on the grids with which its solve begins; None of others, or on a given grid.
    """

    scene: Scene = field(repr=False)
    grid: Grid
    padding: Padding | Paddings
    error: float = inf
    seconds: float = inf
    bytes: int
    reasons: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    device: Device = ONE_THREAD
    first_grids: FirstGrids | None = field(default=None, repr=False)

    @property
    def dimension(self) -> int:
        """Dimension of the surface grid: 1 in plane strain, where nothing varies along the length, else 2."""
        return 1 if self.grid.cells[1] == 1 else 2


def plan_on(
    scene: Scene, grid: Grid, padding: Padding | Paddings, reasons: Sequence[str], warnings: Sequence[str],
    **further: Any,
) -> Plan:  # fmt: skip
    """Return the plan of a scene on a `grid` with a `padding`, `reasons` and `warnings`, with the bytes of its solve.

    The `further` fields of :class:`Plan` are given by name.
    """
    return Plan(
        scene=scene, grid=grid, padding=padding, bytes=memory(grid, padding),
        reasons=tuple(reasons), warnings=tuple(warnings), **further,
    )  # fmt: skip

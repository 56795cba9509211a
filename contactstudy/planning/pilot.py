"""Seconds of a contact in time, or of one that rolls: a pilot on coarse cells counts the steps, one solve is timed."""

from dataclasses import dataclass
from math import inf
from time import process_time

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.evolution.evolve import evolve
from contactstudy.evolution.rolling import solve_rolling
from contactstudy.evolution.steps import TimeSteps
from contactstudy.planning.cost import timed
from contactstudy.planning.grid_requirements import CELL_FRACTION
from contactstudy.planning.transient_requirements import transient_requirements
from contactstudy.scene.scene import Scene

# Cells (across, along) of a pilot at most, fewer across where bodies yield, whose steps take long; the tolerance of the
# solves that are timed.
PILOT_CELLS, YIELDING_CELLS, TOLERANCE = (48, 12), 24, 1e-8
# TIME_LIMIT: seconds of a pilot's steps at most. If less than MIN_PROGRESS of the time is reached by then, an error
# ERROR_STEP times as large is tried, with which steps of first order become fewer by that factor.
TIME_LIMIT, MIN_PROGRESS, ERROR_STEP, SOLVES_PER_DOUBLE_STEP = 1.0, 0.25, 4.0, 3
# MAX_ERROR: largest error of a pilot. PLASTIC_POWER: power of the bytes of plastic operators with which seconds grow.
MAX_ERROR, PLASTIC_POWER = 0.3, 0.8
# Seconds with the finer grids on which some scenes are solved again, over those on the planned grid, in one dimension:
# between 1 and 2.5 in 8 scenes that creep, wear or roll. In two dimensions the ratio of two elastic solves, which do not
# begin with the step before, is too large by as much. Scenes that yield are mostly solved again on twice the cells.
REFINEMENT_COST, YIELDING_REFINEMENT_COST = 1.5, 4.0
# The same of the passes of rolling in two dimensions, most of which begin close to their end: between 0.3 and 0.8 in 5.
ROLLING_COST_ALONG = 0.5


@dataclass(frozen=True)
class Pilot:
    """Expected work of a scene in time.

    Attributes
    ----------
    seconds
        Seconds of processor time; infinite where nothing says when the scene ends.
    solves
        Number of solves on the planned grid.
    reason
        A sentence on both.
    """

    seconds: float
    solves: int
    reason: str


class _TimeLimitReached(Exception):
    """The pilot has reached its time limit."""


def pilot(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    error: float,
    steps: TimeSteps,
    *,
    refines: bool,
) -> Pilot:
    """Return the work of `scene` on `grid`, from its steps on a coarse grid.

    The number of time steps depends little on the cell size. They take as many times the pilot's seconds as an elastic
    solve takes on the planned grid, or, where plastic strain has operators of its own, by a power of their size.

    Parameters
    ----------
    scene
        The scene, which changes in time or rolls.
    grid, padding
        Planned cells and boundary conditions.
    error
        Relative L1 error of the pressure, of discretisation and time steps together.
    steps
        Instants that are recorded.
    refines
        Whether the grid is refined until its bound meets the error.
    """
    requirements = transient_requirements(scene, steps.last)
    nx, ny = grid.cells
    across = PILOT_CELLS[0] if requirements.plastic is None else YIELDING_CELLS
    coarse = Grid((min(nx, across), min(ny, PILOT_CELLS[1])), grid.extent)
    try:
        seconds, solves = _work(scene, coarse, padding, (1 - CELL_FRACTION) * error, steps)
    except InvalidInput as refused:
        return Pilot(inf, 1, f"seconds: unknown, since {refused}")
    if requirements.plastic is not None:
        slower = (
            requirements.plastic.bytes(grid) / requirements.plastic.bytes(coarse)
        ) ** PLASTIC_POWER
    else:
        fine, on_pilot = (
            timed(
                lambda of_grid: requirements.narrow.problem(of_grid, padding), each_grid, TOLERANCE
            )[1]
            for each_grid in (grid, coarse)
        )
        slower = (fine.setup + fine.solve) / (on_pilot.setup + on_pilot.solve)
    rounds = REFINEMENT_COST if refines and ny == 1 else 1.0
    if refines and requirements.plastic is not None:
        rounds = YIELDING_REFINEMENT_COST
    elif scene.rolling is not None and ny > 1:
        rounds = ROLLING_COST_ALONG
    total = rounds * seconds * max(slower, 1.0)
    return Pilot(
        total,
        solves,
        f"time: {solves} solves, counted on {coarse.cells[0]} x {coarse.cells[1]} cells, with those that estimate the "
        f"time-step error; some {total:.2g} s.",
    )


def _work(
    scene: Scene, grid: Grid, padding: Padding | Paddings, error: float, steps: TimeSteps
) -> tuple[float, int]:
    """Return the seconds and the solves of `scene` on `grid`."""
    if scene.rolling is not None and scene.rolling.passes is not None:
        # imported only for scenes with such passes
        from contactstudy.evolution.repeated_rolling import roll_repeatedly

        begin = process_time()
        passes = roll_repeatedly(scene, grid, padding).passes
        return process_time() - begin, sum(each_pass.steps for each_pass in passes)
    if scene.rolling is not None:
        begin = process_time()
        rolling = solve_rolling(scene, grid, padding)
        rolling.error_estimate()
        return process_time() - begin, rolling.lagged.outer_iterations
    times, larger = steps.instants_of(scene.load), 1.0
    while True:
        begin, reached, pairs = process_time(), 0.0, 0

        def stop(time: float, end: float, begin: float = begin) -> None:
            nonlocal reached, pairs
            reached, pairs = time / end, pairs + 1
            if process_time() - begin > TIME_LIMIT:
                raise _TimeLimitReached

        allowed = min(larger * error, MAX_ERROR)
        try:
            trajectory = evolve(scene, grid, padding, times=times, error=allowed, progress=stop)
        except _TimeLimitReached:
            if reached < MIN_PROGRESS and allowed < MAX_ERROR:
                larger *= ERROR_STEP
                continue
            factor = larger / max(reached, 1e-3)
            return factor * (process_time() - begin), round(factor * SOLVES_PER_DOUBLE_STEP * pairs)
        return larger * (process_time() - begin), round(larger * trajectory.steps)

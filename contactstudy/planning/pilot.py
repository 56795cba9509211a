"""Seconds of a contact in time, or of one that rolls: a pilot on coarse cells counts the steps, one solve is timed."""

from dataclasses import dataclass, replace
from functools import partial
from math import inf
from time import process_time

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.evolution.integration.evolve import evolve
from contactstudy.evolution.rolling.steady_rolling import solve_rolling
from contactstudy.evolution.time_steps import StepError, TimeSteps
from contactstudy.planning.cost import CONSTANTS as TIMING
from contactstudy.planning.cost import timed
from contactstudy.planning.grid_requirements import CONSTANTS as GRID
from contactstudy.planning.transient_requirements import transient_requirements
from contactstudy.scene.loads.constant_load import LineLoad
from contactstudy.scene.scene import Scene


@dataclass(frozen=True)
class PilotConstants:
    """Constants of a pilot and of the seconds that follow from it.

    Attributes
    ----------
    cells
        Most cells (across, along).
    yielding_cells
        Most cells across where bodies yield, whose steps take long.
    time_limit
        Largest seconds of a pilot's steps.
    min_progress
        Fraction of the time below which, at the limit, a larger error is tried.
    error_step
        Factor on that error, with which steps of first order become fewer by the same factor.
    solves_per_double_step
        Solves of a step with step doubling.
    max_error
        Largest error of a pilot.
    plastic_power
        Power of the bytes of plastic operators in the ratio of seconds.
    refinement_cost
        Seconds with the finer grids on which some scenes are solved again, over those on the planned grid, in one
        dimension: 1 to 2.5 in 8 scenes that creep, wear or roll. In two dimensions the ratio of two elastic solves,
        which do not begin with the step before, is too large by as much.
    yielding_refinement_cost
        The same of scenes that yield, which are mostly solved again on twice the cells.
    rolling_cost_along
        Factor on the seconds of rolling in two dimensions, where most outer iterations begin close to their end: 0.3 to
        0.8 in 5 scenes.
    """

    cells: tuple[int, int] = (48, 12)
    yielding_cells: int = 24
    time_limit: float = 1.0
    min_progress: float = 0.25
    error_step: float = 4.0
    solves_per_double_step: int = 3
    max_error: float = 0.3
    plastic_power: float = 0.8
    refinement_cost: float = 1.5
    yielding_refinement_cost: float = 4.0
    rolling_cost_along: float = 0.5


CONSTANTS = PilotConstants()


@dataclass(frozen=True)
class Pilot:
    """Expected work of a scene in time.

    Attributes
    ----------
    seconds
        Seconds of processor time; infinite where the scene has no end.
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

    The number of time steps depends little on the cell size. Their seconds are the pilot's times the ratio of two
    elastic solves, on the planned grid and on that of the pilot, or for plastic strain a power of the ratio of
    operator bytes.

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
    across = CONSTANTS.cells[0] if requirements.plastic is None else CONSTANTS.yielding_cells
    coarse = Grid((min(nx, across), min(ny, CONSTANTS.cells[1])), grid.extent)
    try:
        seconds, solves = _seconds_and_solves(
            scene, coarse, padding, (1 - GRID.cell_fraction) * error, steps
        )
    except InvalidInput as refused:
        return Pilot(inf, 1, f"seconds: unknown, since {refused}")
    if requirements.plastic is not None:
        bytes_of = requirements.plastic.bytes
        time_ratio = (bytes_of(grid) / bytes_of(coarse)) ** CONSTANTS.plastic_power
    else:
        problem_on = partial(requirements.narrow.problem, padding=padding)
        fine, on_pilot = (timed(problem_on, cells, TIMING.tolerance)[1] for cells in (grid, coarse))
        time_ratio = (fine.setup + fine.solve) / (on_pilot.setup + on_pilot.solve)
    refinement_factor = CONSTANTS.refinement_cost if refines and ny == 1 else 1.0
    if refines and requirements.plastic is not None:
        refinement_factor = CONSTANTS.yielding_refinement_cost
    elif scene.rolls and ny > 1:
        refinement_factor = CONSTANTS.rolling_cost_along
    total = refinement_factor * seconds * max(time_ratio, 1.0)
    return Pilot(
        total,
        solves,
        f"time: {solves} solves, counted on {coarse.cells[0]} x {coarse.cells[1]} cells, with those that estimate the "
        f"time-step error; some {total:.2g} s.",
    )


def _seconds_and_solves(
    scene: Scene, grid: Grid, padding: Padding | Paddings, error: float, steps: TimeSteps
) -> tuple[float, int]:
    """Return the seconds and the solves of `scene` on `grid`."""
    if scene.wears_steadily:
        # imported only for scenes that roll and wear
        from contactstudy.evolution.equilibrium.steady_wear import follow_wear

        begin, instants_of_wear = process_time(), steps.instants_of(scene.load)
        worn = follow_wear(scene, grid, padding, times=instants_of_wear, error=error)
        return process_time() - begin, worn.solves
    if scene.rolling is not None and scene.rolling.passes is not None:
        # imported only for scenes with such passes
        from contactstudy.evolution.rolling.repeated_rolling import roll_repeatedly

        begin = process_time()
        passes = roll_repeatedly(scene, grid, padding).passes
        return process_time() - begin, sum(each_pass.steps for each_pass in passes)
    if scene.rolls:
        instants, steady = 1, scene
        if scene.takes_times:
            instants = np.size(steps.instants_of(scene.load) or 1)
            steady = replace(scene, load=LineLoad(scene.load.largest))
        begin = process_time()
        rolling = solve_rolling(steady, grid, padding)
        rolling.error_estimate()
        seconds = instants * (process_time() - begin)
        return seconds, instants * rolling.lagged.outer_iterations
    error_factor = 1.0
    times = steps.instants_of(scene.load, getattr(scene.friction, "history", None))
    by_error = steps.step_error is StepError.STEP_DOUBLING
    while True:
        begin, reached, pairs = process_time(), 0.0, 0

        def stop_at_limit(time: float, end: float, begin: float = begin) -> None:
            nonlocal reached, pairs
            reached, pairs = time / end, pairs + 1
            if process_time() - begin > CONSTANTS.time_limit:
                raise _TimeLimitReached

        allowed = min(error_factor * error, CONSTANTS.max_error)
        try:
            trajectory = evolve(
                scene,
                grid,
                padding,
                times=times,
                error=allowed if by_error else None,
                step_error=steps.step_error,
                progress=stop_at_limit,
            )
        except _TimeLimitReached:
            if by_error and reached < CONSTANTS.min_progress and allowed < CONSTANTS.max_error:
                error_factor *= CONSTANTS.error_step
                continue
            factor = error_factor / max(reached, 1e-3)
            solves = factor * CONSTANTS.solves_per_double_step * pairs
            return factor * (process_time() - begin), round(solves)
        return error_factor * (process_time() - begin), round(error_factor * trajectory.solves)

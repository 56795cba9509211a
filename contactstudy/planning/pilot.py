"""Seconds of a contact in time or in rolling: a pilot run on coarse cells counts the steps, one solve is timed."""

import sys
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from time import process_time

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.evolution.integration.evolve import evolve
from contactstudy.evolution.rolling.steady_rolling import solve_rolling
from contactstudy.evolution.time_steps import ErrorEstimator, TimeSteps
from contactstudy.planning.cost import CONSTANTS as TIMING
from contactstudy.planning.cost import timed
from contactstudy.planning.grid_requirements import CONSTANTS as GRID
from contactstudy.planning.transient_requirements import transient_requirements
from contactstudy.progress import fraction_of_fall
from contactstudy.scene.loads.constant_load import LineLoad
from contactstudy.scene.rolling import Rolling
from contactstudy.scene.scene import Scene


@dataclass(frozen=True)
class PilotConstants:
    """Constants of a pilot run and of the seconds that follow from it.

    Attributes
    ----------
    cells
        Maximum number of cells (across, along).
    yielding_cells
        Maximum number of cells across where bodies yield, whose steps take long.
    time_limit, rolling_time_limit
        Seconds after which a pilot run ends, and one of wear in rolling or of repeated rolling, whose first
        steps say little about the others.
    least_fraction
        Least fraction of the whole that is extrapolated from.
    min_progress
        Fraction of the time below which, at the limit, a larger error is tried.
    error_step
        Factor on that error, with which steps of first order become fewer by the same factor.
    solves_per_double_step, solves_per_wear_step
        Solves of a pair of steps and the one of twice the length: of a scene with state variables, and of wear by Heun's
        method.
    outer_iterations
        Outer iterations of steady rolling expected before their changes show how many it takes.
    max_error
        Largest error of a pilot run.
    plastic_power, passes_power
        Power of the bytes of plastic operators in the ratio of seconds of a step, in time and in repeated rolling. With
        the latter, 24 cells forecast 48 and 96 within a factor of 2.5 in three scenes.
    refinement_cost
        Seconds with the finer grids on which some scenes are solved again, over those on the planned grid, in plane
        strain: 1 to 2.5 in 8 scenes that creep, wear or roll. Where the gap varies along the length, the ratio of two
        elastic solves, which do not begin with the step before, is too large by as much.
    yielding_refinement_cost
        The same of scenes that yield, which are mostly solved again on twice the cells.
    rolling_cost_along
        Factor on the seconds of rolling where the gap varies along the length: most outer iterations begin close to
        their end there, 0.3 to 0.8 in 5 scenes.
    """

    cells: tuple[int, int] = (48, 12)
    yielding_cells: int = 24
    time_limit: float = 1.0
    rolling_time_limit: float = 4.0
    least_fraction: float = 1e-6
    min_progress: float = 0.25
    error_step: float = 4.0
    solves_per_double_step: int = 3
    solves_per_wear_step: int = 6
    outer_iterations: int = 10
    max_error: float = 0.3
    plastic_power: float = 0.8
    passes_power: float = 0.5
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
        Seconds of processor time; infinite where the scene has no end, or the pilot run is refused.
    solves
        Number of solves on the planned grid.
    reason
        A sentence on both.
    """

    seconds: float
    solves: int
    reason: str


def pilot(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    error: float | None,
    steps: TimeSteps,
    *,
    refines: bool,
) -> Pilot:
    """Return the work of `scene` on `grid`, from its steps on a coarse grid.

    The number of time steps depends little on the cell size, but repeated rolling takes a step for each cell rolled.
    The seconds of a step are the pilot run's times the ratio of two elastic solves, on the planned grid and on that
    of the pilot run, or for plastic strain a power of the ratio of operator bytes.

    Parameters
    ----------
    scene
        The scene, which changes in time or rolls.
    grid, padding
        Planned cells and boundary conditions.
    error
        Relative L1 error of the pressure, of discretisation and time steps together; None takes the steps as they are.
    steps
        Instants that are recorded, and how steps are taken.
    refines
        Whether the grid is refined until its bound meets the error.
    """
    requirements = transient_requirements(scene, steps.last)
    rolls_repeatedly = scene.rolling is not None and scene.rolling.passes is not None
    plastic = requirements.plastic
    nx, ny = grid.cells
    across = CONSTANTS.cells[0] if plastic is None else CONSTANTS.yielding_cells
    # coarse cells do not hold the cohesive zone
    coarse = grid
    if scene.adhesion is None:
        coarse = Grid((min(nx, across), min(ny, CONSTANTS.cells[1])), grid.extent)
    step_error = error and (1 - GRID.cell_fraction) * error
    if steps.error is not None:
        step_error = steps.error
    try:
        modules = len(sys.modules)
        seconds, solves = seconds_and_solves(scene, coarse, padding, step_error, steps)
        # imports are not counted, but on the planned grid they cost less than a second run
        if coarse != grid and len(sys.modules) > modules:
            seconds, solves = seconds_and_solves(scene, coarse, padding, step_error, steps)
    except InvalidInput as refused:
        return Pilot(inf, 1, f"seconds: unknown, since {refused}")
    if coarse == grid:
        time_ratio = 1.0
    elif plastic is not None:
        power = CONSTANTS.passes_power if rolls_repeatedly else CONSTANTS.plastic_power
        time_ratio = (plastic.bytes(grid) / plastic.bytes(coarse)) ** power
    else:
        problem_on = partial(requirements.narrow.problem, padding=padding)
        fine, on_pilot = (timed(problem_on, cells, TIMING.tolerance)[1] for cells in (grid, coarse))
        time_ratio = (fine.setup + fine.solve) / (on_pilot.setup + on_pilot.solve)
    step_ratio = nx / coarse.cells[0] if rolls_repeatedly else 1.0
    refines = refines and not rolls_repeatedly  # passes are rolled on the planned grid alone
    refinement_factor = CONSTANTS.refinement_cost if refines and ny == 1 else 1.0
    if refines and plastic is not None:
        refinement_factor = CONSTANTS.yielding_refinement_cost
    elif scene.rolls and ny > 1:
        refinement_factor = CONSTANTS.rolling_cost_along
    total = refinement_factor * step_ratio * seconds * max(time_ratio, 1.0)
    solves = round(step_ratio * solves)
    return Pilot(
        total,
        solves,
        f"time: some {solves} solves, steps or outer iterations, by a pilot run on {coarse.cells[0]} x "
        f"{coarse.cells[1]} cells, with those that estimate an error; some {total:.2g} s.",
    )


def seconds_and_solves(
    scene: Scene, grid: Grid, padding: Padding | Paddings, error: float | None, steps: TimeSteps
) -> tuple[float, int]:
    """Return the seconds and the solves of `scene` on `grid`, extrapolated from what is done within the time limit."""
    if scene.wears_steadily:
        return _of_wear(scene, grid, padding, error, steps)
    if scene.rolling is not None and scene.rolling.passes is not None:
        return _of_passes(scene, grid, padding, scene.rolling)
    if scene.rolls:
        return _of_steady_rolling(scene, grid, padding, steps)
    return _in_time(scene, grid, padding, error, steps)


class _TimeLimitReached(Exception):
    """The pilot run has reached its time limit."""


class _Watch:
    """Progress of a pilot run: what is done and the seconds at each report. It ends the pilot at a time limit [s]."""

    def __init__(self, limit: float) -> None:
        self._begin, self._limit = process_time(), limit
        self.reports: list[tuple[float, float]] = []

    def __call__(self, done: float, whole: float) -> None:
        """Record that `done` of the `whole` is done."""
        seconds = self.seconds
        self.reports.append((done / whole if whole else 1.0, seconds))
        if seconds > self._limit:
            raise _TimeLimitReached

    @property
    def seconds(self) -> float:
        """Seconds of processor time since the pilot run began."""
        return process_time() - self._begin

    @property
    def fraction(self) -> float:
        """Fraction that is done, or the least one that is extrapolated from."""
        return max(self.reports[-1][0], CONSTANTS.least_fraction)


def _of_wear(
    scene: Scene, grid: Grid, padding: Padding | Paddings, error: float | None, steps: TimeSteps
) -> tuple[float, int]:
    """Return the seconds and the solves of a contact that wears and is steady at each instant."""
    # imported only for scenes that roll and wear
    from contactstudy.evolution.equilibrium.steady_wear import follow_wear

    watch, times = _Watch(CONSTANTS.rolling_time_limit), steps.instants_of(*scene.histories)
    try:
        worn = follow_wear(scene, grid, padding, times=times, error=error, progress=watch)
    except _TimeLimitReached:
        solves = CONSTANTS.solves_per_wear_step * len(watch.reports)
        return watch.seconds / watch.fraction, round(solves / watch.fraction)
    return watch.seconds, worn.solves


def _of_passes(
    scene: Scene, grid: Grid, padding: Padding | Paddings, rolling: Rolling
) -> tuple[float, int]:
    """Return the seconds and the steps of repeated rolling from two passes: later ones take as long as the second."""
    # imported only for scenes with such passes
    from contactstudy.evolution.rolling.repeated_rolling import roll_repeatedly

    assert rolling.passes is not None
    two = replace(scene, rolling=replace(rolling, passes=min(rolling.passes, 2)))
    watch = _Watch(CONSTANTS.rolling_time_limit)
    with suppress(_TimeLimitReached):
        roll_repeatedly(two, grid, padding, progress=lambda done, _: watch(done, 1.0))
    first = [seconds for done, seconds in watch.reports if done <= 1]
    (done, seconds), steps = watch.reports[-1], len(watch.reports)
    if done <= 1:
        return rolling.passes / done * seconds, round(rolling.passes / done * steps)
    later = (rolling.passes - 1) / (done - 1)
    return (
        first[-1] + later * (seconds - first[-1]),
        round(len(first) + later * (steps - len(first))),
    )


def _of_steady_rolling(
    scene: Scene, grid: Grid, padding: Padding | Paddings, steps: TimeSteps
) -> tuple[float, int]:
    """Return the seconds and the outer iterations of steady rolling, at all instants of a load history."""
    instants, steady = 1, scene
    if scene.takes_times:
        recorded = steps.instants_of(*scene.histories)
        instants = 1 if recorded is None else np.size(recorded)
        steady = replace(scene, load=LineLoad(scene.largest_load))
    watch, fraction = _Watch(CONSTANTS.time_limit), fraction_of_fall()

    def report(change: float, allowed: float) -> None:
        watch(max(fraction(change, allowed), 1 / CONSTANTS.outer_iterations), 1.0)

    try:
        rolling = solve_rolling(steady, grid, padding, progress=report)
        rolling.error_estimate()
    except _TimeLimitReached:
        factor = instants / watch.fraction
        return factor * watch.seconds, round(factor * len(watch.reports))
    return instants * watch.seconds, instants * rolling.lagged.outer_iterations


def _in_time(
    scene: Scene, grid: Grid, padding: Padding | Paddings, error: float | None, steps: TimeSteps
) -> tuple[float, int]:
    """Return the seconds and the solves of a scene with state variables, at the smallest error that is practical."""
    times = steps.instants_of(*scene.histories)
    doubles = steps.error_estimator is ErrorEstimator.STEP_DOUBLING
    allowed = min(error, CONSTANTS.max_error) if error and doubles else None
    while True:
        watch = _Watch(CONSTANTS.time_limit)
        error_factor = allowed / error if allowed and error else 1.0
        try:
            trajectory = evolve(
                scene,
                grid,
                padding,
                times=times,
                error=allowed,
                error_estimator=steps.error_estimator,
                scheme=steps.scheme,
                progress=watch,
            )
        except _TimeLimitReached:
            is_far = watch.fraction < CONSTANTS.min_progress
            if allowed and is_far and allowed < CONSTANTS.max_error:
                allowed = min(CONSTANTS.error_step * allowed, CONSTANTS.max_error)
                continue
            factor = error_factor / watch.fraction
            each = CONSTANTS.solves_per_double_step if doubles else 1
            return factor * watch.seconds, round(factor * each * len(watch.reports))
        return error_factor * watch.seconds, round(error_factor * trajectory.solves)

"""Follow a scene through time: its state variables, its steps, and the method."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import inf, pi
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import Precision
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.elasticity.coefficients import BoussinesqCoefficients
from contactstudy.elasticity.viscoelastic import Creep
from contactstudy.evolution.integration.checkpoint import Checkpoint
from contactstudy.evolution.integration.dry_steps import DrySteps, Errors
from contactstudy.evolution.integration.time_stepper import Instant, TimeStepper
from contactstudy.evolution.march import Control, March, all_recorded, schedule
from contactstudy.evolution.states.fretting_state import FrettingState
from contactstudy.evolution.states.state_variables import (
    CreepState,
    StateVariable,
    WearState,
    least_eigenvalue,
    solved_or_unloaded,
)
from contactstudy.evolution.time_steps import ErrorEstimator, Scheme
from contactstudy.evolution.trajectory import Frame, Trajectory
from contactstudy.problem.problem import Problem
from contactstudy.scene.friction.fretting import Fretting
from contactstudy.scene.friction.friction_law import has_proportional_compliances
from contactstudy.scene.loads.load_history import ChangingLoad, LoadHistory
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.shapes_source import summed_gap
from contactstudy.scene.solids.bodies import creeps, instantaneous, response, yields
from contactstudy.scene.solids.viscoelastic import creeping, relaxed
from contactstudy.solvers.solution import Status
from contactstudy.solvers.solve import SolveOptions

if TYPE_CHECKING:  # imported only for scenes with a body that yields
    from contactstudy.evolution.states.plastic import PlasticState

# In the first march, a pair of steps may add this fraction of the allowed error to the difference of two integrations.
INITIAL_TOLERANCE_FRACTION = 0.5
# Duration of the first pair of steps over that of all: if it is too long, it is rejected.
INITIAL_STEP = 1e-2
# The least ratio of the error to the solver's tolerance, so that the solver's error does not count.
MIN_ERROR_OVER_TOLERANCE = 100
# Files of a checkpoint: a recorded frame by its index, and the march to go on from.
FRAME_FILE, STATE_FILE = "frame_{:05d}.npz", "state.npz"
# What a checkpoint holds of a march beside its instants, outcomes and control.
SAVED = "number", "length", "work", "total"
# Steps in a period of a load that repeats, at least.
PER_PERIOD = 4


def _plastic_state(scene: Scene, problem: Problem, options: SolveOptions) -> "PlasticState | None":
    """Return the plastic strain of bodies that yield, from the elastic `problem` under the largest load, or None.

    Raises
    ------
    InvalidInput
        For a padding on which plastic strain has no operator.
    """
    if not any(map(yields, scene.solids)):
        return None
    from contactstudy.evolution.states.plastic import PlasticState, YieldingBody, check_paddings

    check_paddings(problem)
    elastic = solved_or_unloaded(options, problem)
    return PlasticState(YieldingBody.in_scene(scene), elastic, Precision(options.precision))


def evolve(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    times: ArrayLike | None = None,
    error: float | None = None,
    error_estimator: ErrorEstimator = "step_doubling",
    scheme: Scheme = "implicit",
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    folder: str | PathLike[str] | None = None,
    progress: Callable[[float, float], None] | None = None,
) -> Trajectory:
    """Follow `scene` through time, from the start of its load.

    The time-discretisation error follows from the difference of two integrations, one with steps twice as long. Of a
    method of order p the difference is ``2^p - 1`` times the error of the shorter steps, which are recorded: an upper
    estimate for order 2, the error itself for order 1. It is multiplied by 1.5 where bodies yield (first order), else
    by 2.41 where contacts wear or fret (order 1/2 at the onset of wear), or creep is over within a step; after such a
    step it falls no faster than creep in the longest retardation time. It is relative to the pressure at the same
    instant; where bodies yield, to the pressure under the largest load, as is the error of the contact on its grid, and
    a load jump is applied in increments. In fretting it is the larger one of the pressure and of the tangential
    traction.

    Parameters
    ----------
    scene
        The scene. A :class:`~contactstudy.LineLoad` is applied suddenly at 0 s, or at the first of `times` if that is
        earlier.
    grid, padding
        Cells and boundary conditions, as for :func:`~contactstudy.solve`.
    times
        Recorded instants [s], which do not decrease. Steps end there, and wherever the load or its rate jumps; where
        bodies yield or fret, also where it turns. Of two steps that differ much in length each is halved. A time
        given twice is recorded before and after a jump of the load. None records every pair of steps; without a state
        variable, the start, the end and the instants at which the load turns or jumps.
    error
        Allowed relative L1 time-discretisation error, for which steps are chosen. None steps from one of `times`
        to the next, at most a quarter of the load's period at a time.
    error_estimator
        How the time-discretisation error is estimated.
    scheme
        How sliding wear is stepped.
    options
        How each contact is solved.
    folder
        Folder for frames and states. An integration that was stopped continues from there.
    progress
        Called with the time since the start and that of the whole [s].

    Returns
    -------
    Trajectory
        The recorded frames, with their estimated errors.

    Raises
    ------
    InvalidInput
        If times decrease, the error is too close to the solver's tolerance, or the folder is of another integration.
    """
    load = _load(scene, times)
    end = schedule(load, times)[-1].time
    if error is not None and error < MIN_ERROR_OVER_TOLERANCE * options.tolerance:
        raise InvalidInput(
            f"solve.error or TimeSteps.error leaves {error!r} to the steps in time: give at least "
            f"{MIN_ERROR_OVER_TOLERANCE} times the tolerance of the contacts, or a smaller tolerance."
        )
    stepper = _time_stepper(scene, grid, padding, load, end - load.start, scheme, options)
    keeps_states = bool(stepper.all_state_variables)
    turns = stepper.depends_on_path or (times is None and not keeps_states)
    breakpoints = schedule(
        load,
        times,
        kinks=load.turning_points(end) if turns else (),
        history=scene.friction.history if isinstance(scene.friction, Fretting) else None,
        # steps of whole periods would meet the load at the same place of each, and not see that it changes
        longest=getattr(load, "period", inf) / PER_PERIOD if keeps_states else inf,
    )
    control = None
    if keeps_states and error is not None:
        limit, first = INITIAL_TOLERANCE_FRACTION * error, INITIAL_STEP * (end - load.start)
        control = Control(limit, DrySteps.order, first, allowed=error)
    if times is None and not keeps_states:
        breakpoints = all_recorded(breakpoints)
    steps = DrySteps(stepper, error_estimator if keeps_states else "none")
    recorded: Any = "pairs" if keeps_states and times is None else "points"
    start = stepper.start(breakpoints[0].time)
    march = March(steps, start, breakpoints, control, recorded, progress)
    if folder is None:
        frames = _frames(march, steps, None)
    else:
        checkpoint = Checkpoint(Path(folder))
        instants = None if times is None else tuple(np.asarray(times, float).ravel().tolist())
        request = scene, grid, padding, instants, error, error_estimator, scheme, options
        with checkpoint.open(request):
            frames = _frames(march, steps, checkpoint)
    return Trajectory(
        stepper.problem,
        tuple(frames),
        march.total["rejected"],
        march.total["restarts"],
        PosedScene(scene, grid, padding),
        stepper.coupled,
    )


@dataclass(frozen=True)
class _Saved:
    """A march where it can go on: short and doubled instants, the values by name, and the number of its frames."""

    fine: Instant
    coarse: Instant | None
    march: Mapping[str, Any]
    control: Control | None
    statuses: tuple[Status, ...]
    errors: Errors
    frames: int


def _frames(march: March[Instant], steps: DrySteps, checkpoint: Checkpoint | None) -> list[Frame]:
    """Return what a march records as frames; with a checkpoint, it goes on from there and is kept there."""
    frames = [] if checkpoint is None else _restored(march, steps, checkpoint)
    for records in march.run():
        if records is None:
            frames = []
            continue
        for record in records:
            frame = steps.frame(record, has_failed=march.fine.change == inf)
            if checkpoint is not None:
                checkpoint.write(FRAME_FILE.format(len(frames)), frame)
            frames.append(frame)
        if checkpoint is not None and march.can_go_on:
            fine, coarse = (
                instant and replace(instant, kept=(), replaced=()) for instant in (march.fine, march.coarse)
            )
            assert fine is not None
            saved = _Saved(
                fine,
                coarse,
                {name: getattr(march, name) for name in SAVED},
                march.control,
                tuple(march.statuses),
                steps.errors,
                len(frames),
            )
            checkpoint.write(STATE_FILE, saved)
    return frames


def _restored(march: March[Instant], steps: DrySteps, checkpoint: Checkpoint) -> list[Frame]:
    """Set a march to where it was saved, if it was, and return the frames until there."""
    if not (checkpoint.folder / STATE_FILE).exists():
        return []
    saved = checkpoint.read(STATE_FILE, _Saved)
    march.fine, march.coarse, march.control = saved.fine, saved.coarse, saved.control
    march.statuses, steps.errors = list(saved.statuses), saved.errors
    for name, value in saved.march.items():
        setattr(march, name, Counter(value) if isinstance(value, dict) else value)
    frames = (checkpoint.read(FRAME_FILE.format(n), Frame) for n in range(saved.frames))
    return [replace(frame, problem=steps.stepper.problem) for frame in frames]


def _time_stepper(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    load: ChangingLoad,
    duration: float,
    scheme: Scheme,
    options: SolveOptions,
) -> TimeStepper:
    """Return the steps of `scene`, from the elastic contact under the largest load, applied suddenly.

    The `duration` [s] is that of all steps.
    """
    solids = instantaneous(scene.solids)
    frets = isinstance(scene.friction, Fretting)
    friction = None if frets else scene.friction
    elastic = replace(scene.under(load.largest), solids=solids, wear=None, friction=friction)
    adhesive_solver = None
    if scene.adhesion is not None and any(map(creeps, scene.solids)):
        heights, softest = summed_gap(scene.shapes, grid), relaxed(scene.solids, duration)
        adhesive_solver = scene.adhesion.solver_on(elastic, heights, grid, softest)
    problem = elastic.problem(grid, padding, adhesive_solver)
    datum = elastic.datum(grid)
    variables: list[StateVariable] = [
        CreepState(body.creep.scaled(1 / pi), BoussinesqCoefficients(datum)) for body in creeping(scene.solids)
    ]
    if scene.wear is not None and scene.wear.rate_per_pressure > 0:
        variables.append(WearState(scene.wear.rate_per_pressure, scene.wear.body))
    if frets:
        variables.append(_fretting_state(scene, problem, options))
    return TimeStepper(
        problem=problem,
        load=load,
        loaded_length=scene.loaded_length(grid, padding),
        weights=dict(response(solids, datum)),
        state_variables=tuple(variables),
        coupled=_plastic_state(scene, problem, options),
        scheme=scheme,
        options=options,
    )


def _fretting_state(scene: Scene, problem: Problem, options: SolveOptions) -> StateVariable:
    """Return the tangential traction of a scene that frets, as a state variable."""
    fretting, paddings = scene.friction, problem.paddings
    assert isinstance(fretting, Fretting)
    assert fretting.history is not None
    assert paddings is not None
    gap = problem.undeformed_gap
    return FrettingState(
        coefficient=fretting.coefficient,
        wear=0.0 if scene.wear is None else scene.wear.coefficient,
        response=fretting.response(scene, problem.grid, paddings, scene.datum(problem.grid)),
        history=fretting.history,
        by_force=fretting.forces is not None,
        period=inf if fretting.period is None else fretting.period,
        least_eigenvalue=least_eigenvalue(scene.contact_modulus, min(problem.grid.cell_size)),
        gap_scale=problem.scales.gap,
        compliances_proportional=has_proportional_compliances(scene.solids, gap, paddings),
        creep=_relative_creep(scene, scene.datum(problem.grid)),
        grid=problem.grid,
        loaded_length=scene.loaded_length(problem.grid, paddings),
        tolerance=options.tolerance,
        max_applications=options.max_iterations,
    )


def _relative_creep(scene: Scene, datum: float) -> CreepState | None:
    """Return the creep of both bodies, which are elastically similar, over their instantaneous compliance.

    None if neither creeps.
    """
    total = sum(body.compliance for body in scene.solids)
    creeps = [body.creep.scaled(1 / total) for body in creeping(scene.solids)]
    if not creeps:
        return None
    terms = tuple(term for creep in creeps for term in creep.terms)
    fluidity = sum(creep.fluidity for creep in creeps)
    return CreepState(Creep(1.0, terms, fluidity), BoussinesqCoefficients(datum))


def _load(scene: Scene, times: ArrayLike | None) -> ChangingLoad:
    """Return the load of `scene` over time; a constant one is applied at 0 s, or at the first of `times` [s] before."""
    if isinstance(scene.load, ChangingLoad):
        return scene.load
    start = 0.0 if times is None else min(0.0, float(np.min(times)))
    return LoadHistory((start,), (scene.largest_load,))

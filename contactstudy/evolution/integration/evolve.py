"""Follow a scene through time: its state variables, its steps, and the method."""

from collections.abc import Callable
from dataclasses import replace
from math import inf, pi
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.device import Precision
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.elasticity.coefficients import BoussinesqCoefficients
from contactstudy.elasticity.viscoelastic import Creep
from contactstudy.evolution.integration.adaptive_integrator import AdaptiveIntegrator, StepControl
from contactstudy.evolution.integration.checkpoint import Checkpoint
from contactstudy.evolution.integration.time_stepper import TimeStepper
from contactstudy.evolution.states.state_variables import (
    CoupledStateVariable,
    CreepState,
    StateVariable,
    WearState,
    least_eigenvalue,
)
from contactstudy.evolution.time_steps import ErrorEstimator, Scheme, all_recorded, schedule
from contactstudy.evolution.trajectory import Trajectory
from contactstudy.evolution.warm_started import solved_or_unloaded
from contactstudy.problem.problem import Problem
from contactstudy.scene.friction.fretting import Fretting
from contactstudy.scene.friction.friction_law import has_proportional_compliances
from contactstudy.scene.loads.load_history import ChangingLoad, LoadHistory
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.shapes_source import summed_gap
from contactstudy.scene.solids.bodies import creeps, instantaneous, response, yields
from contactstudy.scene.solids.viscoelastic import creeping, relaxed
from contactstudy.solvers.solve import SolveOptions

# Steps in a period of a load that repeats, at least.
PER_PERIOD = 4


def state_variables(scene: Scene, datum: float) -> tuple[StateVariable, ...]:
    """Return a creep state for each viscoelastic body of `scene`, then the state of wear, if any.

    Parameters
    ----------
    scene
        The scene.
    datum
        Distance [m] at which the displacement of a body is zero, as in its ``response``.
    """
    scene_variables: list[StateVariable] = [
        CreepState(body.creep.scaled(1 / pi), BoussinesqCoefficients(datum))
        for body in creeping(scene.solids)
    ]
    if scene.wear is not None and scene.wear.rate_per_pressure > 0:
        scene_variables.append(WearState(scene.wear.rate_per_pressure, scene.wear.body))
    return tuple(scene_variables)


def coupled_state_variable(
    scene: Scene, problem: Problem, options: SolveOptions
) -> CoupledStateVariable | None:
    """Return the state variable of plastic strain of the bodies that yield; None if none yields.

    Parameters
    ----------
    scene
        The scene.
    problem
        The elastic contact under the largest load.
    options
        How it is solved.

    Raises
    ------
    InvalidInput
        For a padding on which plastic strain has no operator.
    """
    if not any(map(yields, scene.solids)):
        return None

    # imported only for scenes with such a body
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
        If times decrease, the error is out of reach, or the folder belongs to another integration.
    """
    control = None if error is None else StepControl.for_error(error, options.tolerance)
    load = _load(scene, times)
    end = schedule(load, times)[-1].time
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
    if times is None and not keeps_states:
        breakpoints = all_recorded(breakpoints)
    checkpoint = None if folder is None else Checkpoint(Path(folder))
    doubles = error_estimator == "step_doubling"
    integrator = AdaptiveIntegrator(
        stepper=stepper,
        breakpoints=breakpoints,
        control=control,
        step_doubling=doubles and keeps_states,
        records_all=times is None,
        checkpoint=checkpoint,
        progress=progress,
    )
    if checkpoint is None:
        integrator.integrate()
    else:
        instants = None if times is None else tuple(np.asarray(times, float).ravel().tolist())
        request = scene, grid, padding, instants, error, error_estimator, scheme, options
        with checkpoint.open(request):
            integrator.restore()
            integrator.integrate()
    return Trajectory(
        stepper.problem,
        tuple(integrator.frames),
        integrator.rejected,
        integrator.restarts,
        PosedScene(scene, grid, padding),
        stepper.coupled,
    )


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
    problem = elastic.problem_with(grid, padding, adhesive_solver)
    datum = elastic.datum(grid)
    variables = state_variables(scene, datum)
    if frets:
        variables = (*variables, _fretting_state(scene, problem, options))
    return TimeStepper(
        problem=problem,
        load=load,
        loaded_length=scene.loaded_length(grid, padding),
        weights=dict(response(solids, datum)),
        state_variables=variables,
        coupled=coupled_state_variable(scene, problem, options),
        scheme=scheme,
        options=options,
    )


def _fretting_state(scene: Scene, problem: Problem, options: SolveOptions) -> StateVariable:
    """Return the tangential traction of a scene that frets, as a state variable."""
    from contactstudy.evolution.states.fretting_state import (
        FrettingState,
    )  # only where something frets

    fretting, paddings = scene.friction, problem.paddings
    assert isinstance(fretting, Fretting)
    assert paddings is not None
    gap = problem.undeformed_gap
    return FrettingState(
        coefficient=fretting.coefficient,
        wear=0.0 if scene.wear is None else scene.wear.coefficient,
        response=fretting.response(scene, problem.grid, paddings, scene.datum(problem.grid)),
        forces=None if fretting.forces is None else fretting.history,
        displacements=None if fretting.displacements is None else fretting.history,
        period=inf if fretting.period is None else fretting.period,
        least_eigenvalue=least_eigenvalue(scene.contact_modulus, min(problem.grid.cell_size)),
        gap_scale=problem.scales.gap,
        compliances_proportional=has_proportional_compliances(
            scene.solids, varies=bool((gap != gap[:, :1]).any()), paddings=paddings
        ),
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

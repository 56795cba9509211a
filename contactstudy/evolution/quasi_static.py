"""Contacts in equilibrium under a load that changes: adhesive bodies, and steady rolling.

An adhesive contact begins with the state before it. Between two turning points of the load the state does not depend on
the number of instants, because the fixed-point map is monotone: a larger initial attraction gives a larger final one. It
is therefore solved at all turning points, recorded or not. Rolling is steady at each instant and depends on its load
alone. So there is no time-discretisation error.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.evolution.march import schedule
from contactstudy.evolution.rolling.steady_rolling import SteadyRolling, solve_rolling
from contactstudy.evolution.trajectory import Frame, Trajectory, frame_of
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.problem.problem import Problem
from contactstudy.scene.loads.constant_load import LineLoad
from contactstudy.scene.loads.load_history import ChangingLoad, loads_between
from contactstudy.scene.rolling import check_slow
from contactstudy.scene.scene import AnyLoad, PosedScene, Scene
from contactstudy.scene.solids.bodies import creeps, instantaneous
from contactstudy.solvers.adhesion import AdhesiveSolver
from contactstudy.solvers.fixed_point import LaggedSolution
from contactstudy.solvers.solution import Solution, Status, unloaded, worst_until
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Turns of the load below this fraction of the largest one are rounding.
ROUNDING = 1e-9


def follow_load(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    times: ArrayLike,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    progress: Callable[[float, float], None] | None = None,
) -> Trajectory:
    """Follow `scene`, whose load changes in time, through contacts in equilibrium from its first load on.

    Parameters
    ----------
    scene
        The scene, with a load that changes and adhesion or steady rolling.
    grid, padding
        Cells and boundary conditions.
    times
        Recorded instants [s], which do not decrease.
    options
        How each contact is solved.
    progress
        Called with the time since the start and that of the whole [s].

    Returns
    -------
    Trajectory
        The recorded frames, each with its solution.

    Raises
    ------
    InvalidInput
        If the load changes too fast for a body that creeps to roll steadily, or times decrease or begin before the load.
    """
    load = scene.load
    assert isinstance(load, ChangingLoad)
    turns = load.turning_points(schedule(load, times)[-1].time)
    breakpoints = schedule(load, times, kinks=turns)
    first = load.at(breakpoints[0].time)
    elastic = scene
    if (speed := scene.rolling_speed) is not None:
        if any(map(creeps, scene.solids)):
            check_slow("Scene.rolling", speed, load, scene.hertz)
        elastic = replace(scene, rolling=None, solids=instantaneous(scene.solids))
    adhesive_solver = None if scene.adhesion is None else _under(elastic, first).problem(grid, padding).adhesion
    assert adhesive_solver is None or isinstance(adhesive_solver, AdhesiveSolver)
    largest = replace(elastic, load=LineLoad(load.largest)).problem(grid, padding)
    frames: list[Frame] = []
    since_recorded: list[Frame] = []
    last: Solution | None = None
    for point in breakpoints:
        jumps = point.jumps and point is not breakpoints[0]
        loads = (point.before, point.after) if jumps else (point.after,) * max(1, point.times_recorded)
        for number, value in enumerate(loads):
            # a jump that is recorded once is recorded after it
            is_recorded = number >= len(loads) - point.times_recorded
            if adhesive_solver is None and not is_recorded:
                continue  # without adhesion the contact does not depend on those before
            rolling = None
            if value == 0 and adhesive_solver is None:
                posed = PosedScene(scene, grid, padding)
                last = unloaded(replace(largest, control=PrescribedLoad(0.0), description=posed))
            elif speed is not None and adhesive_solver is None:
                rolling = solve_rolling(_under(scene, value), grid, padding, options=options)
                last = rolling.solution
            else:
                last = _next_solution(_problem_under(largest, elastic, value, adhesive_solver), last, options)
                if speed is not None:  # elastic bodies, which roll without resistance
                    lagged = LaggedSolution(last, 0.0, 1)
                    rolling = SteadyRolling(lagged, {}, partial(solve_rolling, scene, padding=padding))
            solves = 1 if rolling is None else rolling.lagged.outer_iterations
            if last.adhesion is not None:
                solves = last.adhesion.outer_iterations
            since_recorded.append(frame_of(last, time=point.time, load=value, solves=solves, rolling=rolling))
            if is_recorded:
                frames.append(_with_work_of(since_recorded))
                since_recorded = []
        if progress is not None:
            start = breakpoints[0].time
            progress(point.time - start, breakpoints[-1].time - start)
    return Trajectory(largest, tuple(frames), 0, 0, PosedScene(scene, grid, padding))


def _under(scene: Scene, load: float) -> Scene:
    """Return `scene` under a constant `load` [N/m]; under a tensile load it is that of bodies which were in contact."""
    adhesion = scene.adhesion
    if adhesion is not None and load <= 0:
        adhesion = replace(adhesion, branch="from full contact")
    return replace(scene, load=LineLoad(load), adhesion=adhesion)


def _problem_under(problem: Problem, scene: Scene, load: float, solver: AdhesiveSolver | None) -> Problem:
    """Return `problem` under a `load` [N/m], with the operator and the adhesive `solver` of all instants."""
    posed = problem.description
    assert isinstance(posed, PosedScene)
    grid, instant = posed.grid, _under(scene, load)
    return replace(
        problem,
        control=PrescribedLoad(load * scene.loaded_length(grid, posed.padding) / grid.cell_area),
        adhesion=solver,
        source=instant.source_with(grid, posed.padding, solver),
        description=PosedScene(instant, grid, posed.padding),
    )


def _next_solution(problem: Problem, last: Solution | None, options: SolveOptions) -> Solution:
    """Return the solution that continues from the `last` one, or the first solution."""
    start = last.pressure if last is not None and last.pressure.any() else None
    if isinstance(problem.adhesion, AdhesiveSolver) and last is not None:
        problem = replace(problem, adhesion=problem.adhesion.after(last))
    return solve_contact(problem, options, start)


def _with_work_of(contacts: Sequence[Frame]) -> Frame:
    """Return the last of successive contacts with the work of all, and the status of the last after the others."""
    last = contacts[-1]
    return replace(
        last,
        status=worst_until(last.status, [frame.status for frame in contacts]),
        solves=sum(frame.solves for frame in contacts),
        iterations=sum(frame.iterations for frame in contacts),
        convolutions=sum(frame.convolutions for frame in contacts),
    )


def net_work(frames: Sequence[Frame], approach_errors: Sequence[float], load: AnyLoad) -> tuple[float, float, str]:
    """Return the net work of the load in a history [J/m], the bound of its error, and why that is infinite where it is.

    It is the integral of the load over the approach: the hysteresis loss where the history ends at the load and on the
    branch of its beginning, else with the elastic energy stored meanwhile. Where the load does not turn between two
    instants, load and approach go one way, also where contact jumps in, so that the trapezoid is wrong by half the
    product of their changes at most. Errors of the approaches [m] count with the changes of the load around them.

    Parameters
    ----------
    frames
        Recorded instants of a contact with adhesion.
    approach_errors
        Bound of the approach [m] of each of them.
    load
        Load of the scene.
    """
    work = error = 0.0
    largest = max(abs(frame.load) for frame in frames)
    reason = "" if np.isfinite(approach_errors).all() else "No bound: the approach has none."
    for number, (a, b) in enumerate(pairwise(frames)):
        if Status.DETACHED in (a.status, b.status):
            reason = "No bound: contact is made or lost between two instants."
            continue
        loads = _loads_between(a, b, load)
        variation, change = sum(abs(y - x) for x, y in pairwise(loads)), abs(b.load - a.load)
        if variation - change > ROUNDING * largest:
            reason = reason or "No bound: the load turns between two instants: record where it turns."
        work += (a.load + b.load) / 2 * (b.approach - a.approach)
        error += abs(change * (b.approach - a.approach)) / 2
        error += change / 2 * (approach_errors[number] + approach_errors[number + 1])
    if reason:
        return work, inf, reason
    ends = [abs(frames[n].load) * approach_errors[n] for n in (0, -1)]
    return work, error + sum(ends), ""


def _loads_between(a: Frame, b: Frame, load: AnyLoad) -> list[float]:
    """Return the loads [N/m] from one frame to the next, with those between which the load only rises or falls."""
    if not isinstance(load, ChangingLoad):
        return [a.load, b.load]
    return [a.load, *loads_between(load, a.time, b.time), b.load]


def changes_of_contact(frames: Sequence[Frame], load: AnyLoad) -> dict[str, tuple[float, float]]:
    """Return the loads between which contact is first lost ("pull_off") and made ("jump_in"), as far as it is.

    The first of each two is a recorded load [N/m] in contact. The other is a recorded one without contact, or one beyond
    where the `load` turns between the two instants.
    """
    changes: dict[str, tuple[float, float]] = {}
    for before, after in pairwise(frames):
        touched, touches = (frame.status is not Status.DETACHED for frame in (before, after))
        if touched != touches:
            loads = _loads_between(before, after, load)
            touching, *others = loads if touched else reversed(loads)
            farthest = max(others, key=lambda other: abs(other - touching))
            changes.setdefault("pull_off" if touched else "jump_in", (touching, farthest))
    return changes

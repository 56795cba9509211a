"""Contacts without inertia of state: in equilibrium under a load that changes, and wear of contacts that are steady.

An adhesive contact begins with the state before it. Between two turning points of the load the state does not depend on
the number of instants, because the fixed-point map is monotone: a larger initial attraction gives a larger final one. It
is therefore solved at all turning points, recorded or not. Rolling is steady at each instant and depends on its load
alone. So there is no time-discretisation error.

The wear depth w adds to the gap, and its rate follows from the contact on that gap: ``dw/dt = f(w)``. Heun's method
takes a step by the rates at its start and at the end of Euler's step; the change of the pressure from one to the other
controls its length. A body that turns wears alike all round, by the mean of Archard's law over its circumference.

Source of the wear law: Archard (1953).
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from math import inf
from typing import Any, Generic, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from contactstudy.domain.grid import Array, Grid, Padding, Paddings, on_cells
from contactstudy.evolution.evolve_lubricated import FilmTrajectory, film_trajectory
from contactstudy.evolution.march import Breakpoint, Control, March, Method, Record, ascending, schedule
from contactstudy.evolution.steady_rolling import SteadyRolling, solve_rolling
from contactstudy.evolution.trajectory import Frame, Trajectory, error_of_peak, frame_of
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.pseudo_time import FilmControls
from contactstudy.lubrication.steady_film import solve_lubricated
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.problem.problem import Field, Problem
from contactstudy.scene.friction import Wear
from contactstudy.scene.loads import ChangingLoad, LineLoad, loads_between
from contactstudy.scene.rolling import check_slow
from contactstudy.scene.scene import AnyLoad, PosedScene, Scene
from contactstudy.scene.shapes.shape import LengthScales
from contactstudy.scene.solids.bodies import creeps, instantaneous
from contactstudy.solvers.adhesion import AdhesiveSolver
from contactstudy.solvers.solution import RollingTraction, Solution, Status, unloaded, worst, worst_until
from contactstudy.solvers.solve import LaggedSolution, SolveOptions, solve_contact

# Work of the contacts that lead to a frame.
WORK = "solves", "iterations", "convolutions"
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
                    lagged = LaggedSolution(last)
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


# Largest depth that the first step wears, over the scale of the gap or the boundary film. If the step is too long for
# the error, it is rejected.
FIRST_DEPTH = 0.01
# Largest change of the pressure by the correction of a step, relative in L1, where none is asked for.
STEP_ERROR = 1e-3
# Cells around a grid by which splines continue beyond it.
PADDED = 4


@dataclass(frozen=True, eq=False)
class SurfaceDepth:
    """Shape of a surface that lies `depth` (x, y) [m] deeper in the cells of a grid, as it is worn."""

    depth: Array
    grid: Grid
    curvature: float = 0.0
    length_scales: LengthScales = LengthScales()  # noqa: RUF009 (a frozen value)

    def gap(self, grid: Grid) -> Array:
        """Return the depth on another grid: means over larger cells; on smaller ones, a cubic spline."""
        if all(n <= m for n, m in zip(grid.cells, self.grid.cells, strict=True)):
            return on_cells(self.depth, grid.cells)
        around = np.pad(np.pad(self.depth, ((PADDED, PADDED), (0, 0)), "edge"), ((0, 0), (PADDED, PADDED)), "wrap")
        dx, dy = self.grid.cell_size
        rows, columns = (grid.x - self.grid.x[0]) / dx, (grid.y - self.grid.y[0]) / dy
        places = np.meshgrid(PADDED + rows, PADDED + columns, indexing="ij")
        return np.asarray(ndimage.map_coordinates(around, places, order=3, mode="nearest"))


def _differences(fine: Frame, coarse: Frame | None) -> dict[str, float]:
    """Return relative differences of a worn contact to that after longer steps, by quantity; infinite without either.

    That of the area counts cells in contact in one of both alone, and is at least that in L1, since a small change may
    move no edge to another cell.
    """
    if coarse is None or not fine.pressure.any():
        return dict.fromkeys(("l1", "peak_pressure", "contact_area"), inf)
    touching, change = fine.pressure > 0, np.abs(fine.pressure - coarse.pressure)
    moved = np.count_nonzero(touching ^ (coarse.pressure > 0)) / np.count_nonzero(touching)
    l1, peak = float(change.sum() / fine.pressure.sum()), float(fine.pressure.max())
    of_peak = float(error_of_peak(fine.pressure, change) / peak)
    return {"l1": l1, "peak_pressure": of_peak, "contact_area": float(max(l1, moved))}


Contact = TypeVar("Contact", Frame, FilmSolution)


@dataclass(frozen=True, eq=False)
class _Worn(Generic[Contact]):
    """A contact at a time [s], on the gap that is worn by a `depth` (x, y) [m].

    The `statuses` are those of the solves in the last step, and `work` counts them. The `change` is that of the
    pressure by the correction of this step, relative in L1; infinite where a solve failed.
    """

    time: float
    contact: Contact
    depth: Array
    statuses: tuple[Status, ...]
    work: Counter[str]
    change: float = 0.0


@dataclass(frozen=True, eq=False)
class _Wearing(Method[_Worn[Contact]]):
    """Heun's method for a contact that wears.

    Attributes
    ----------
    solved
        Solves the contact with a wear depth (x, y) [m], from the one before if there is one.
    rate
        Wear rate (x, y) [m/s] of a contact.
    counted
        Number of solves of a contact, of their iterations, and of their FFT convolutions (dry) or linear iterations
        (film).
    first_depth
        Largest depth [m] of the first step.
    """

    solved: Callable[[Array, Contact | None], Contact]
    rate: Callable[[Contact], Array]
    counted: Callable[[Contact], Counter[str]]
    first_depth: float

    def step(self, state: _Worn[Contact], end: float) -> _Worn[Contact]:
        """Return the contact after a step to `end` [s], with the change from Euler's predictor to it."""
        rate, duration = self.rate(state.contact), end - state.time
        predicted = self.solved(state.depth + duration * rate, state.contact)
        depth = state.depth + duration / 2 * (rate + self.rate(predicted))
        after = self.solved(depth, predicted)
        change = np.abs(after.pressure - predicted.pressure).sum() / state.contact.pressure.sum()
        failed = after.status.is_failure or predicted.status.is_failure
        return _Worn(
            end,
            after,
            depth,
            (predicted.status, after.status),
            self.counted(predicted) + self.counted(after),
            inf if failed else float(change),
        )

    def records(
        self,
        cells: tuple[int, int],
        times: ArrayLike,
        error: float | None,
        progress: Callable[[float, float], None] | None,
    ) -> tuple[Record[_Worn[Contact]], ...]:
        """Return the contact of so many `cells` (x, y) at each of `times` [s], or up to one without a solution."""
        instants = ascending(times)
        unworn = np.zeros(cells)
        contact = self.solved(unworn, None)
        rate, change = float(self.rate(contact).max()), inf if contact.status.is_failure else 0.0
        start = _Worn(min(0.0, instants[0]), contact, unworn, (contact.status,), self.counted(contact), change)
        first = 2 * self.first_depth / rate if rate else inf
        control = Control(STEP_ERROR if error is None else error, self.order, first)
        points = [Breakpoint(time, times_recorded=1) for time in instants]
        return March(self, start, points, control, progress=progress).records()


def follow_wear(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    times: ArrayLike,
    error: float | None = None,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    progress: Callable[[float, float], None] | None = None,
) -> Trajectory:
    """Follow the wear of a contact in steady or tractive rolling.

    Parameters
    ----------
    scene
        A scene with wear, and with steady or tractive rolling.
    grid, padding
        Cells and boundary conditions, as for :func:`~contactstudy.solve`.
    times
        Recorded instants [s], ascending. Wear begins at 0 s, or at the first of them if that is earlier.
    error
        Largest relative L1 change of the pressure from Euler's step to that of Heun's method; 1e-3 if None.
    options
        How each contact is solved.
    progress
        Called with the time since the start and that of the whole [s], after each pair of steps.

    Returns
    -------
    Trajectory
        The recorded frames. Their time-discretisation error is the change from an evolution with steps twice as long.

    Raises
    ------
    InvalidInput
        If the times do not ascend.
    """
    wear, unworn = scene.wear, replace(scene, wear=None)
    assert wear is not None
    # unworn bodies at rest tell the scale of the gap
    elastic = replace(unworn, rolling=None, solids=instantaneous(scene.solids))
    problem, posed = elastic.problem(grid, padding), PosedScene(scene, grid, padding)

    def solved(depth: Array, before: Frame | None) -> Frame:
        worn, rolling = replace(unworn, shapes=(*unworn.shapes, SurfaceDepth(depth, grid))), None
        if worn.rolls:
            rolling = solve_rolling(worn, grid, padding, options=options)
            solution = rolling.solution
        else:
            start = None if before is None else before.pressure
            solution = solve_contact(worn.problem(grid, padding), options, start)
        # the scene that the user gave, without the surface that is worn by now; the time is that of its step
        return frame_of(
            replace(solution, problem=replace(solution.problem, description=posed)),
            time=0.0,
            load=scene.largest_load,
            solves=1 if rolling is None else rolling.lagged.outer_iterations,
            fields={"wear_depth": Field(("x", "y"), depth, "m", "wear depth")},
            rolling=rolling,
        )

    def rate(contact: Frame) -> Array:
        traction = contact.traction
        if isinstance(traction, RollingTraction):
            # where it slips, friction times slip is the coefficient of friction times pressure times slip
            pv = traction.power / getattr(scene.friction, "coefficient", 1.0)
            return _wear_rate(wear, pv, grid)
        return _wear_rate(wear, wear.speed * contact.pressure, grid)

    def counted(contact: Frame) -> Counter[str]:
        return Counter({name: getattr(contact, name) for name in WORK})

    wearing = _Wearing(solved, rate, counted, FIRST_DEPTH * problem.scales.gap)
    records = wearing.records(grid.cells, times, error, progress)
    frames = []
    for record in records:
        state, work = record.state, cast(dict[str, Any], {name: record.work[name] for name in WORK})
        by_steps = _differences(state.contact, None if record.coarse is None else record.coarse.contact)
        status = worst(record.statuses)
        frames.append(replace(state.contact, time=state.time, status=status, errors_by_steps=by_steps, **work))
    rejected = sum(record.work["rejected"] for record in records)
    return Trajectory(problem, tuple(frames), rejected, restarts=0, description=posed)


def follow_film_wear(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    times: ArrayLike,
    error: float | None = None,
    options: SolveOptions,
    progress: Callable[[float, float], None] | None = None,
) -> FilmTrajectory:
    """Follow the wear of asperities on the boundary film of `scene`; the arguments are those of :func:`follow_wear`.

    The film is steady at each instant, solved from that before. Wear follows from the pressure that asperities carry,
    not from that of the lubricant.
    """
    wear, lubrication, unworn = scene.wear, scene.lubrication, replace(scene, wear=None)
    assert wear is not None
    assert lubrication is not None
    assert lubrication.boundary is not None

    controls = FilmControls(tolerance=options.tolerance, max_iterations=options.max_iterations)

    def solved(depth: Array, before: FilmSolution | None) -> FilmSolution:
        worn = replace(unworn, shapes=(*unworn.shapes, SurfaceDepth(depth, grid)))
        film = solve_lubricated(worn, grid, padding, controls, before)
        return replace(film, scene=scene, wear_depth=depth)

    def rate(film: FilmSolution) -> Array:
        assert film.contact_pressure is not None
        return _wear_rate(wear, abs(film.sliding_speed) * film.contact_pressure, grid)

    def counted(film: FilmSolution) -> Counter[str]:
        return Counter(iterations=film.iterations, linear_iterations=film.linear_iterations)

    wearing = _Wearing(solved, rate, counted, FIRST_DEPTH * lubrication.boundary.film)
    records = wearing.records(grid.cells, times, error, progress)
    films = [replace(record.state.contact, status=worst(record.statuses)) for record in records]
    return film_trajectory(records, films)


def _wear_rate(wear: Wear, pv: Array, grid: Grid) -> Array:
    """Return the wear rate (x, y) [m/s] where the product of pressure and sliding speed is `pv` (x, y) [W/m^2]."""
    if wear.circumference is None:
        return wear.coefficient * pv
    around = pv.sum(axis=0) * grid.cell_size[0] / wear.circumference
    return np.broadcast_to(wear.coefficient * around, pv.shape)

"""Contacts that are in equilibrium at each instant: under a load that changes, and on surfaces that wear slowly.

Such a contact keeps no retarded or plastic deformation from one instant to the next: those are in ``evolve``. Films
whose thickness changes with time are in ``evolve_lubricated``; here films are steady.

Load histories (:func:`follow_load`). An adhesive contact begins with the state before it. Between two turning points of
the load the state does not depend on the number of instants, because the fixed-point map is monotone: a larger initial
attraction gives a larger final one. It is therefore solved at all turning points, recorded or not. Rolling is steady at
each instant and depends on its load alone. So there is no time-discretisation error.

Wear (:func:`follow_wear` of dry contacts that roll, :func:`follow_film_wear` on a boundary film). The wear depth w adds
to the gap, and its rate follows from the contact on that gap: ``dw/dt = f(w)``. Heun's method takes a step by the mean
of the rates at its start and at the end of Euler's step; the change of the pressure from Euler's step to this one
controls its length. A body that turns wears alike all round, by the mean of Archard's law over its circumference.

Source of the wear law: Archard (1953).
"""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from contactstudy.domain.grid import Array, Grid, Padding, Paddings, on_cells
from contactstudy.evolution.evolve_lubricated import FilmTrajectory, film_trajectory
from contactstudy.evolution.march import Breakpoint, Control, March, MarchState, Method, Record, ascending, schedule
from contactstudy.evolution.steady_rolling import SteadyRolling, solve_rolling
from contactstudy.evolution.time_stepper import Frame, Trajectory, error_of_peak, frame_of
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.pseudo_time import FilmControls
from contactstudy.lubrication.steady_film import solve_lubricated
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.problem.problem import Field, Problem
from contactstudy.scene.friction import TractiveRolling, Wear, check_slow
from contactstudy.scene.loads import ChangingLoad, LineLoad
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.shapes.shape import LengthScales
from contactstudy.scene.solids.bodies import creeps, instantaneous
from contactstudy.solvers.adhesion import AdhesiveSolver
from contactstudy.solvers.solution import RollingTraction, Solution, unloaded, worst, worst_until
from contactstudy.solvers.solve import LaggedSolution, SolveOptions, solve_contact

# A dry contact, or a film.
Contact = TypeVar("Contact", Frame, FilmSolution)


@dataclass(frozen=True, eq=False, kw_only=True)
class QuasiStatic(MarchState, Generic[Contact]):
    """A contact or film in equilibrium; `depth` (x, y) [m] is that of wear so far, None where nothing wears."""

    depth: Array | None = None

    @property
    def contact(self) -> Contact:
        """Contact or film at the time."""
        last: Contact = self.contacts[-1]
        return last


def _recorded_frame(record: Record[QuasiStatic[Frame]], errors_by_steps: Mapping[str, float]) -> Frame:
    """Return the dry contact of a record, with the outcomes and work since the record before."""
    state = record.state
    status = worst_until(state.contact.status, record.statuses)
    work: Any = {name: record.work[name] for name in ("solves", "iterations", "convolutions")}
    return replace(state.contact, time=state.time, status=status, errors_by_steps=errors_by_steps, **work)


@dataclass(frozen=True, eq=False)
class _LoadSteps(Method[QuasiStatic[Frame], Frame]):
    """Contacts under the loads at the `points` of a history, by their times [s], without doubled steps.

    `solved` solves a contact at a time [s] under a load [N/m] from the one before; None begins anew.
    """

    solved: Callable[[float, float, Frame | None], Frame]
    points: Mapping[float, Breakpoint]

    def begin(self, start: QuasiStatic[Frame]) -> tuple[QuasiStatic[Frame], None]:
        """Return the start, and no state of doubled steps."""
        return start, None

    def step(self, state: QuasiStatic[Frame], end: float) -> QuasiStatic[Frame]:
        """Return the contact at `end` [s] under the load before any jump there."""
        return QuasiStatic(time=end, contacts=(self.solved(end, self.points[end].before, state.contact),))

    def jump(self, state: QuasiStatic[Frame], increments: int) -> QuasiStatic[Frame]:
        """Return the contact under the load after the jump at its time."""
        contact = self.solved(state.time, self.points[state.time].after, state.contact)
        return QuasiStatic(time=state.time, contacts=(contact,))

    def recorded(self, record: Record[QuasiStatic[Frame]], *, has_failed: bool) -> Frame:
        """Return the contact of a record."""
        return _recorded_frame(record, {})


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
    history = scene.load
    assert isinstance(history, ChangingLoad)
    turns = history.turning_points(schedule(history, times)[-1].time)
    start, *later = schedule(history, times, turns=turns)
    points = [replace(start, before=start.after), *later]  # no load jumps at the start
    elastic = scene
    if (speed := scene.rolling_speed) is not None:
        if any(map(creeps, scene.solids)):
            check_slow("Scene.rolling", speed, history, scene.hertz)
        elastic = replace(scene, rolling=None, solids=instantaneous(scene.solids))
    adhesive_solver: Any = None
    if scene.adhesion is not None:
        adhesive_solver = _under(elastic, start.after).problem(grid, padding).adhesion
    else:  # the contact does not depend on those before: only what is recorded is solved
        recorded = [point for point in points if point.times_recorded]
        points = [point if point.times_recorded == 2 else replace(point, before=point.after) for point in recorded]
    largest = replace(elastic, load=LineLoad(history.largest)).problem(grid, padding)
    posed = PosedScene(scene, grid, padding)

    def solved(time: float, load: float, last: Frame | None) -> Frame:
        """Return the contact at a `time` [s] under a `load` [N/m], from the `last` one before."""
        solution: Solution
        rolling, solves = None, 1
        if load == 0 and adhesive_solver is None:
            solution = unloaded(replace(largest, control=PrescribedLoad(0.0), description=posed))
        elif speed is not None and adhesive_solver is None:
            rolling = solve_rolling(_under(scene, load), grid, padding, options=options)
            solution, solves = rolling.solution, rolling.lagged.outer_iterations
        else:
            solution = _next_solution(_problem_under(largest, elastic, load, adhesive_solver), last, options)
            if speed is not None:  # elastic bodies, which roll without resistance: no antisymmetric weights
                solve_on = partial(solve_rolling, _under(scene, load), padding=padding, options=options)
                rolling = SteadyRolling(LaggedSolution(solution), {}, solve_on)
        if solution.adhesion is not None:
            solves = solution.adhesion.outer_iterations
        return frame_of(solution, time=time, load=load, solves=solves, rolling=rolling)

    first = points[0]
    at_first = QuasiStatic[Frame](time=first.time, contacts=(solved(first.time, first.after, None),))
    steps = _LoadSteps(solved, {point.time: point for point in points})
    march = March(steps, at_first, points, None, progress)
    return Trajectory(tuple(march.run()), march.position.total, posed)


def _under(scene: Scene, load: float) -> Scene:
    """Return `scene` under a constant `load` [N/m]; under a tensile load it is that of bodies which were in contact."""
    adhesion = scene.adhesion
    if adhesion is not None and load <= 0:
        adhesion = replace(adhesion, branch="from full contact")
    return replace(scene, load=LineLoad(load), adhesion=adhesion)


def _problem_under(problem: Problem, scene: Scene, load: float, solver: AdhesiveSolver | None) -> Problem:
    """Return the `problem` of a `scene` under a `load` [N/m], with the operator and the adhesive `solver` of all loads.

    The `problem` is that under the largest load. Its source, which makes the coarser problems of an error estimate, has
    the same solver, and so the same range of the attraction.
    """
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
    """Return the solution of `problem` from pressure and attraction of the `last` one; None at the first load."""
    start = last.pressure if last is not None and last.pressure.any() else None
    if problem.adhesion is not None and last is not None and last.adhesion is not None:
        problem = replace(problem, adhesion=problem.adhesion.continued(last.adhesion.attraction))
    return solve_contact(problem, options, start)


# Largest depth that the first step wears, over the scale of the gap or the boundary film. It decides nothing but work: a
# step that is too long for the error is rejected.
FIRST_DEPTH = 0.01
# Largest relative L1 change of the pressure by the correction of a step, where no error is asked for: a tenth of the
# default error of the pressure.
STEP_ERROR = 1e-3
# Cells by which a grid is continued beyond its edges before a cubic spline is put through it: the end condition of the
# spline then weighs (2 - 3**0.5)**4, half a per cent, at the edge.
PADDED = 4


@dataclass(frozen=True, eq=False)
class SurfaceDepth:
    """Shape that a worn surface adds to the gap: it lies `depth` (x, y) [m] deeper in the cells of `grid`."""

    depth: Array
    grid: Grid
    curvature: float = 0.0
    length_scales: LengthScales = LengthScales()  # noqa: RUF009 (a frozen value)

    def gap(self, grid: Grid) -> Array:
        """Return the depth (x, y) [m] on another grid: means over larger cells; on smaller ones, a cubic spline.

        Beyond the grid the spline keeps the value at the edge across (x), and repeats along the length (y).
        """
        if all(n <= m for n, m in zip(grid.cells, self.grid.cells, strict=True)):
            return on_cells(self.depth, grid.cells)
        around = np.pad(np.pad(self.depth, ((PADDED, PADDED), (0, 0)), "edge"), ((0, 0), (PADDED, PADDED)), "wrap")
        dx, dy = self.grid.cell_size
        rows, columns = (grid.x - self.grid.x[0]) / dx, (grid.y - self.grid.y[0]) / dy
        places = np.meshgrid(PADDED + rows, PADDED + columns, indexing="ij")
        return np.asarray(ndimage.map_coordinates(around, places, order=3, mode="nearest"))


def _differences(record: Record[QuasiStatic[Frame]]) -> dict[str, float]:
    """Return relative differences of a worn contact to that after doubled steps, by quantity; infinite without that.

    The difference of the area counts the cells in contact in one of the two alone. It is at least the difference in L1,
    since a small change may move no edge to another cell.
    """
    if record.coarse is None or not record.state.contact.pressure.any():
        return dict.fromkeys(("l1", "peak_pressure", "contact_area"), inf)
    fine, coarse = record.state.contact.pressure, record.coarse.contact.pressure
    change, touching = np.abs(fine - coarse), fine > 0
    moved = np.count_nonzero(touching ^ (coarse > 0)) / np.count_nonzero(touching)
    l1, of_peak = float(change.sum() / fine.sum()), error_of_peak(fine, change) / float(fine.max())
    return {"l1": l1, "peak_pressure": of_peak, "contact_area": float(max(l1, moved))}


@dataclass(frozen=True, eq=False)
class _Wearing(Method[QuasiStatic[Contact], Record[QuasiStatic[Contact]]]):
    """Heun's method for the wear depth of a contact.

    Attributes
    ----------
    wear
        Wear of the scene.
    grid
        Grid of the contact.
    solved
        Solves the contact with a wear depth (x, y) [m], from the one before; None begins anew.
    power
        Product (x, y) [W/m^2] of pressure and sliding speed in a contact.
    first_depth
        Largest depth [m] of the first step.
    """

    wear: Wear
    grid: Grid
    solved: Callable[[Array, Contact | None], Contact]
    power: Callable[[Contact], Array]
    first_depth: float

    def rate(self, contact: Contact) -> Array:
        """Return the wear rate (x, y) [m/s] of a contact, a mean over the circumference of a body that turns."""
        power = self.power(contact)
        if self.wear.circumference is None:
            return self.wear.coefficient * power
        around = power.sum(axis=0) * self.grid.cell_size[0] / self.wear.circumference
        return np.broadcast_to(self.wear.coefficient * around, power.shape)

    def step(self, state: QuasiStatic[Contact], end: float) -> QuasiStatic[Contact]:
        """Return the contact after a step to `end` [s], with the change from Euler's predictor to it."""
        assert state.depth is not None
        rate, duration = self.rate(state.contact), end - state.time
        predicted = self.solved(state.depth + duration * rate, state.contact)
        depth = state.depth + duration / 2 * (rate + self.rate(predicted))
        after = self.solved(depth, predicted)
        change = float(np.abs(after.pressure - predicted.pressure).sum() / state.contact.pressure.sum())
        has_failed = after.status.is_failure or predicted.status.is_failure
        return QuasiStatic(time=end, contacts=(predicted, after), step_error=inf if has_failed else change, depth=depth)

    def recorded(self, record: Record[QuasiStatic[Contact]], *, has_failed: bool) -> Record[QuasiStatic[Contact]]:
        """Return the record as it is."""
        return record

    def records(
        self, times: ArrayLike, error: float | None, progress: Callable[[float, float], None] | None
    ) -> list[Record[QuasiStatic[Contact]]]:
        """Return the contact at each of `times` [s], or up to one without a solution; see :func:`follow_wear`."""
        instants, unworn = ascending(times), np.zeros(self.grid.cells)
        contact = self.solved(unworn, None)
        step_error = inf if contact.status.is_failure else 0.0
        start = QuasiStatic[Contact](
            time=min(0.0, instants[0]), contacts=(contact,), step_error=step_error, depth=unworn
        )
        rate = float(self.rate(contact).max())
        # a pair of steps
        first = 2 * self.first_depth / rate if rate else inf
        control = Control(STEP_ERROR if error is None else error, self.order, first)
        points = [Breakpoint(time, times_recorded=1) for time in instants]
        return March(self, start, points, control, progress).run()


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
        """Return the contact worn by a `depth` (x, y) [m], from the one `before`."""
        worn, rolling = replace(unworn, shapes=(*unworn.shapes, SurfaceDepth(depth, grid))), None
        if worn.rolls:
            rolling = solve_rolling(worn, grid, padding, options=options)
            solution = rolling.solution
        else:
            start = None if before is None else before.pressure
            solution = solve_contact(worn.problem(grid, padding), options, start)
        # the scene that the user gave, without the worn surface; the time is set where it is recorded
        return frame_of(
            replace(solution, problem=replace(solution.problem, description=posed)),
            time=0.0,
            load=scene.largest_load,
            solves=1 if rolling is None else rolling.lagged.outer_iterations,
            fields={"wear_depth": Field(("x", "y"), depth, "m", "wear depth")},
            rolling=rolling,
        )

    def power(contact: Frame) -> Array:
        """Return pressure times sliding speed (x, y) [W/m^2]."""
        traction = contact.traction
        if isinstance(traction, RollingTraction):
            assert isinstance(scene.friction, TractiveRolling)
            # the frictional power per area is the coefficient of friction times pressure times sliding speed
            return traction.power / scene.friction.coefficient
        return wear.speed * contact.pressure

    wearing = _Wearing(wear, grid, solved, power, FIRST_DEPTH * problem.scales.gap)
    records = wearing.records(times, error, progress)
    frames = tuple(_recorded_frame(record, _differences(record)) for record in records)
    return Trajectory(frames, sum((record.work for record in records), Counter()), posed)


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
        """Return the film on surfaces worn by a `depth` (x, y) [m], from the one `before`."""
        worn = replace(unworn, shapes=(*unworn.shapes, SurfaceDepth(depth, grid)))
        film = solve_lubricated(worn, grid, padding, controls, before)
        return replace(film, scene=scene, wear_depth=depth)

    def power(film: FilmSolution) -> Array:
        """Return pressure of asperities times sliding speed (x, y) [W/m^2]."""
        assert film.contact_pressure is not None
        return abs(film.sliding_speed) * film.contact_pressure

    wearing = _Wearing(wear, grid, solved, power, FIRST_DEPTH * lubrication.boundary.film)
    records = wearing.records(times, error, progress)
    films = [replace(record.state.contact, status=worst(record.statuses)) for record in records]
    return film_trajectory(records, films)

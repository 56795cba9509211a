"""Lubricated contact in time: histories of load and speed, and surfaces that move through it.

The squeeze term is a backward difference over two steps (BDF2 with steps of varying length), and each step is solved by
the iteration of a steady film. It starts from a predictor, the polynomial through the last instants, three at most. The
difference between predictor and solution estimates the error of the step (Gear 1971), and a second evolution with steps
twice as long the error at an instant.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.grid import Array, ExactPeriodicity, Grid, Padding, Paddings
from contactstudy.domain.validation import InvalidInput
from contactstudy.evolution.march import ROUNDING, Breakpoint, Control, March, Method, Record, ascending, kinks
from contactstudy.lubrication.film_equation import Film, SqueezeTerm
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.posed_film import PosedFilm, lubricated_scales, pose
from contactstudy.lubrication.pseudo_time import FilmControls, FilmIteration, iterate
from contactstudy.lubrication.steady_film import ROUGH_CHANGE, continued, film_solution
from contactstudy.scene.loads import ChangingLoad, LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Counts, Status

# Time-discretisation error over the largest difference to an evolution with steps twice as long.
ERROR_OVER_DIFFERENCE = 1.5
# Statuses of a film whose errors are infinite.
FAILED = (Status.FILM_NOT_CONVERGED, Status.NOT_CONVERGED)
# First step, over the time in which the mean speed passes a cell; and the first step in pseudo-time [a / u_m], so long
# that it is Newton's. The constants of steps were chosen on waves that pass in 12 to 96 steps.
FIRST, PSEUDO_TIME_STEP = 0.5, 1e6
# Error of a step of BDF2 over the difference to a quadratic through three instants (Gear 1971, equal steps), and the
# least thickness of a predicted film over that at the last instant.
ERROR_OF_STEP, MIN_FILM_FRACTION = 2 / 11, 0.3
# Farthest motion of a moving shape in a step, over Hertz's half-width, so that none passes the contact unseen, and
# least steps in a period of the load.
LONGEST_MOTION, PER_PERIOD = 0.5, 4
# Numbers that may have their extremes between recorded instants: names and attributes of a film.
NUMBERS = {
    "peak_pressure": "peak_pressure",
    "central_film": "central_film",
    "minimum_film": "minimum_film",
    "friction_coefficient": "friction",
    "rolling_resistance": "rolling_resistance",
}
# Allowed error of a step where none is given, and where its length is given instead.
STEP_ERROR, UNLIMITED = 1e-3, 1e99


@dataclass(frozen=True, eq=False)
class FilmTrajectory:
    """Lubricated contacts at instants.

    Attributes
    ----------
    times
        Time [s] of each contact.
    contacts
        The contacts.
    work
        Number of ``steps`` in time, of ``iterations`` of the film and of ``linear_iterations`` of its linear systems,
        those of rejected steps and of steps twice as long too.
    time_discretisation_errors
        Estimates (time,) of the relative time-discretisation errors of the pressure in L1, of all steps together, from a
        second evolution with steps twice as long; infinite if one of the two failed.
    ranges
        Lowest and highest value of numbers after each pair of steps, by name; of none where they are not known.
    """

    times: tuple[float, ...]
    contacts: tuple[FilmSolution, ...]
    work: Counter[str]
    time_discretisation_errors: Array
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def counts(self) -> Counts:
        """Number of instants, and of steps and iterations."""
        return {
            "instants": (len(self.contacts), "instants recorded"),
            "steps": (self.work["steps"], "steps in time"),
            "iterations": (self.work["iterations"], "iterations of all steps"),
            "linear_iterations": (self.work["linear_iterations"], "iterations of linear systems"),
        }


def _difference(fine: FilmSolution, coarse: FilmSolution) -> float:
    """Return the L1 difference of a film's pressure to that after longer steps, over the sum of the pressure.

    It is infinite if one of the films has not converged.
    """
    if fine.status in FAILED or coarse.status in FAILED:
        return inf
    return float(np.abs(fine.pressure - coarse.pressure).sum() / fine.pressure.sum())


def film_trajectory(
    records: Sequence[Record[Any]],
    films: Sequence[FilmSolution],
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> FilmTrajectory:
    """Return the `films` that a march recorded, with errors by steps, and the `ranges` of numbers over all steps.

    They are estimated from the differences to films after longer steps: at an instant by the largest until the next that
    is known, or of all where none is later, as one alone may vanish by chance. They are infinite without any difference,
    and where a film has not converged.
    """
    work = sum((record.work for record in records), Counter())
    differences = {
        number: _difference(films[number], record.coarse.contact)
        for number, record in enumerate(records)
        if record.coarse is not None
    }
    errors = np.full(len(films), inf)
    if differences:
        until = np.minimum(np.searchsorted(list(differences), range(len(films))), len(differences) - 1)
        errors = ERROR_OVER_DIFFERENCE * np.maximum.accumulate(list(differences.values()))[until]
        errors[[film.status in FAILED for film in films]] = inf
    return FilmTrajectory(tuple(record.state.time for record in records), tuple(films), work, errors, ranges or {})


@dataclass(frozen=True, eq=False)
class _Instant:
    """Film at a time [a / u_m], its content (x, y), the iteration that led to it, and its rate (x, y) if it changes."""

    time: float
    film: Film
    content: Array
    iteration: FilmIteration
    rate: Array | None = None


def evolve_lubricated(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings = ExactPeriodicity(),  # noqa: B008 (a frozen value)
    *,
    times: ArrayLike,
    error: float | None = None,
    step: float | None = None,
    tolerance: float = 1e-6,
    progress: Callable[[float, float], None] | None = None,
) -> FilmTrajectory:
    """Evolve the film of ``scene`` in time, from the steady film at the first time.

    A second evolution with steps twice as long estimates the time-discretisation error at an instant: 1.5 times the
    largest difference until that instant. By second order it would be a third of the difference, but waves that pass in
    a dozen steps have more.

    Parameters
    ----------
    scene
        A lubricated scene. Its load and its mean speed may have a history, and :class:`~contactstudy.MovingShape` shapes
        move with a body.
    grid, padding
        As for :func:`~contactstudy.solve`.
    times
        Instants [s] at which the contact is recorded, ascending, before the load where that jumps; the film is steady at
        the first.
    error
        Largest error of a step: L1 error of the film thickness over its mean, in the Hertzian zone. 1e-3 if neither this
        nor ``step`` is given.
    step
        Largest length of a step [s], in place of ``error``. Steps end at each instant and where load or speed have a
        kink, and are shorter where they fail.
    tolerance
        Residual of each step.
    progress
        Called with the time since the start and that of the whole [s], after each step.

    Returns
    -------
    FilmTrajectory
        The contacts at the times, up to a step that fails, with its own time.

    Raises
    ------
    InvalidInput
        For a scene without lubrication, times that are not ascending, a speed of zero at the first time, and a load of
        zero at any: no film carries it.
    """
    instants = ascending(times, least=2)
    _check_loaded(scene, instants)
    if error is None:
        error = STEP_ERROR if step is None else UNLIMITED
    start = _FilmStepper.begin(scene, grid, padding, instants[0], tolerance)
    passage = start.posed.equation.cell[0] * start.time_unit
    control = Control(
        error,
        _Films.order,
        first=2 * (step or FIRST * passage),
        # two steps at least, which the estimate takes at once
        longest=min(2 * (step or inf), 2 * start.longest_step, instants[-1] - instants[0]),
    )
    first, last = instants[0], instants[-1]
    least = ROUNDING * (last - first)
    between = {
        time
        for history in scene.histories
        for time in kinks(history, last)
        if first < time < last and min(abs(time - instant) for instant in instants) > least
    }
    points = [Breakpoint(time, times_recorded=int(time in instants)) for time in sorted({*instants, *between})]
    method = _Films()
    records = March(method, start, points, control, progress).run()
    return film_trajectory(records, [record.state.contact for record in records], method.ranges)


def _check_loaded(scene: Scene, instants: list[float]) -> None:
    """Raise :class:`~contactstudy.InvalidInput` if the load is zero at a time of the evolution."""
    if not isinstance(load := scene.load, ChangingLoad):
        return
    start, end = instants[0], instants[-1]
    turns = [time for time in load.turning_points(end) if time > start]
    for time in (start, *instants, *turns):
        if load.at(time) <= 0 or (time > start and load.before(time) <= 0):
            raise InvalidInput(
                f"Scene.load is 0 at {time:g} s, when no film has a thickness of its own: give loads above 0, such as a "
                "hundredth of the largest, or other times."
            )


class _Films(Method["_FilmStepper", Record["_FilmStepper"]]):
    """Steps of a film, and the lowest and highest value of each of `NUMBERS` after all pairs of them."""

    order = 3

    def __init__(self) -> None:
        self.ranges: dict[str, tuple[float, float]] = {}

    def step(self, state: "_FilmStepper", end: float) -> "_FilmStepper":
        """Return the film after a step to `end` [s]."""
        return state.advanced(end)

    def accept(
        self, before: "_FilmStepper", middle: "_FilmStepper", after: tuple["_FilmStepper", "_FilmStepper | None"]
    ) -> float:
        """Take a pair of steps into the ranges; the error of all steps is not limited."""
        for name, attribute in NUMBERS.items():
            value = getattr(after[0].contact, attribute)
            values = value, *self.ranges.get(name, ())
            self.ranges[name] = min(values), max(values)
        return 0.0

    def recorded(self, record: Record["_FilmStepper"], *, has_failed: bool) -> Record["_FilmStepper"]:
        """Return the record as it is."""
        return record


@dataclass(frozen=True, eq=False)
class _FilmStepper:
    """Time stepper: the last three instants, latest first, and the film equation at the latest.

    ``posed`` is the film equation at the largest load and speed, whose units hold at all times; ``distance`` [m] is how
    far the mean speed has gone; ``change`` is the error of the last step, infinite where that has no solution.
    """

    scene: Scene
    grid: Grid
    padding: Padding | Paddings
    posed: PosedFilm
    time_unit: float
    tolerance: float
    time: float
    distance: float
    past: tuple[_Instant, ...]
    now: PosedFilm
    change: float = 0.0

    @classmethod
    def begin(
        cls, scene: Scene, grid: Grid, padding: Padding | Paddings, start: float, tolerance: float
    ) -> "_FilmStepper":
        """Return a time stepper at the steady film of the first time."""
        load, largest = scene.load, scene
        first_load = scene.largest_load
        if isinstance(load, ChangingLoad):
            largest, first_load = replace(scene, load=LineLoad(load.largest)), load.at(start)
        posed = pose(largest, grid, padding)
        time_unit = posed.scales.hertz.half_width / posed.scales.lubrication.largest_speed
        stepper = cls(scene, grid, padding, posed, time_unit, tolerance, start, 0.0, (), posed)
        now = stepper._posed_at(start, 0.0, first_load)
        if now.equation.speed <= 0:
            raise InvalidInput(
                f"Scene.lubrication.mean_speed is 0 at the first time, {start:g} s, when no film is steady: give a "
                "value above 0, or a later first time."
            )
        last = continued(now, FilmControls(tolerance=tolerance))
        instant = _Instant(start / time_unit, last.film, now.equation.content(last.film), last)
        return replace(stepper, past=(instant,), now=now)

    @property
    def longest_step(self) -> float:
        """Longest step [s]: a part of the load's period, and of the time in which a moving shape passes the contact."""
        longest: float = getattr(self.scene.load, "period", inf) / PER_PERIOD
        if any(hasattr(shape, "gap_after") for shape in self.scene.shapes):
            fastest = 1 + abs(self.posed.scales.lubrication.slide_roll_ratio) / 2
            longest = min(longest, LONGEST_MOTION * self.time_unit / fastest)
        return longest

    @property
    def last(self) -> FilmIteration:
        """Iteration of the last instant."""
        return self.past[0].iteration

    @property
    def statuses(self) -> tuple[Status, ...]:
        """Outcome of the last instant."""
        return (Status.CONVERGED if self.change < inf else Status.FILM_NOT_CONVERGED,)

    @property
    def work(self) -> Counter[str]:
        """Iterations of the last step."""
        last = self.last
        return Counter(iterations=last.iterations, linear_iterations=last.linear_iterations)

    def advanced(self, end: float) -> "_FilmStepper":
        """Return the time stepper after a step to `end` [s], with the error of that step; the first two have none."""
        length = end - self.time
        speed = self.posed.scales.lubrication.speed_at
        middle = speed(self.time + length / 2)
        distance = self.distance + length * (speed(self.time) + 4 * middle + speed(end)) / 6
        load = self.scene.load
        load_before = load.before(end) if isinstance(load, ChangingLoad) else self.scene.largest_load
        now = self._posed_at(end, distance, load_before)
        equation, step = now.equation, length / self.time_unit
        expected = self._expected(now, end / self.time_unit)
        controls = FilmControls(
            tolerance=self.tolerance,
            max_iterations=60,
            time_step=PSEUDO_TIME_STEP,
            viscosity_change=ROUGH_CHANGE,
        )
        last = iterate(
            equation, expected, controls,
            squeeze=self._squeeze_term(step, [instant.content for instant in self.past]),
            cavitated=self.last.cavitated,
        )  # fmt: skip
        of_film = self._squeeze_term(step, [instant.film.thickness for instant in self.past])
        rate = of_film.rate * last.film.thickness + of_film.history
        content = equation.content(last.film)
        instant = _Instant(end / self.time_unit, last.film, content, last, rate)
        from_axis = np.abs(now.x)
        # on cells wider than the contact, the one at the axis
        inside = (from_axis < 1) | (from_axis == from_axis.min())
        change = np.abs(last.film.thickness - self._extrapolated(end / self.time_unit, "thickness"))[inside].mean()
        error = 0.0
        if len(self.past) > 2:
            error = ERROR_OF_STEP * float(change / last.film.thickness[inside].mean())
        error = error if last.converged(self.tolerance) else inf
        past = (instant, *self.past[:2])
        return replace(self, time=end, past=past, now=now, distance=distance, change=error)

    @cached_property
    def contact(self) -> FilmSolution:
        """Contact at the last instant."""
        rate, now = self.past[0].rate, self.now
        unit = now.scales.film / self.time_unit
        return film_solution(
            self.scene, self.grid, self.padding, now, self.last, self.tolerance,
            None if rate is None else unit * rate,
        )  # fmt: skip

    def _posed_at(self, time: float, distance: float, load: float) -> PosedFilm:
        """Return the film equation at a time [s] under a `load` [N/m], when the mean speed has gone a distance [m]."""
        scales = self.posed.scales
        slide = scales.lubrication.slide_roll_ratio / 2
        gap = np.zeros(self.grid.cells)
        for shape in self.scene.shapes:
            if hasattr(shape, "gap_after"):  # a shape that names no body moves with the first
                shift = distance * (1 + slide * (1 - 2 * getattr(shape, "body", 0)))
                gap += shape.gap_after(self.grid, shift)
            else:
                gap += shape.gap(self.grid)
        posed = self.posed.with_gap(gap)
        speed = scales.lubrication.speed_at(time)
        equation = replace(
            posed.equation,
            load=self.posed.equation.load * load / self.scene.largest_load,
            speed=speed / scales.lubrication.largest_speed,
        )
        here = self.scene
        if isinstance(here.load, ChangingLoad):
            here = replace(here, load=LineLoad(load))
        return replace(posed, equation=equation, instant=lubricated_scales(here, speed))

    def _squeeze_term(self, step: float, past: list[Array]) -> SqueezeTerm:
        """Return the rate after a step [a / u_m] of a field (x, y), such as the content, from ``past`` instants.

        It is that of BDF2, or of backward Euler for the first step.
        """
        if len(past) == 1:
            return SqueezeTerm(1 / step, -past[0] / step)
        ratio = step / (self.past[0].time - self.past[1].time)
        history = -(1 + ratio) * past[0] + ratio**2 / (1 + ratio) * past[1]
        return SqueezeTerm((1 + 2 * ratio) / (1 + ratio) / step, history / step)

    def _extrapolated(self, time: float, field: str) -> Array:
        """Return a field of the film at a later time [a / u_m], by the polynomial through the last instants."""
        total = np.zeros_like(self.past[0].film.thickness)
        for i, instant in enumerate(self.past):
            weight = 1.0
            for j, node in enumerate(self.past):
                if j != i:
                    weight *= (time - node.time) / (instant.time - node.time)
            total = total + weight * getattr(instant.film, field)
        return total

    def _expected(self, now: PosedFilm, time: float) -> Film:
        """Return the predicted film at a time [a / u_m]; that of the last instant where a prediction is too thin."""
        last = self.past[0].film
        pressure = np.maximum(self._extrapolated(time, "pressure"), 0)
        pressure[self.last.cavitated | now.equation.fixed] = 0
        void = np.where(pressure > 0, 0, last.void)
        separation = float(self._extrapolated(time, "separation").flat[0])
        film = now.equation.film_of(pressure, void, separation)
        if (film.thickness > MIN_FILM_FRACTION * last.thickness).all():
            return film
        film = now.equation.film_of(last.pressure, last.void, last.separation)
        rise = max(0.0, float((MIN_FILM_FRACTION * last.thickness - film.thickness).max()))
        return now.equation.film_of(last.pressure, last.void, last.separation + rise)

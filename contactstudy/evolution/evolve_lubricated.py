"""Lubricated contact in time: histories of load and speed, and surfaces that move through it.

The film satisfies the Reynolds equation with the squeeze term, the rate of the lubricant content. The rate is a backward
difference over two steps (BDF2 with steps of varying length), and each step is solved by the iteration of a steady
film. The iteration starts from a predictor, the polynomial through the last instants, three at most. The difference
between predictor and solution estimates the error of the step (Gear 1971, Numerical Initial Value Problems in Ordinary
Differential Equations). A second evolution with steps twice as long estimates the error at an instant.

The unit of time a / u_m is the time in which the largest mean speed u_m passes Hertz's half-width a.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.grid import Array, ExactPeriodicity, Grid, Padding, Paddings
from contactstudy.domain.validation import InvalidInput
from contactstudy.evolution.march import (
    MIN_STEPS_PER_PERIOD,
    ROUNDING,
    Breakpoint,
    Control,
    March,
    MarchState,
    Method,
    Record,
    ascending,
    kinks,
)
from contactstudy.lubrication.film_equation import Film, SqueezeTerm
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.posed_film import PosedFilm, lubricated_scales, pose
from contactstudy.lubrication.pseudo_time import FilmControls, FilmIteration, iterate
from contactstudy.lubrication.steady_film import continued, film_solution
from contactstudy.scene.loads import ChangingLoad
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Counts, Status

# Time-discretisation error over the largest difference to an evolution with steps twice as long. By second order it
# would be a third; waves that pass in a dozen steps have more.
ERROR_OVER_DIFFERENCE = 1.5
# Statuses of a film whose errors are infinite.
FAILED = (Status.FILM_NOT_CONVERGED, Status.NOT_CONVERGED)
# First step, over the time in which the mean speed passes a cell, chosen on waves that pass in 12 to 96 steps. The first
# two steps have no estimate: half and twice this length changed a film that starts from rest by 0.3 and 1.1 %.
FIRST_STEP = 0.5
# Step in pseudo-time [a / u_m] of the iteration of a step in time, so long that it is Newton's.
PSEUDO_TIME_STEP = 1e6
# Most iterations of a step. A step takes a few; one that takes more is tried again with a shorter length.
MAX_ITERATIONS = 60
# Error of a step of BDF2 over the difference to a quadratic through three instants (Gear 1971, for equal steps).
ERROR_OF_STEP = 2 / 11
# Least thickness of a predicted film over that at the last instant: a thinner one is no film to begin with.
# Half and twice of it changed no steps of a dent that passes, of loads that jump, and of a start from rest.
MIN_FILM_FRACTION = 0.3
# Farthest motion of a moving shape in a step, over Hertz's half-width, so that none passes the contact unseen.
LONGEST_MOTION = 0.5
# Numbers that may have their extremes between recorded instants, by name: attributes of a film.
NUMBERS = {
    "peak_pressure": "peak_pressure",
    "central_film": "central_film",
    "minimum_film": "minimum_film",
    "friction_coefficient": "friction",
    "rolling_resistance": "rolling_resistance",
}
# Allowed error of a step where neither it nor its length is given: a tenth of the default error of the pressure. Where
# the length is given, it is so large that no step is rejected but those that fail, whose error is infinite.
STEP_ERROR, UNLIMITED = 1e-3, 1e99
# Work of films in time, with its meaning in words.
WORK = {
    "steps": "steps in time",
    "iterations": "iterations of all steps",
    "linear_iterations": "iterations of linear systems",
}


@dataclass(frozen=True, eq=False)
class FilmTrajectory:
    """Lubricated contacts at recorded instants, and what their evolution took.

    Attributes
    ----------
    times
        Time [s] of each contact.
    contacts
        The contacts.
    work
        Work by the names in `WORK`, that of rejected steps and of steps twice as long too.
    time_discretisation_errors
        Estimates (time,) of the relative time-discretisation errors of the pressure in L1, of all steps together, from a
        second evolution with steps twice as long; infinite if one of the two failed.
    ranges
        Lowest and highest value of the quantities in `NUMBERS` after all pairs of steps, by name; empty where they are
        not known, as of films that wear.
    """

    times: tuple[float, ...]
    contacts: tuple[FilmSolution, ...]
    work: Mapping[str, int]
    time_discretisation_errors: Array
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def counts(self) -> Counts:
        """Number of instants, and of steps and iterations."""
        work = {name: (self.work.get(name, 0), meaning) for name, meaning in WORK.items()}
        return {"instants": (len(self.contacts), "instants recorded")} | work


def film_trajectory(
    records: Sequence[Record[Any]],
    films: Sequence[FilmSolution],
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> FilmTrajectory:
    """Return the `films` of the `records` of a march, with errors by steps, and the `ranges` of numbers over all steps.

    The error of the pressure is estimated from its L1 differences to films after longer steps. As a single difference
    may vanish by chance, the largest one counts: of those up to the next instant with a known one, or of all where none
    is later. The error is infinite without any difference, and where a film has not converged.
    """
    known, differences = [], []
    for number, (record, film) in enumerate(zip(records, films, strict=True)):
        if record.coarse is not None:
            coarse = record.coarse.contact
            has_failed = film.status in FAILED or coarse.status in FAILED
            change = inf if has_failed else np.abs(film.pressure - coarse.pressure).sum() / film.pressure.sum()
            known.append(number)
            differences.append(change)
    errors = np.full(len(films), inf)
    if known:
        until = np.minimum(np.searchsorted(known, range(len(films))), len(known) - 1)
        errors = ERROR_OVER_DIFFERENCE * np.maximum.accumulate(differences)[until]
        errors[[film.status in FAILED for film in films]] = inf
    times, work = tuple(record.state.time for record in records), sum((record.work for record in records), Counter())
    return FilmTrajectory(times, tuple(films), work, errors, ranges or {})


@dataclass(frozen=True, eq=False)
class _Instant:
    """Film at a time.

    Attributes
    ----------
    time
        Time, in units of a / u_m: Hertz's half-width over the largest mean speed.
    iteration
        The iteration that led to the film, with the film.
    content
        Dimensionless lubricant content (x, y) of the film: density times thickness where it fills the gap.
    rate
        Rate of the dimensionless film thickness (x, y) per unit of time; None of the steady film.
    """

    time: float
    iteration: FilmIteration
    content: Array
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
    first, last = instants[0], instants[-1]
    between = {
        time
        for history in scene.histories
        for time in kinks(history, last)
        if first < time < last and min(abs(time - instant) for instant in instants) > ROUNDING * (last - first)
    }
    ends, load = sorted({*instants, *between}), scene.load
    for time in ends:
        if not isinstance(load, ChangingLoad):
            break
        if load.at(time) <= 0 or (time > first and load.before(time) <= 0):
            raise InvalidInput(
                f"Scene.load is 0 at {time:g} s, when no film has a thickness of its own: give loads above 0, such as a "
                "hundredth of the largest, or other times."
            )
    start = _FilmState.begin(scene, grid, padding, first, tolerance)
    passage = start.posed.equation.cell[0] * start.time_unit
    control = Control(
        error or (STEP_ERROR if step is None else UNLIMITED),
        _Films.order,
        first=2 * (step or FIRST_STEP * passage),
        # two pairs of steps at least, as the first steps have no estimate
        longest=min(2 * (step or inf), 2 * start.longest_step, last - first),
    )
    method, points = _Films(), [Breakpoint(time, times_recorded=int(time in instants)) for time in ends]
    records = March(method, start, points, control, progress).run()
    return film_trajectory(records, [record.state.contact for record in records], method.ranges)


class _Films(Method["_FilmState", Record["_FilmState"]]):
    """Steps of a film. `ranges` are the lowest and highest value of each of `NUMBERS` after all pairs of steps."""

    order = 3

    def __init__(self) -> None:
        self.ranges: dict[str, tuple[float, float]] = {}

    def step(self, state: "_FilmState", end: float) -> "_FilmState":
        """Return the film after a step to `end` [s]."""
        return state.advanced(end)

    def accept(
        self, before: "_FilmState", middle: "_FilmState", after: tuple["_FilmState", "_FilmState | None"]
    ) -> float:
        """Take a pair of steps into the ranges; the error of all steps is not limited."""
        for name, attribute in NUMBERS.items():
            value = getattr(after[0].contact, attribute)
            values = value, *self.ranges.get(name, ())
            self.ranges[name] = min(values), max(values)
        return 0.0

    def recorded(self, record: Record["_FilmState"], *, has_failed: bool) -> Record["_FilmState"]:
        """Return the record as it is."""
        return record


@dataclass(frozen=True, eq=False, kw_only=True)
class _FilmState(MarchState):
    """Film at a time, its last three instants, and the film equation at the latest.

    Attributes
    ----------
    scene, grid, padding, tolerance
        What is solved, see :func:`evolve_lubricated`.
    posed
        Film equation at the largest load and speed, whose units hold at all times.
    time_unit
        Unit of time [s]: Hertz's half-width a over the largest mean speed u_m.
    distance
        Distance [m] that the mean speed has gone since the first time.
    past
        The last three instants at most, latest first.
    now
        Film equation at the latest of them.
    """

    scene: Scene
    grid: Grid
    padding: Padding | Paddings
    posed: PosedFilm
    time_unit: float
    tolerance: float
    distance: float
    past: tuple[_Instant, ...]
    now: PosedFilm

    @classmethod
    def begin(
        cls, scene: Scene, grid: Grid, padding: Padding | Paddings, start: float, tolerance: float
    ) -> "_FilmState":
        """Return the steady film at the first time, `start` [s]."""
        load, largest = scene.load, scene.largest_load
        posed = pose(scene.under(largest), grid, padding)
        time_unit = posed.scales.hertz.half_width / posed.scales.lubrication.largest_speed
        stepper = cls(
            scene=scene, grid=grid, padding=padding, tolerance=tolerance, posed=posed, time_unit=time_unit, time=start,
            distance=0.0, past=(), now=posed,
        )  # fmt: skip
        now = stepper._posed_at(start, 0.0, load.at(start) if isinstance(load, ChangingLoad) else largest)
        if now.equation.speed <= 0:
            raise InvalidInput(
                f"Scene.lubrication.mean_speed is 0 at the first time, {start:g} s, when no film is steady: give a "
                "value above 0, or a later first time."
            )
        steady = continued(now, FilmControls(tolerance=tolerance))
        instant = _Instant(start / time_unit, steady, now.equation.content(steady.film))
        return replace(stepper, past=(instant,), now=now)

    @property
    def longest_step(self) -> float:
        """Longest step [s]: a part of the load's period, and of the time in which a moving shape passes the contact."""
        longest: float = getattr(self.scene.load, "period", inf) / MIN_STEPS_PER_PERIOD
        if any(hasattr(shape, "gap_after") for shape in self.scene.shapes):
            fastest = 1 + abs(self.posed.scales.lubrication.slide_roll_ratio) / 2
            longest = min(longest, LONGEST_MOTION * self.time_unit / fastest)
        return longest

    @property
    def iteration(self) -> FilmIteration:
        """Iteration of the last instant, with its film."""
        return self.past[0].iteration

    @property
    def work(self) -> Counter[str]:
        """Iterations of the last step."""
        iteration = self.iteration
        return Counter(iterations=iteration.iterations, linear_iterations=iteration.linear_iterations)

    def advanced(self, end: float) -> "_FilmState":
        """Return the film after a step to `end` [s].

        Its `step_error` is that of the film thickness in L1 over its mean, in the Hertzian zone. It is 0
        of the first two steps, which have no three instants before them, and infinite where the iteration failed.
        """
        length = end - self.time
        speed = self.posed.scales.lubrication.speed_at
        middle = speed(self.time + length / 2)
        distance = self.distance + length * (speed(self.time) + 4 * middle + speed(end)) / 6  # Simpson's rule
        load = self.scene.load
        load_before = load.before(end) if isinstance(load, ChangingLoad) else self.scene.largest_load
        now = self._posed_at(end, distance, load_before)
        step, time = length / self.time_unit, end / self.time_unit
        controls = FilmControls(tolerance=self.tolerance, max_iterations=MAX_ITERATIONS, time_step=PSEUDO_TIME_STEP)
        squeeze = self._squeeze_term(step, [instant.content for instant in self.past])
        iteration = iterate(
            now.equation, self._expected(now, time), controls, squeeze=squeeze, cavitated=self.iteration.cavitated
        )
        thickness = iteration.film.thickness
        of_film = self._squeeze_term(step, [instant.iteration.film.thickness for instant in self.past])
        rate = of_film.rate * thickness + of_film.history
        instant = _Instant(time, iteration, now.equation.content(iteration.film), rate)
        error = 0.0
        if len(self.past) > 2:
            from_axis = np.abs(now.x)
            # on cells wider than the contact, the one at the axis
            inside = (from_axis < 1) | (from_axis == from_axis.min())
            change = np.abs(thickness - self._extrapolated(time, "thickness"))[inside].mean()
            error = ERROR_OF_STEP * float(change / thickness[inside].mean())
        error = error if iteration.converged(self.tolerance) else inf
        return replace(self, time=end, past=(instant, *self.past[:2]), now=now, distance=distance, step_error=error)

    @cached_property
    def contact(self) -> FilmSolution:
        """Film at the last instant with its fields and numbers, which are computed when they are asked for."""
        rate, now = self.past[0].rate, self.now
        unit = now.scales.film / self.time_unit
        return film_solution(
            self.scene, self.grid, self.padding, now, self.iteration, self.tolerance,
            None if rate is None else unit * rate,
        )  # fmt: skip

    def _posed_at(self, time: float, distance: float, load: float) -> PosedFilm:
        """Return the film equation at a `time` [s] under a `load` [N/m], when the mean speed has gone a `distance` [m].

        A shape that moves with a body has gone farther or less far than that by half the slide.
        """
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
        return replace(posed, equation=equation, instant=lubricated_scales(self.scene.under(load), speed))

    def _squeeze_term(self, step: float, past: list[Array]) -> SqueezeTerm:
        """Return the rate of a field (x, y), such as the content, after a `step` [a / u_m], as a linear function of it.

        It is that of BDF2, or of backward Euler for the first step. `past` are the fields at the last instants, latest
        first.
        """
        if len(past) == 1:
            return SqueezeTerm(1 / step, -past[0] / step)
        ratio = step / (self.past[0].time - self.past[1].time)
        history = -(1 + ratio) * past[0] + ratio**2 / (1 + ratio) * past[1]
        return SqueezeTerm((1 + 2 * ratio) / (1 + ratio) / step, history / step)

    def _extrapolated(self, time: float, field: str) -> Array:
        """Return a `field` (x, y) of the film at a later time [a / u_m], by Lagrange's polynomial through the past."""
        nodes = [instant.time for instant in self.past]
        weights = [prod((time - other) / (node - other) for other in nodes if other != node) for node in nodes]
        fields = [getattr(instant.iteration.film, field) for instant in self.past]
        return np.asarray(sum(weight * values for weight, values in zip(weights, fields, strict=True)))

    def _expected(self, now: PosedFilm, time: float) -> Film:
        """Return the predicted film at a `time` [a / u_m] of the film equation `now`.

        Where the prediction is too thin, it is the pressure of the last instant, with the surfaces so far apart that the
        film is thick enough.
        """
        last = self.iteration.film
        pressure = np.maximum(self._extrapolated(time, "pressure"), 0)
        pressure[self.iteration.cavitated | now.equation.fixed] = 0
        void = np.where(pressure > 0, 0, last.void)
        separation = float(self._extrapolated(time, "separation").flat[0])
        film = now.equation.film_of(pressure, void, separation)
        if (film.thickness > MIN_FILM_FRACTION * last.thickness).all():
            return film
        film = now.equation.film_of(last.pressure, last.void, last.separation)
        rise = max(0.0, float((MIN_FILM_FRACTION * last.thickness - film.thickness).max()))
        return now.equation.film_of(last.pressure, last.void, last.separation + rise)

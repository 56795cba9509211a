"""March of a method through time by pairs of steps, beside steps of twice the length: their difference is the error.

A user names instants and steps as :class:`TimeSteps`. Of these follow points in time at which steps end
(:class:`Breakpoint`): instants that are recorded, and those at which a load jumps or turns. A :class:`March` takes a
:class:`Method` from point to point: two short steps, which are the result, and one doubled step over the same time. A
pair that has too large an error is rejected, and the next one is as long as the error of the last one allows. Where no
error is asked for, steps go from one point to the next, and pairs of them are compared with one step. A load that jumps
is applied at its time, in increments.

What a step is and how two states are compared is the method's, in ``evolve``, ``stationary`` and ``evolve_lubricated``.

Source: Hairer, Norsett & Wanner (1993), Solving Ordinary Differential Equations I, sect. II.4, eqs. 4.4 and 4.13, there
with the error of one pair alone.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import ceil, inf, sqrt
from typing import Annotated, Any, ClassVar, Generic, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.validation import BELOW_ONE, FINITE, InvalidInput, Number, Seconds, at_least, validated
from contactstudy.scene.loads import ChangingLoad, PiecewiseLinear, Times, check_not_decreasing
from contactstudy.solvers.solution import Status

# Number of recorded instants where neither they nor their number are named: enough for a smooth curve over time.
DEFAULT_INSTANTS = 41
# Coefficient gamma of the L-stable, singly diagonally implicit Runge-Kutta scheme (SDIRK) of two stages and order 2
# (Alexander 1977, SIAM J. Numer. Anal. 14, sect. 3).
SDIRK_GAMMA = 1 - 1 / sqrt(2)

Scheme = Literal["two_stage", "implicit", "explicit"]
# Stages of a step of sliding wear in the order of time, by scheme. Each is (its fraction of the duration, the fraction
# of it in which the pressure at its start acts); in the rest the pressure at its end acts.
STAGES: dict[Scheme, tuple[tuple[float, float], ...]] = {
    "two_stage": ((SDIRK_GAMMA, 0.0), (1 - SDIRK_GAMMA, (1 - 2 * SDIRK_GAMMA) / (1 - SDIRK_GAMMA))),
    "implicit": ((1.0, 0.0),),
    "explicit": ((1.0, 1.0),),
}
ErrorEstimator = Literal["step_doubling", "none"]


@validated
class TimeSteps:
    """Instants to record of a scene that changes in time, and how steps between them are taken.

    Parameters
    ----------
    times
        The instants [s], which do not decrease; None for evenly spaced ones. A time given twice is recorded before and
        after a jump of the load; films and wear in rolling refuse it.
    end
        Last instant [s]; None for the last one that a history of load, speed or friction names.
    instants
        Number of instants, evenly spaced but for those moved to where a history has a kink or turns.
    error
        Largest relative time-discretisation error, in L1, of the pressure and in fretting of the tangential traction.
        Where a contact wears in steady or tractive rolling or on a film, it is the largest change of the pressure by
        the correction of a step; of other films, the largest error of their thickness in one step. None takes a
        fraction of the error requested of the solve. Without that, steady wear and films take 1e-3. Other scenes then
        take one step from each instant, kink of the load or quarter of its period to the next, or two where the next
        one differs in length.
    scheme
        How sliding wear, ``Wear(speed=...)`` of a dry contact that does not roll, is stepped; other wear has a method of
        its own, and creep is exact for a pressure that is linear in each stage. "implicit" is backward Euler, of first
        order, L-stable, with one solve a step; "two_stage" is of second order, L-stable, with two solves (Alexander
        1977, SIAM J. Numer. Anal. 14, sect. 3). "explicit", for comparison, is forward Euler. In plane strain it is
        unstable for steps [s] beyond 2 lambda / (k v), with the wear rate per pressure k v [m/(Pa s)] and the
        :func:`~contactstudy.evolution.states.state_variables.least_eigenvalue` lambda. Each keeps the wear volume.
    error_estimator
        How the time-discretisation error is estimated of a dry contact that keeps creep, sliding wear, plastic strain
        or a tangential traction from one instant to the next. "step_doubling" integrates a second time with steps twice
        as long, at half the cost of the first. "none" takes one step from each instant or kink of the load to the next,
        and the error is infinite.
    step
        Largest length [s] of a step of a film, in place of an error.

    Raises
    ------
    InvalidInput
        If an `error` is given beside the estimator ``"none"`` or a `step`, or `times` beside `end` or `instants`.
    """

    times: Times | None = None
    end: Annotated[Seconds, FINITE] | None = None
    instants: Annotated[int, at_least(2)] = DEFAULT_INSTANTS
    error: Annotated[Number, BELOW_ONE] | None = None
    scheme: Scheme = "implicit"
    error_estimator: ErrorEstimator = "step_doubling"
    step: Seconds | None = None

    def check_together(self) -> None:
        """Check that what decides on the instants and on the steps is given once."""
        if self.error is not None and self.error_estimator == "none":
            raise InvalidInput(
                f"TimeSteps.error_estimator is 'none' beside an error of {self.error!r}, by whose estimate steps are "
                "chosen: leave one of them out."
            )
        if self.times == ():
            raise InvalidInput("TimeSteps.times is empty: give one instant [s] or more, or leave it out.")
        if self.error is not None and self.step is not None:
            raise InvalidInput("TimeSteps has a step and an error: leave one of them out.")
        for name, default in (("end", None), ("instants", DEFAULT_INSTANTS)):
            if self.times is not None and (value := getattr(self, name)) != default:
                raise InvalidInput(
                    f"TimeSteps.{name} is {value!r} beside times, which name all instants: leave one of them out."
                )

    @classmethod
    def of(cls, times: "ArrayLike | TimeSteps | None") -> "TimeSteps":
        """Return `times` as time steps: as they are, or from instants to record [s]."""
        return times if isinstance(times, cls) else cls(times)  # type: ignore[arg-type]

    @property
    def last(self) -> float | None:
        """Last instant [s] that is named; None where the end of a history decides."""
        return self.end if self.times is None else max(self.times)

    def instants_of(self, *histories: Any) -> ArrayLike:
        """Return the instants [s] to record.

        They are `times`, if these are given, else evenly spaced up to `end`, or up to the last end of the `histories`.
        Without a `step`, the nearest of the evenly spaced instants between the first and the last is moved to
        where a history has a kink or turns; of several of them, to that of the largest value.

        Raises
        ------
        InvalidInput
            If nothing says when the last instant is.
        """
        if self.times is not None:
            return self.times
        start = min((history.start for history in histories), default=0.0)
        last = max((history.end for history in histories), default=start)
        if self.end is None and last <= start:
            raise InvalidInput(
                "solve.times is None, and nothing in the scene has an end: give times [s]; "
                "in a file give time_steps.end or time_steps.times."
            )
        end = last if self.end is None else self.end
        count = self.instants
        instants = [start + (end - start) * n / (count - 1) for n in range(count)]
        spacing = (end - start) / (count - 1)
        if self.step is None and spacing and count > 2:
            # of kinks near one instant the last counts: that of the load, the first history, at its largest value
            for time in (time for history in reversed(histories) for time in kinks(history, end)):
                if start < time < end:
                    number = round((time - start) / spacing)
                    instants[min(max(number, 1), count - 2)] = time
        return instants


def kinks(history: Any, end: float) -> list[float]:
    """Return the times [s] at which a history has a kink or turns, those of its largest values last.

    Those of a load are up to the time `end` [s]; a load that repeats has them without end.
    """
    times = getattr(history, "times", ())
    if isinstance(history, ChangingLoad):
        times = history.turning_points(end)
    return sorted(times, key=lambda time: abs(history.at(time)))


# Smallest and largest factor on the length of the next pair, and the fraction of the allowed length that is aimed at, as
# Hairer, Norsett & Wanner advise after eq. 4.13.
MIN_FACTOR, MAX_FACTOR, SAFETY = 0.2, 2.0, 0.9
# Largest factor on the length of a pair after one that was rejected, and on the allowed error of all steps in a march
# that starts again. Both are so far below 1 that a few trials find a length, however wrong its estimate.
MAX_REJECTED_FACTOR, MAX_RESTART_FACTOR = 0.5, 0.7
# Fraction of the whole time below which a pair is not rejected for too large an error, as times are rounded to 1e-16.
# The same for a step without a solution, where 20 halvings did not find one.
SHORTEST, SHORTEST_WITHOUT_SOLUTION = 1e-12, 1e-6
# Least steps in a period of a load that repeats: at whole and at half periods a sine has the same load.
MIN_STEPS_PER_PERIOD = 4
# Relative difference of two times, or lengths of time, that is rounding.
ROUNDING = 1e-9
# Two steps from point to point make no pair where their lengths differ by a larger factor. The error of a method of
# first order is the difference to one step of both lengths times 1 for equal lengths, 1.08 at this factor, and 5 at a
# factor of 10.
MAX_RATIO_OF_PAIR = 1.5
# Largest number of increments of a jump in doubled steps, after which its error is taken as it is: of first order, it is
# then a 500th of that of the four increments at first.
MAX_INCREMENTS = 2**11


@dataclass(frozen=True)
class Breakpoint:
    """Point in time at which steps end.

    Attributes
    ----------
    time
        Time [s].
    before, after
        Load [N/m] before and after a jump; equal where the load does not jump, and 0 where the method needs no load.
    times_recorded
        Number of times that the contact is recorded: 0, 1, or 2 for before and after a jump.
    is_discontinuity
        Whether the load, its rate or another history may jump or turn at this instant, so that no step goes over it.
    history_jumps
        Whether another history than that of the load jumps, such as that of a tangential force.
    """

    time: float
    before: float = 0.0
    after: float = 0.0
    times_recorded: int = 0
    is_discontinuity: bool = False
    history_jumps: bool = False

    @property
    def jumps(self) -> bool:
        """True if the load or another history jumps at this instant."""
        return self.before != self.after or self.history_jumps


def schedule(
    load: ChangingLoad,
    times: ArrayLike,
    *,
    turns: Sequence[float] = (),
    history: PiecewiseLinear | None = None,
    longest: float = inf,
) -> tuple[Breakpoint, ...]:
    """Return the points in time at which steps end, from the start of the load to the last recorded time.

    Parameters
    ----------
    load
        Load [N/m] over time.
    times
        Recorded times [s], which do not decrease.
    turns
        Further times [s] at which steps end, such as those where the load turns; those outside the schedule are left
        out.
    history
        Another history, which may have kinks or jump, such as that of a tangential force.
    longest
        Longest time [s] from one point to the next; longer times are divided into equal parts.

    Raises
    ------
    InvalidInput
        If times decrease, begin before the load or name an instant three times.
    """
    recorded: list[float] = np.ravel(times).tolist()
    check_not_decreasing("solve.times", recorded)
    if recorded[0] < load.start:
        raise InvalidInput(
            f"solve.times[0] is {recorded[0]!r}: give times from {load.start!r} s on, when the load begins."
        )
    end, counts = recorded[-1], Counter(recorded)
    further = (*turns, *(history.times if history is not None else ()))
    breaks = {load.start, *load.breaks(end), *(time for time in further if load.start <= time <= end)}
    given = sorted(breaks | set(counts) | {end})
    instants = given[:1]
    for first, last in pairwise(given):
        parts = ceil((last - first) / longest * (1 - ROUNDING))
        instants += [first + (last - first) * part / parts for part in range(1, parts)] + [last]
    return tuple(
        Breakpoint(
            time,
            load.before(time),
            load.at(time),
            counts[time],
            time in breaks,
            history is not None and history.before(time) != history.at(time),
        )
        for time in instants
    )


def ascending(times: ArrayLike, least: int = 1) -> list[float]:
    """Return `times` [s] as a list; raise InvalidInput unless each is later than the last, and `least` are given."""
    instants: list[float] = np.ravel(times).tolist()
    if len(instants) < least or sorted(set(instants)) != instants:
        count = "two or more" if least > 1 else "them"
        raise InvalidInput(f"solve.times is {times!r}: give {count}, ascending.")
    return instants


# Attributes of a contact or film that count as work: iterations of its solver, FFT convolutions of a dry contact, and
# iterations of the linear systems of a film.
WORK = "iterations", "convolutions", "linear_iterations"


@dataclass(frozen=True, eq=False, kw_only=True)
class MarchState:
    """Contact or film at one time, and the step that led to it: all that a march asks of it.

    Attributes
    ----------
    time
        Time [s].
    contacts
        Contacts or films solved in the step, in the order of time; the last one is that at the time. A method that
        solves none until it is asked leaves them out.
    replaced
        Contacts solved in the step and replaced by better ones, whose work counts and whose outcomes do not.
    step_error
        Relative error of the step as its method estimates it; 0 if it does not, infinite if a solve failed.
    """

    time: float
    contacts: tuple[Any, ...] = ()
    replaced: tuple[Any, ...] = ()
    step_error: float = 0.0

    @property
    def statuses(self) -> tuple[Status, ...]:
        """Outcomes of the contacts that were not replaced."""
        return tuple(contact.status for contact in self.contacts)

    @property
    def work(self) -> Counter[str]:
        """Number of ``solves`` in the step, and of their iterations by the names in `WORK`."""
        solved = self.contacts + self.replaced
        counts = {name: sum(getattr(contact, name, 0) for contact in solved) for name in WORK}
        return Counter(counts | {"solves": sum(getattr(contact, "solves", 1) for contact in solved)})


# State of a method, and what it makes of a record.
S = TypeVar("S", bound=MarchState)
R = TypeVar("R")


@dataclass(frozen=True, eq=False)
class Record(Generic[S]):
    """State at an instant that is recorded, and what led there from the record before.

    Attributes
    ----------
    state
        The state after short steps.
    coarse
        The same after doubled steps; None in the middle of one, without them, and where there is no solution.
    statuses
        Outcomes of the solves of accepted steps since the record before.
    work
        Work since the record before, with the number of ``steps``, of ``rejected`` pairs of steps and jumps, and of
        ``restarts``.
    """

    state: S
    coarse: S | None
    statuses: tuple[Status, ...]
    work: Counter[str]


class Method(Generic[S, R]):
    """Method that takes the steps of a march, tells their errors, and makes of a record what the march returns (`R`).

    Attributes
    ----------
    order
        Power of its length with which the error of a pair of steps grows.
    increments
        First number of load increments of a jump in doubled steps, twice as many in short ones; 0 where the path of the
        load does not matter.
    """

    order: ClassVar[int] = 2
    increments: int = 0

    def begin(self, start: S) -> tuple[S, S | None]:
        """Return the states of short and of doubled steps at the start; None in place of the latter takes none."""
        return start, start

    def step(self, state: S, end: float) -> S:
        """Return the state after one step to the time `end` [s], before any jump there."""
        raise NotImplementedError

    def jump(self, state: S, increments: int) -> S:
        """Return the state after the jump of the load at its time, in so many equal increments."""
        raise NotImplementedError

    def error(self, before: tuple[S, S], middle: S, after: tuple[S, S]) -> float:
        """Return the relative error of a pair of steps, from the (short, doubled) states before and after it.

        Here it is the largest :attr:`~MarchState.step_error` of its steps, that of the doubled one as of a short one.
        """
        doubled: float = after[1].step_error / 2**self.order
        return max(middle.step_error, after[0].step_error, doubled)

    def accept(self, before: S, middle: S, after: tuple[S, S | None]) -> float:
        """Take note of a pair of steps or a jump, and return the relative error of all steps; 0 if it is not limited.

        The states are those of short steps before and in the middle, and the (short, doubled) ones after it.
        """
        return 0.0

    def recorded(self, record: Record[S], *, has_failed: bool) -> R:
        """Return what the march returns of a `record`; `has_failed` says that the last step has no solution."""
        raise NotImplementedError


@dataclass(frozen=True)
class Control:
    """Control of the length of pairs of steps by their error.

    How far later steps damp an error is not known in advance: if that of all steps exceeds the allowed one, the march
    starts again with a :meth:`stricter` control.

    Attributes
    ----------
    limit
        Largest error of a pair of steps.
    order
        Power of its length with which the error of a pair of steps grows.
    first, longest
        Length [s] of the first pair of steps, and of any.
    allowed
        Largest error of all steps.
    """

    limit: float
    order: int
    first: float = inf
    longest: float = inf
    allowed: float = inf

    def factor(self, error: float) -> float:
        """Return the factor on the length of the next pair, after one with this `error`."""
        if error <= 0:
            return MAX_FACTOR
        longer: float = SAFETY * (self.limit / error) ** (1 / self.order)
        return min(max(longer, MIN_FACTOR), MAX_FACTOR)

    def stricter(self, excessive: float) -> "Control":
        """Return the control of the next march, after one whose error of all steps is `excessive`.

        The error of a pair grows as its length to the power of the order, and that of all pairs with one power less.
        """
        shorter = min(SAFETY * self.allowed / excessive, MAX_RESTART_FACTOR)
        return replace(self, limit=self.limit * shorter ** (self.order / (self.order - 1)))


@dataclass(eq=False)
class Position(Generic[S]):
    """Position of a march in time, with all that it needs to go on from there.

    Attributes
    ----------
    fine, coarse
        States after short and after doubled steps; None without doubled steps.
    control
        Control of the length of pairs of steps, stricter after each new start; None steps from one point to the next.
    pair_length
        Longest length [s] of the next pair of steps.
    statuses
        Outcomes of the solves of accepted steps since the last record.
    total
        Work since the first start of the march, with that of marches given up.
    recorded_work
        The part of it that records have counted.
    point_index
        Index of the point that comes next.
    """

    fine: S
    coarse: S | None
    control: Control | None
    pair_length: float
    statuses: list[Status]
    total: Counter[str]
    recorded_work: Counter[str] = field(default_factory=Counter)
    point_index: int = 0


@dataclass(eq=False)
class March(Generic[S, R]):
    """March of a method from its start to the last of `points`, beside one with steps twice as long.

    1. Between two points: a pair of steps is rejected, taken, or followed by a new start with a stricter control.
    2. At a point: the state before a jump is recorded, the jump taken, and the state after it recorded.
    3. A step or jump without a solution ends the march, after shorter ones where a control allows them.

    Attributes
    ----------
    method
        Takes the steps.
    start
        State at the first time.
    points
        Instants at which steps end, in the order of time.
    control
        Control of the length of pairs of steps at first; None steps from one point to the next.
    progress
        Called with the time since the start and that of the whole [s] for each accepted step; None calls nothing.
    position
        Where the march stands. It is the start at first; another one is set before :meth:`run`.
    results
        What the method made of the records so far, in the order of time.
    """

    method: Method[S, R]
    start: S
    points: Sequence[Breakpoint]
    control: Control | None
    progress: Callable[[float, float], None] | None = None
    position: Position[S] = field(init=False)
    results: list[R] = field(init=False)

    def __post_init__(self) -> None:
        self.duration = self.points[-1].time - self.start.time
        self._begin(self.control, Counter())

    def _begin(self, control: Control | None, total: Counter[str]) -> None:
        """Go to the start, after the `total` work of marches that were given up, and forget what was recorded."""
        fine, coarse = self.method.begin(self.start)
        length = inf if control is None else min(control.first, control.longest)
        self.position = Position(fine, coarse, control, length, list(self.start.statuses), total + self.start.work)
        self.results = []

    def run(self, save: Callable[[], None] | None = None) -> list[R]:
        """March to the last point, or to a step without a solution, and return what the method made of the records.

        `save` is called wherever a march can go on from :attr:`position`, with nothing left to be recorded at its time.
        """
        if self.position.fine.step_error == inf:
            self._record(self.position.fine, None)
        while self.position.fine.step_error < inf and self.position.point_index < len(self.points):
            if self.position.fine.time < self.points[self.position.point_index].time:
                self._pair(self.points[self.position.point_index])
            point = self.points[self.position.point_index]
            if self.position.fine.time >= point.time and self.position.fine.step_error < inf:
                self._arrive(point)
            if save is not None and self.position.fine.step_error < inf:
                save()
        return self.results

    def _pair(self, point: Breakpoint) -> None:
        """Take a pair of steps towards `point`, unless its error is too large; a single one without doubled steps."""
        here, begin, doubled = self.position, self.position.fine, self.position.coarse
        half, end = self._ends(point)
        middle = self._step(begin, half)
        if self._rejects(middle.step_error, end):
            return
        if middle.step_error == inf or doubled is None:
            self._accept(begin, middle, (middle, doubled), list(middle.statuses))
            return
        statuses, passed = list(middle.statuses), None
        if half == point.time:  # outcomes up to the point in the middle belong to its record
            here.statuses, statuses = here.statuses + statuses, []
            here.point_index += 1
            passed = self._cut(middle, None) if point.times_recorded else None
        after = self._step(middle, end), self._step(doubled, end)
        error = self.method.error((begin, doubled), middle, after)
        if self._rejects(error, end):
            return
        if here.control is not None:
            # a pair cut short by a point is no measure of the allowed length
            longer = (end - begin.time) * here.control.factor(error)
            here.pair_length = min(max(longer, here.pair_length if end == point.time else 0.0), here.control.longest)
        self._accept(begin, middle, after, [*statuses, *after[0].statuses, *after[1].statuses], passed)

    def _ends(self, point: Breakpoint) -> tuple[float, float]:
        """Return the times [s] at which the steps of the next pair towards `point` end."""
        here, now = self.position, self.position.fine.time
        remaining = point.time - now
        if here.control is None:
            if here.coarse is None:
                return point.time, point.time
            if self._begins_pair(point):
                return point.time, self.points[here.point_index + 1].time
            return (now + point.time) / 2, point.time
        if here.pair_length >= remaining * (1 - ROUNDING):
            return now + remaining / 2, point.time
        pair = min(here.pair_length, remaining / 2)
        return now + pair / 2, now + pair

    def _begins_pair(self, point: Breakpoint) -> bool:
        """Return whether a step to `point` makes a pair with the one after it; if not, two steps lead to it."""
        if point is self.points[-1] or point.is_discontinuity or point.times_recorded == 2:
            return False
        after = self.points[self.position.point_index + 1]
        ratio = (after.time - point.time) / (point.time - self.position.fine.time)
        # without load both integrations have the same pressure, and their difference would show no error
        return after.before != 0 and max(ratio, 1 / ratio) <= MAX_RATIO_OF_PAIR

    def _step(self, state: S, end: float) -> S:
        """Return the state after a step to `end` [s], whose work counts whether it is accepted or not."""
        after = self.method.step(state, end)
        self.position.total.update(after.work)
        return after

    def _rejects(self, error: float, end: float) -> bool:
        """Return whether the pair of steps to `end` [s] is too long for its `error`; the next one is then shorter."""
        here, pair = self.position, end - self.position.fine.time
        shortest = SHORTEST if error < inf else SHORTEST_WITHOUT_SOLUTION
        if here.control is None or error <= here.control.limit or pair <= shortest * self.duration:
            return False
        here.total["rejected"] += 1
        here.pair_length = pair * min(here.control.factor(error), MAX_REJECTED_FACTOR)
        return True

    def _accept(
        self, begin: S, middle: S, after: tuple[S, S | None], statuses: list[Status], passed: Record[S] | None = None
    ) -> None:
        """Continue from the states `after` a pair of steps, or start again where the error of all is too large.

        The record `passed` is that of a point in the middle, if there is one. Without doubled steps, and where the first
        step has no solution, `middle` is the state after it.
        """
        here, fine = self.position, after[0]
        here.fine, here.coarse = after
        here.statuses += statuses
        steps = [fine] if fine is middle else [middle, fine]
        if fine.step_error < inf:
            here.total["steps"] += len(steps)
            error = self.method.accept(begin, middle, after)
            if here.control is not None and error > here.control.allowed:
                here.total["restarts"] += 1
                self._begin(here.control.stricter(error), here.total)
                return
        if passed is not None:
            self.results.append(self.method.recorded(passed, has_failed=fine.step_error == inf))
        if fine.step_error == inf:
            self._record(fine, None)
        elif self.progress is not None:
            for state in steps:
                self.progress(state.time - self.start.time, self.duration)

    def _arrive(self, point: Breakpoint) -> None:
        """Record the state at a `point`, before and after a jump there, and go on to the next point."""
        here = self.position
        if point.times_recorded == 2:
            self._record(here.fine, here.coarse)
        if point.jumps:
            self._jump()
        here.point_index += 1
        if here.fine.step_error == inf:
            self._record(here.fine, None)
        elif point.times_recorded:
            self._record(here.fine, here.coarse)

    def _jump(self) -> None:
        """Take a jump at the present time in as many increments as the error of a pair allows."""
        here, begin, doubled = self.position, self.position.fine, self.position.coarse
        increments, limit = self.method.increments, here.control.limit if here.control else inf
        while True:
            fine, coarse = self.method.jump(begin, max(2 * increments, 1)), doubled
            here.total.update(fine.work)
            if fine.step_error == inf or doubled is None:
                break
            coarse = self.method.jump(doubled, max(increments, 1))
            here.total.update(coarse.work)
            error = self.method.error((begin, doubled), fine, (fine, coarse))
            if not increments or error <= limit or increments >= MAX_INCREMENTS:
                break
            here.total["rejected"] += 1
            increments *= 2
        here.fine, here.coarse = fine, coarse
        here.statuses += fine.statuses
        if coarse is not None and coarse is not doubled:
            here.statuses += coarse.statuses
        if fine.step_error < inf:
            self.method.accept(begin, fine, (fine, coarse))

    def _cut(self, state: S, coarse: S | None) -> Record[S]:
        """Return the record of a `state` and its `coarse` one, with outcomes and work since the record before.

        Outcomes and work are then counted anew.
        """
        here = self.position
        record = Record(state, coarse, tuple(here.statuses), here.total - here.recorded_work)
        here.statuses, here.recorded_work = [], Counter(here.total)
        return record

    def _record(self, state: S, coarse: S | None) -> None:
        """Add to the results what the method makes of the record of a `state` and its `coarse` one."""
        record = self._cut(state, coarse)
        self.results.append(self.method.recorded(record, has_failed=self.position.fine.step_error == inf))

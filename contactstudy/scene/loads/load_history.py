"""Loads that change in time."""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from itertools import pairwise
from math import asin, ceil, floor, pi, sin
from typing import Annotated, ClassVar, Protocol, runtime_checkable

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.units import NewtonsPerMetre, PerSecond, Radians, Seconds
from contactstudy.domain.validation import ANY_SIGN, AT_LEAST_ZERO, FINITE, valid, validated
from contactstudy.scene.solids.bodies import SceneContext

# Loads that press the bodies together.
LOADS = tuple[Annotated[NewtonsPerMetre, AT_LEAST_ZERO], ...]
# Load over the largest one below which it is zero: its rounding error.
ZERO_LOAD = 1e-13


@runtime_checkable
class ChangingLoad(Protocol):
    """Load per length [N/m] as a function of time [s]; it is zero before its start.

    A load that repeats also has an attribute ``period`` [s], of which no step in time takes more than a quarter.
    """

    @property
    def largest(self) -> float:
        """Largest load [N/m], above zero."""

    @property
    def start(self) -> float:
        """First time [s] that the history describes."""

    @property
    def end(self) -> float:
        """Last time [s] that the history describes."""

    def at(self, time: float) -> float:
        """Return the load [N/m] from `time` [s] on, after any jump there."""

    def breaks(self, end: float) -> tuple[float, ...]:
        """Return the times [s] up to `end` at which the load or its rate jumps."""

    def turning_points(self, end: float) -> tuple[float, ...]:
        """Return times [s] up to `end` between which the load only rises or only falls, its extremes among them."""

    def before(self, time: float) -> float:
        """Return the load [N/m] just before `time` [s], before any jump there."""

    def mean(self, start: float, end: float) -> float:
        """Return the mean load [N/m] between two times [s] without a break between them."""


def loads_between(load: ChangingLoad, start: float, end: float) -> list[float]:
    """Return the loads [N/m] between which `load` only rises or falls, from after `start` to just before `end` [s]."""
    turns = (time for time in load.turning_points(end) if start < time < end)
    return [value for time in turns for value in (load.before(time), load.at(time))] + [load.before(end)]


def falls(load: ChangingLoad) -> bool:
    """Return whether `load` falls at any time up to its end."""
    values = [load.at(load.start), *loads_between(load, load.start, load.end)]
    return any(later < earlier for earlier, later in pairwise([*values, load.at(load.end)]))


class PiecewiseLinear:
    """Values at `times` [s], which may jump there: linear between them, zero before the first, held after the last.

    Subclasses name their `values`, one for each instant.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]

    @property
    def start(self) -> float:
        """First time [s]."""
        return self.times[0]

    @property
    def end(self) -> float:
        """Last time [s], after which the last value is held."""
        return self.times[-1]

    def breaks(self, end: float) -> tuple[float, ...]:
        """Return the instants [s] up to `end`."""
        return tuple(sorted({time for time in self.times if time <= end}))

    def turning_points(self, end: float) -> tuple[float, ...]:
        """Return the instants [s] up to `end`, between which the values only rise or only fall."""
        return self.breaks(end)

    def before(self, time: float) -> float:
        """Return the value just before `time` [s]; zero up to the first instant."""
        return self._between(bisect_left(self.times, time), time)

    def at(self, time: float) -> float:
        """Return the value from `time` [s] on; zero before the first instant."""
        return self._between(bisect_right(self.times, time), time)

    def _between(self, index: int, time: float) -> float:
        """Return the value at `time` [s], after `index` instants."""
        if index == 0:
            return 0.0
        if index == len(self.times):
            return self.values[-1]
        t0, t1 = self.times[index - 1 : index + 1]
        p0, p1 = self.values[index - 1 : index + 1]
        weight = (time - t0) / (t1 - t0)
        return p0 * (1 - weight) + p1 * weight

    def mean(self, start: float, end: float) -> float:
        """Return the mean value between two times [s] without a break between them."""
        return (self.at(start) + self.before(end)) / 2


Times = tuple[Annotated[Seconds, FINITE], ...]


def check_not_decreasing(name: str, times: Sequence[float]) -> None:
    """Raise :class:`~contactstudy.InvalidInput` for `times` [s], of this `name`, that decrease, or stand three times."""
    for number, (before, after) in enumerate(pairwise(times), start=1):
        if after < before or times[max(number - 2, 0) : number + 1].count(after) > 2:
            raise InvalidInput(
                f"{name}[{number}] is {after!r}: give times that do not decrease, the same one twice at the most."
            )


@validated
class LoadHistory(PiecewiseLinear):
    """Load given at instants, linear between them and held after the last.

    Parameters
    ----------
    times
        Instants [s] that do not decrease; an instant given twice is a jump.
    per_length
        Load [N/m] at each instant, at least zero, at least one of them above zero. A first load above zero is
        applied suddenly. Together with :class:`~contactstudy.Adhesion` loads may pull.

    Raises
    ------
    InvalidInput
        If there is not one load for each time, a time decreases or stands more than twice, or no load is above zero;
        in a scene without adhesion, if one is below zero.
    """

    times: Times
    per_length: tuple[Annotated[NewtonsPerMetre, ANY_SIGN], ...]

    def check_together(self) -> None:
        """Check that times do not decrease, with a load for each, one of them above 0."""
        check_not_decreasing("LoadHistory.times", self.times)
        loads = self.per_length
        if len(self.times) != len(loads) or not loads:
            raise InvalidInput(
                f"LoadHistory.per_length has {len(loads)} loads for {len(self.times)} times: give at least one time, "
                "and one load for each."
            )
        if max(loads) <= 0:
            throughout = "0" if max(loads) == min(loads) == 0 else "not above 0"
            raise InvalidInput(f"LoadHistory.per_length is {throughout} throughout: give a load above 0 N/m.")

    @property
    def values(self) -> tuple[float, ...]:  # type: ignore[override]
        """Load [N/m] at each instant."""
        return self.per_length

    @property
    def largest(self) -> float:
        """Largest load [N/m]."""
        return max(self.per_length)

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if a load pulls the bodies apart without adhesion."""
        if scene.adhesion is None:
            valid("LoadHistory.per_length", self.per_length, LOADS)


@validated
class SineLoad:
    """Sinusoidal load ``mean_load + amplitude sin(2 pi frequency t + phase)`` from t = 0 on, cut off at zero.

    Parameters
    ----------
    mean_load, amplitude
        Loads [N/m], at least zero, not both zero. A load above zero at t = 0 is applied suddenly.
    frequency
        Cycles per second [Hz], above zero.
    phase
        Angle at t = 0 [rad].

    Raises
    ------
    InvalidInput
        If a number is outside these limits.
    """

    #: Start of the load [s].
    start: ClassVar[float] = 0.0

    mean_load: Annotated[NewtonsPerMetre, AT_LEAST_ZERO]
    amplitude: Annotated[NewtonsPerMetre, AT_LEAST_ZERO]
    frequency: PerSecond
    phase: Annotated[Radians, FINITE] = 0.0

    def check_together(self) -> None:
        """Check that there is a load."""
        if self.mean_load == self.amplitude == 0:
            raise InvalidInput("SineLoad.amplitude and mean_load are 0: give a load above 0 N/m.")

    @property
    def largest(self) -> float:
        """Largest load [N/m]."""
        return self.mean_load + self.amplitude

    @property
    def period(self) -> float:
        """Duration of one cycle [s]."""
        return 1 / self.frequency

    @property
    def end(self) -> float:
        """Duration of one cycle [s]; the load continues after it."""
        return self.period

    def breaks(self, end: float) -> tuple[float, ...]:
        """Return the times [s] up to `end` at which the load starts, reaches zero or rises from it."""
        if self.amplitude <= self.mean_load:
            return (0.0,)
        crossing = asin(self.mean_load / self.amplitude)
        return self._times_at((-crossing, pi + crossing), end)

    def turning_points(self, end: float) -> tuple[float, ...]:
        """Return the :meth:`breaks` and the times [s] up to `end` at which the load turns."""
        extremes = (pi / 2, -pi / 2) if self.amplitude <= self.mean_load else (pi / 2,)
        return tuple(sorted({*self.breaks(end), *self._times_at(extremes, end)}))

    def _times_at(self, angles: tuple[float, ...], end: float) -> tuple[float, ...]:
        """Return 0 and the times [s] up to `end` at which the sine is at one of `angles` [rad] of a cycle."""
        times = {0.0}
        for angle in angles:
            first = ceil((self.phase - angle) / (2 * pi))
            last = floor((self._angle(end) - angle) / (2 * pi))
            for cycle in range(first, last + 1):
                time = (angle + 2 * pi * cycle - self.phase) / (2 * pi * self.frequency)
                times.add(min(max(time, 0.0), end))
        return tuple(sorted(times))

    def before(self, time: float) -> float:
        """Return the load [N/m] just before `time` [s]; zero up to t = 0."""
        return self.at(time) if time > 0 else 0.0

    def at(self, time: float) -> float:
        """Return the load [N/m] from `time` [s] on."""
        if time < 0:
            return 0.0
        load = self.mean_load + self.amplitude * sin(self._angle(time))
        # a load that should be zero has a rounding error
        return load if load > ZERO_LOAD * self.largest else 0.0

    def mean(self, start: float, end: float) -> float:
        """Return the mean load [N/m] between two times [s] without a break between them."""
        if end == start or self.at((start + end) / 2) == 0:
            return self.at((start + end) / 2)
        # the difference of two cosines without cancellation
        middle = self._angle((start + end) / 2)
        half = pi * self.frequency * (end - start)
        return self.mean_load + self.amplitude * sin(middle) * sin(half) / half

    def _angle(self, time: float) -> float:
        """Return the angle of the sine [rad] at a `time` [s]."""
        return 2 * pi * self.frequency * time + self.phase

"""The load that presses the bodies together: constant, or changing in time."""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from itertools import pairwise
from math import asin, ceil, floor, pi, sin
from typing import Protocol, runtime_checkable

from contactstudy.domain.checks import (
    InvalidInput,
    finite,
    in_range,
    in_range_from_zero,
    set_fields,
)
from contactstudy.domain.units import Hertz, NewtonsPerMetre, Radians, Seconds


@dataclass(frozen=True)
class LineLoad:
    """A normal load ``per_length`` [N/m] of contact length, above zero."""

    per_length: NewtonsPerMetre

    def __post_init__(self) -> None:
        load = in_range("LineLoad.per_length", self.per_length, "give a load above 0 N/m")
        set_fields(self, per_length=load)

    @property
    def largest(self) -> float:
        """The load [N/m], as of one that changes."""
        return self.per_length


# What a load that should be zero comes out as, over the largest.
ROUNDING = 1e-13


@runtime_checkable
class ChangingLoad(Protocol):
    """A load [N/m] at every time [s]."""

    @property
    def largest(self) -> float:
        """The largest load [N/m]."""
        ...

    @property
    def start(self) -> float:
        """The first time [s]; there is no load before."""
        ...

    @property
    def end(self) -> float:
        """The last time [s] that it speaks of."""
        ...

    def breaks(self, end: float) -> tuple[float, ...]:
        """Times [s] up to ``end`` at which the load jumps or its rate does."""
        ...

    def before(self, time: float) -> float:
        """The load [N/m] up to ``time`` [s], before any jump there."""
        ...

    def at(self, time: float) -> float:
        """The load [N/m] from ``time`` [s] on, after any jump there."""
        ...

    def mean(self, start: float, end: float) -> float:
        """The mean load [N/m] over a time without a break inside."""
        ...


@dataclass(frozen=True)
class LoadHistory:
    """A normal load ``per_length`` [N/m] at ``times`` [s], linear between them, held after the last.

    Times do not decrease; one given twice is a jump. Loads are from 0 N/m on, one of them above. A first load
    above zero is applied suddenly.
    Raises :class:`~contactstudy.InvalidInput` for anything else.
    """

    times: tuple[Seconds, ...]
    per_length: tuple[NewtonsPerMetre, ...]

    def __post_init__(self) -> None:
        checked: dict[str, tuple[float, ...]] = {}
        for name, remedy in (
            ("times", "give a time [s]"),
            ("per_length", "give a load from 0 N/m on"),
        ):
            values = getattr(self, name)
            if not isinstance(values, tuple | list) or not values:
                raise InvalidInput(
                    f"LoadHistory.{name} is {values!r}: give a tuple of numbers, one for each instant."
                )
            check = finite if name == "times" else in_range_from_zero
            checked[name] = tuple(
                check(f"LoadHistory.{name}[{number}]", value, remedy)
                for number, value in enumerate(values)
            )
        times, loads = checked["times"], checked["per_length"]
        if len(times) != len(loads):
            raise InvalidInput(
                f"LoadHistory.per_length has {len(loads)} loads for {len(times)} times: give one for each."
            )
        for number, (before, after) in enumerate(pairwise(times), start=1):
            if after < before or times.count(after) > 2:
                raise InvalidInput(
                    f"LoadHistory.times[{number}] is {after!r}: give times that do not decrease, the same one "
                    "twice at the most."
                )
        if max(loads) == 0:
            raise InvalidInput("LoadHistory.per_length is 0 throughout: give a load above 0 N/m.")
        set_fields(self, times=times, per_length=loads)

    @property
    def largest(self) -> float:
        """The largest load [N/m]."""
        return max(self.per_length)

    @property
    def start(self) -> float:
        """The first time [s]."""
        return self.times[0]

    @property
    def end(self) -> float:
        """The last time [s], after which the load is held."""
        return self.times[-1]

    def breaks(self, end: float) -> tuple[float, ...]:
        """Times [s] up to ``end`` at which the load jumps or its rate does."""
        return tuple(sorted({time for time in self.times if time <= end}))

    def before(self, time: float) -> float:
        """The load [N/m] up to ``time`` [s], before any jump there; zero before the first time."""
        place = bisect_left(self.times, time)
        if place == 0:
            return 0.0
        return self._between(place, time)

    def at(self, time: float) -> float:
        """The load [N/m] from ``time`` [s] on, after any jump there."""
        place = bisect_right(self.times, time)
        if place == 0:
            return 0.0
        return self._between(place, time)

    def _between(self, place: int, time: float) -> float:
        if place == len(self.times):
            return self.per_length[-1]
        (t0, t1), (p0, p1) = (
            self.times[place - 1 : place + 1],
            self.per_length[place - 1 : place + 1],
        )
        share = (time - t0) / (t1 - t0)
        return p0 * (1 - share) + p1 * share

    def mean(self, start: float, end: float) -> float:
        """The mean load [N/m] over a time without a break inside."""
        return (self.at(start) + self.before(end)) / 2


@dataclass(frozen=True)
class SineLoad:
    """``mean_load + amplitude sin(2 pi frequency t + phase)`` [N/m] from time 0 s on, and 0 where that is negative.

    ``mean_load`` and ``amplitude`` from 0 N/m on, not both zero; ``frequency`` [Hz]; ``phase`` [rad].
    A load above zero at t = 0 is applied suddenly.
    Raises :class:`~contactstudy.InvalidInput` for anything else.
    """

    mean_load: NewtonsPerMetre
    amplitude: NewtonsPerMetre
    frequency: Hertz
    phase: Radians = 0.0

    def __post_init__(self) -> None:
        remedy = "give a load from 0 N/m on"
        mean = in_range_from_zero("SineLoad.mean_load", self.mean_load, remedy)
        amplitude = in_range_from_zero("SineLoad.amplitude", self.amplitude, remedy)
        if mean == amplitude == 0:
            raise InvalidInput("SineLoad.amplitude and mean_load are 0: give a load above 0 N/m.")
        frequency = in_range("SineLoad.frequency", self.frequency, "give a frequency above 0 Hz")
        phase = finite("SineLoad.phase", self.phase, "give an angle [rad]")
        set_fields(self, mean_load=mean, amplitude=amplitude, frequency=frequency, phase=phase)

    @property
    def largest(self) -> float:
        """The largest load [N/m]."""
        return self.mean_load + self.amplitude

    @property
    def start(self) -> float:
        """0 s."""
        return 0.0

    @property
    def end(self) -> float:
        """One cycle [s]; the load goes on after it."""
        return 1 / self.frequency

    def breaks(self, end: float) -> tuple[float, ...]:
        """Times [s] up to ``end`` at which the load starts, reaches zero or leaves it."""
        times = {0.0}
        if self.amplitude > self.mean_load:
            reach = asin(self.mean_load / self.amplitude)
            for angle in (-reach, pi + reach):
                first = ceil((self.phase - angle) / (2 * pi))
                last = floor((self._angle(end) - angle) / (2 * pi))
                for turn in range(first, last + 1):
                    time = (angle + 2 * pi * turn - self.phase) / (2 * pi * self.frequency)
                    times.add(min(max(time, 0.0), end))
        return tuple(sorted(times))

    def before(self, time: float) -> float:
        """The load [N/m] up to ``time`` [s]; zero before the first."""
        return self.at(time) if time > 0 else 0.0

    def at(self, time: float) -> float:
        """The load [N/m] from ``time`` [s] on."""
        if time < 0:
            return 0.0
        load = self.mean_load + self.amplitude * sin(self._angle(time))
        # a zero is met to rounding
        return load if load > ROUNDING * self.largest else 0.0

    def mean(self, start: float, end: float) -> float:
        """The mean load [N/m] over a time without a break inside."""
        if end == start or self.at((start + end) / 2) == 0:
            return self.at((start + end) / 2)
        # the difference of two cosines without cancellation
        middle = self._angle((start + end) / 2)
        half = pi * self.frequency * (end - start)
        return self.mean_load + self.amplitude * sin(middle) * sin(half) / half

    def _angle(self, time: float) -> float:
        return 2 * pi * self.frequency * time + self.phase


@dataclass(frozen=True)
class SuddenLoad:
    """``per_length`` [N/m] applied suddenly at ``start`` [s] and held."""

    per_length: float
    start: float

    @property
    def largest(self) -> float:
        """The load."""
        return self.per_length

    @property
    def end(self) -> float:
        """Its start: it says of no time that it is the last."""
        return self.start

    def breaks(self, end: float) -> tuple[float, ...]:
        """The start."""
        return (self.start,)

    def before(self, time: float) -> float:
        """The load [N/m] up to ``time`` [s]."""
        return self.per_length if time > self.start else 0.0

    def at(self, time: float) -> float:
        """The load [N/m] from ``time`` [s] on."""
        return self.per_length if time >= self.start else 0.0

    def mean(self, start: float, end: float) -> float:
        """The load [N/m]."""
        return self.per_length

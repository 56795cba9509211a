"""Loads that press the bodies together, constant or in time, and what may be given in place: an approach, a pull-off."""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from itertools import pairwise
from math import asin, ceil, e, exp, isclose, pi, sin, sqrt
from typing import Annotated, ClassVar

import numpy as np

from contactstudy.domain import validation
from contactstudy.domain.grid import Array, Grid, Paddings
from contactstudy.domain.validation import InvalidInput, readable, valid, validated
from contactstudy.scene.solids.bodies import SceneContext


@validated
class LineLoad:
    """Constant normal load per length of the contact.

    Parameters
    ----------
    per_length
        Load [N/m], above zero; together with :class:`~contactstudy.Adhesion` of any sign. The length is that of the
        roller, or of the grid if the roller has no ends.

    Raises
    ------
    InvalidInput
        If the load is no finite number; in a scene without adhesion, if it is not above zero.
    """

    per_length: Annotated[validation.NewtonsPerMetre, validation.ANY_SIGN]

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` unless the load, or an attraction, presses the bodies together."""
        if scene.adhesion is None:
            valid("LineLoad.per_length", self.per_length, validation.NewtonsPerMetre)

    @property
    def largest(self) -> float:
        """Load [N/m], which is its own maximum."""
        return self.per_length


@validated
class TotalLoad:
    """Constant normal load on the whole length of a roller.

    Parameters
    ----------
    total
        Load [N], above zero; together with :class:`~contactstudy.Adhesion` of any sign.
    length
        Length of the roller [m], over which the load is spread in Hertz's values. None takes that of the shortest
        roller among the shapes, such as a :class:`~contactstudy.LundbergProfile` or :class:`~contactstudy.FiniteLength`.
        A point contact, of a :class:`~contactstudy.Sphere` or an :class:`~contactstudy.Ellipsoid`, needs none.

    Raises
    ------
    InvalidInput
        If the load is no finite number or the length is not above zero; in a scene, if no shape has a length and there
        is none here, if both differ, or if the load is not above zero and there is no adhesion.
    """

    total: Annotated[validation.Newtons, validation.ANY_SIGN]
    length: validation.Metres | None = None

    def length_on(self, shortest: float | None) -> float:
        """Return the length of the roller [m]: that given, or else that of the `shortest` roller among the shapes."""
        length = self.length or shortest
        if length is None:
            raise InvalidInput(
                "Scene.load is a TotalLoad, and no shape has the length of a roller: give TotalLoad.length [m], a "
                "FiniteLength among the shapes, or for a point contact shapes that are convex both ways, such as Sphere "
                "or Ellipsoid."
            )
        if not isclose(length, shortest or length):
            raise InvalidInput(
                f"TotalLoad.length is {length!r}, and the shortest roller among the shapes is {shortest!r} m long: "
                "leave it out, or give the shapes that length."
            )
        return length

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the load pulls without adhesion, or there is no length."""
        if scene.adhesion is None:
            valid("TotalLoad.total", self.total, validation.Newtons)
        _ = scene.roller_length


ConstantLoad = LineLoad | TotalLoad

# Distance from the axis at which the surface does not move, over the equivalent radius, where none is given: about the
# size of a roller, beyond which the half-space does not stand for it.
DATUM_OVER_RADIUS = 2.0


@validated
class Approach:
    """Approach of the bodies, given in place of a load: the load is a result.

    It is relative to the undeformed gap, which is 0 m at the axis of a cylinder. Under a line load the approach grows
    without limit with the distance of the reference point, so that it is defined only together with a `datum`. A larger
    datum is a softer spring in series with the contact.

    Parameters
    ----------
    approach
        Approach [m], of any sign.
    datum
        Distance from the axis at which the surface does not move [m], at least half the width of the grid; None is twice
        the equivalent radius, from which every approach under a given load counts too, and the width of the grid without
        a curved shape. It is for a contact of which one axis alone has infinitely many images.

    Raises
    ------
    InvalidInput
        If a number is not finite, or the datum is not above 0 m; on a grid that is more than twice as wide as the datum,
        or with one where no axis or both have infinitely many images; with ExactPeriodicity along both axes, if the
        approach is not below the mean undeformed gap.
    """

    #: Largest given load [N/m]: none is given.
    largest: ClassVar[float] = 0.0

    approach: Annotated[validation.Metres, validation.ANY_SIGN]
    datum: validation.Metres | None = None

    def check_on(self, gap: Array, grid: Grid, paddings: Paddings, datum: float) -> None:
        """Raise InvalidInput for a given datum without an effect, one too near, and an approach that no pressure makes.

        The `gap` (x, y) [m] is undeformed, the `datum` [m] the one in use.
        """
        endless = sum(each.window is None for each in paddings)
        if self.datum is not None and endless != 1:
            raise InvalidInput(
                f"Approach.datum is {self.datum!r}, and {endless} axes have infinitely many images, so that it has "
                "no effect: leave it out, or give ExactPeriodicity along one axis."
            )
        if endless and datum < grid.extent[0] / 2:
            in_use = f"None, which takes {readable(datum)}" if self.datum is None else repr(self.datum)
            raise InvalidInput(
                f"Approach.datum is {in_use}: give at least half the width of the grid, "
                f"{readable(grid.extent[0] / 2)}, or parts of the surface would rise under pressure."
            )
        # displacements count from their mean, so that the approach lowers the mean gap, to zero in full contact
        mean, rounding = float(gap.mean()), 4 * float(np.finfo(gap.dtype).eps * np.abs(gap).max())
        if endless == 2 and self.approach >= mean - rounding:
            raise InvalidInput(
                f"Scene.load is {self!r} with ExactPeriodicity along both axes, where displacements count from their "
                f"mean and no pressure brings the bodies closer than their mean undeformed gap of {readable(mean)}: "
                "give a smaller approach, or a LineLoad."
            )

    def estimated_half_width(self, radius: float) -> float:
        """Return the half-width a [m] of a smooth cylinder of a `radius` R [m] at this approach; 0 if it does not touch.

        ``approach = u (2 ln(2 datum / a) + 1)`` with ``u = a^2 / (4 R)``, Johnson (1985), sect. 5.6, solved by Lambert's
        function for the term with the logarithm. From the largest approach, ``datum^2 / R``, on it is ``2 datum``.
        """
        if self.approach <= 0:
            return 0.0
        from scipy.special import lambertw  # imported late, since it is slow

        largest = (self.datum or DATUM_OVER_RADIUS * radius) ** 2 / radius
        log_term = -lambertw(-min(self.approach / largest, 1.0) / e, -1).real
        return float(sqrt(4 * radius * largest * exp(1 - log_term)))


@validated
class PullOff:
    """Separation of an adhesive contact, in place of a load: the pull-off load is a result.

    The contact is loaded to `preload` and then unloaded. The load at which it separates is found by bisection; each
    trial starts from the last state in equilibrium.

    Parameters
    ----------
    preload
        Load [N/m] from which the bodies are pulled apart, of any sign; above 0 for bodies that come from afar.
    error
        Difference of the last load in equilibrium and the first without, over the latter.

    Raises
    ------
    InvalidInput
        If the load is no finite number, or the error not between 1e-6 and 1; in a scene without adhesion.
    """

    preload: Annotated[validation.NewtonsPerMetre, validation.ANY_SIGN]
    error: Annotated[validation.Number, validation.Limits("from 1e-6 and below 1", lambda x: 1e-6 <= x < 1)] = 4e-3

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for a `scene` without adhesion."""
        if scene.adhesion is None:
            raise InvalidInput(
                "Scene.load is a PullOff without adhesion: give Scene.adhesion, such as Adhesion(work=0.05)."
            )

    @property
    def largest(self) -> float:
        """Load [N/m] from which the bodies are pulled apart."""
        return self.preload


# Load over the largest one below which it is zero: its rounding error.
ZERO_LOAD = 1e-13


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
        """Last time [s], after which the last value is only held."""
        return self.times[-1]

    def breaks(self, end: float) -> tuple[float, ...]:
        """Return the instants [s] up to `end`, between which the values only rise or only fall."""
        return tuple(sorted({time for time in self.times if time <= end}))

    turning_points = breaks

    def before(self, time: float) -> float:
        """Return the value just before `time` [s]; zero up to the first instant."""
        return self._between(bisect_left(self.times, time), time)

    def at(self, time: float) -> float:
        """Return the value from `time` [s] on; zero before the first instant."""
        return self._between(bisect_right(self.times, time), time)

    def _between(self, count: int, time: float) -> float:
        """Return the value at `time` [s], before which there are `count` instants."""
        if count == 0:
            return 0.0
        if count == len(self.times):
            return self.values[-1]
        start, end = self.times[count - 1 : count + 1]
        first, last = self.values[count - 1 : count + 1]
        weight = (time - start) / (end - start)
        return first * (1 - weight) + last * weight

    def mean(self, start: float, end: float) -> float:
        """Return the mean value between two times [s] without a break between them."""
        return (self.at(start) + self.before(end)) / 2


# Instants [s] of a history.
Times = tuple[Annotated[validation.Seconds, validation.FINITE], ...]


def check_not_decreasing(name: str, times: Sequence[float]) -> None:
    """Raise :class:`~contactstudy.InvalidInput` for `times` [s] that decrease, or one of which stands three times.

    The message calls them by their `name`.
    """
    for number, (before, after) in enumerate(pairwise(times), start=1):
        if after < before or times[max(number - 2, 0) : number + 1].count(after) > 2:
            raise InvalidInput(
                f"{name}[{number}] is {after!r}: give times that do not decrease, the same one twice at the most."
            )


def check_one_each(name: str, values: Sequence[float], beside: str, others: Sequence[float], least: int = 1) -> None:
    """Raise :class:`~contactstudy.InvalidInput` unless there is one value for each of the `others`, and enough.

    The message calls the values by their `name` and the others by the word `beside`; `least` is the fewest.
    """
    if len(values) != len(others) or len(values) < least:
        raise InvalidInput(
            f"{name} has length {len(values)} beside {len(others)} {beside}: give one for each, and at least {least}."
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
    per_length: tuple[Annotated[validation.NewtonsPerMetre, validation.ANY_SIGN], ...]

    def check_together(self) -> None:
        """Check that times do not decrease, with a load for each, one of them above 0."""
        loads = self.per_length
        check_not_decreasing("LoadHistory.times", self.times)
        check_one_each("LoadHistory.per_length", loads, "times", self.times)
        if max(loads) <= 0:
            raise InvalidInput(f"LoadHistory.per_length is {loads!r}: give a load above 0 N/m.")

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
            pressing = tuple[Annotated[validation.NewtonsPerMetre, validation.AT_LEAST_ZERO], ...]
            valid("LoadHistory.per_length", self.per_length, pressing)


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

    mean_load: Annotated[validation.NewtonsPerMetre, validation.AT_LEAST_ZERO]
    amplitude: Annotated[validation.NewtonsPerMetre, validation.AT_LEAST_ZERO]
    frequency: validation.Frequency
    phase: Annotated[validation.Radians, validation.FINITE] = 0.0

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

    #: Time [s] after which the load only repeats, one cycle.
    end = period

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
        cycles = np.arange(ceil(self.frequency * end) + 1)
        first = (np.array(angles) - self.phase) % (2 * pi)  # from the angle at t = 0
        times = (first[:, None] + 2 * pi * cycles) / (2 * pi * self.frequency)
        return tuple(sorted({0.0, *times[times <= end].tolist()}))

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


# Load per length [N/m] as a function of time [s], zero before its start. What repeats has a `period` [s].
ChangingLoad = LoadHistory | SineLoad


def loads_between(load: ChangingLoad, start: float, end: float) -> list[float]:
    """Return the loads [N/m] between which `load` only rises or falls, from after `start` to just before `end` [s]."""
    turns = (time for time in load.turning_points(end) if start < time < end)
    return [value for time in turns for value in (load.before(time), load.at(time))] + [load.before(end)]


def turning_values(load: ChangingLoad) -> list[float]:
    """Return the loads [N/m] between which `load` only rises or falls, up to its end; from there it repeats or stays."""
    return [load.at(load.start), *loads_between(load, load.start, load.end), load.at(load.end)]


def falls(load: ChangingLoad) -> bool:
    """Return whether `load` falls at any time."""
    return any(later < earlier for earlier, later in pairwise(turning_values(load)))

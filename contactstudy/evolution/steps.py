"""Steps in time: the stages of a scheme, the instants that steps end at, and the control of their length."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise
from math import ceil, inf, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.checks import (
    InvalidInput,
    checked_relative_error,
    suggest_fields,
    whole_number,
)
from contactstudy.domain.units import Number, Seconds
from contactstudy.scene.load import ChangingLoad

# Recorded instants of a history where none are named.
DEFAULT_INSTANTS = 41
# gamma of the L-stable two-stage SDIRK scheme of order 2.
SDIRK_GAMMA = 1 - 1 / sqrt(2)


class Scheme(Enum):
    """Stages of a step: for each, its fraction of the duration, and the fraction of the stage that is explicit.

    The scheme matters to wear only; creep is exact for a pressure that is linear in each stage. Every scheme keeps the
    worn volume.
    """

    #: Second order, L-stable, two solves.
    #: Source: Alexander (1977), SIAM J. Numer. Anal. 14, sect. 3.
    TWO_STAGE = ((SDIRK_GAMMA, 0.0), (1 - SDIRK_GAMMA, (1 - 2 * SDIRK_GAMMA) / (1 - SDIRK_GAMMA)))
    #: Backward Euler: first order, L-stable, one solve.
    IMPLICIT = ((1.0, 0.0),)
    #: Forward Euler: first order, unstable beyond
    #: :func:`~contactstudy.evolution.state_variables.explicit_limit`: for comparison.
    EXPLICIT = ((1.0, 1.0),)

    @property
    def stages(self) -> tuple[tuple[float, float], ...]:
        """Pairs (fraction of the duration, explicit fraction of the stage), in the order of time."""
        stages: tuple[tuple[float, float], ...] = self.value
        return stages


class StepError(Enum):
    """Choice of how the error by the steps in time is estimated."""

    #: By step doubling: a second integration with steps twice as long, at half the cost of the first.
    STEP_DOUBLING = "step doubling"
    #: No estimate: the error is infinite.
    NONE = "none"


@suggest_fields
@dataclass(frozen=True)
class TimeSteps:
    """Instants to record of a scene that changes in time, and how steps between them are taken.

    Parameters
    ----------
    times
        The instants [s], which do not decrease; None for evenly spaced ones. A time given twice is recorded before and
        after a jump of the load.
    end
        Last instant [s], that of the load and the speed if None.
    instants
        Number of instants, evenly spaced but for those moved to where a history bends; None for 41, or for every step
        where `error` is given.
    error
        Largest relative L1 error by the steps (of a film: of its thickness in one step). None takes a fraction of the
        error requested of the solve; without one, one step from each instant to the next.
    scheme
        How wear is stepped.
    step_error
        How the error by the steps of a dry contact is estimated.
    step
        Length [s] of all steps of a film, in place of an error.
    """

    times: tuple[Seconds, ...] | None = None
    end: Seconds | None = None
    instants: int | None = None
    error: Number | None = None
    scheme: Scheme = Scheme.IMPLICIT
    step_error: StepError = StepError.STEP_DOUBLING
    step: Seconds | None = None

    @property
    def last(self) -> float | None:
        """Last instant [s] that is named; None where the load decides."""
        return self.end if self.times is None else float(np.max(self.times))

    def instants_of(self, *values: object) -> ArrayLike | None:
        """Return the instants [s], up to the last end of the histories in `values`; None if the error alone decides.

        Evenly spaced instants, apart from the first and the last, are moved to the nearest instants of the histories.

        Raises
        ------
        InvalidInput
            If nothing says when the last instant is.
        """
        if self.times is not None:
            return self.times
        histories: list[Any] = [value for value in values if hasattr(value, "end")]
        if self.end is None and not histories:
            raise InvalidInput(
                "solve.times is None, and nothing in the scene has an end: give times [s]; "
                "in a file give evolve.end or evolve.times."
            )
        end = max(history.end for history in histories) if self.end is None else self.end
        if self.instants is None and self.end is None and self.error is not None:
            return None
        count = DEFAULT_INSTANTS if self.instants is None else self.instants
        whole_number("TimeSteps.instants", count, 2, "give at least 2 instants")
        start = min(history.start for history in histories) if histories else 0.0
        instants = [start + (end - start) * n / (count - 1) for n in range(count)]
        spacing = (end - start) / (count - 1)
        if self.step is None:  # the nearest instant is put where a history bends
            for time in (time for history in histories for time in getattr(history, "times", ())):
                number = round((time - start) / spacing) if spacing else 0
                if 0 < number < count - 1:
                    instants[number] = time
        return instants


@dataclass(frozen=True)
class Breakpoint:
    """An instant at which steps end.

    Attributes
    ----------
    time
        Time [s].
    before, after
        Load [N/m] before and after a jump; equal where there is none.
    times_recorded
        Number of times that the contact is recorded: 0, 1, or 2 for before and after a jump.
    is_discontinuity
        Whether the load or its rate jumps there.
    """

    time: float
    before: float
    after: float
    times_recorded: int
    is_discontinuity: bool

    @property
    def jumps(self) -> bool:
        """True if the load jumps at this instant."""
        return self.before != self.after


def schedule(load: ChangingLoad, times: ArrayLike | None) -> tuple[Breakpoint, ...]:
    """Return the instants at which steps end, from the start of the load to the last recorded time.

    Parameters
    ----------
    load
        Load over time.
    times
        Recorded times [s]; None ends where the load does.

    Raises
    ------
    InvalidInput
        If times decrease, are not finite, begin before the load or stand there three times; if they are None and the
        load has no end.
    """
    recorded = None if times is None else _checked(times, load)
    end = load.end if recorded is None else recorded[-1]
    if recorded is None and end <= load.start:
        raise InvalidInput("solve.times is None, and Scene.load has no end: give times [s].")
    counts = Counter(recorded or ())
    breaks = set(load.breaks(end)) | {load.start}
    return tuple(
        Breakpoint(time, load.before(time), load.at(time), counts[time], time in breaks)
        for time in sorted(breaks | set(counts) | {end})
    )


def with_breakpoints_at(
    breakpoints: tuple[Breakpoint, ...], load: ChangingLoad, times: Sequence[float]
) -> tuple[Breakpoint, ...]:
    """Return `breakpoints` and more at `times` [s] between them, where another history than the `load` is not smooth."""
    at_breakpoints = {point.time for point in breakpoints}
    start, end = breakpoints[0].time, breakpoints[-1].time
    added = (
        Breakpoint(time, load.before(time), load.at(time), times_recorded=0, is_discontinuity=True)
        for time in times
        if start < time < end and time not in at_breakpoints
    )
    broken = (
        replace(point, is_discontinuity=point.is_discontinuity or point.time in times)
        for point in breakpoints
    )
    return tuple(sorted((*broken, *added), key=lambda point: point.time))


# Steps in a period of a load that repeats, at least.
PER_PERIOD = 4


def with_steps_within_quarter_period(
    breakpoints: tuple[Breakpoint, ...], load: ChangingLoad
) -> tuple[Breakpoint, ...]:
    """Return `breakpoints` with more between them, so that no step is longer than a quarter of the period of `load`.

    Steps of whole periods would meet the load at the same place of each, and not see that it changes.
    """
    longest = getattr(load, "period", inf) / PER_PERIOD
    finer = list(breakpoints[:1])
    for first, last in pairwise(breakpoints):
        parts = ceil((last.time - first.time) / longest * (1 - 1e-9))
        for part in range(1, parts):
            time = first.time + (last.time - first.time) * part / parts
            finer.append(
                Breakpoint(
                    time, load.at(time), load.at(time), times_recorded=0, is_discontinuity=False
                )
            )
        finer.append(last)
    return tuple(finer)


def _checked(times: ArrayLike, load: ChangingLoad) -> list[float]:
    """Return `times` [s] as a list that does not decrease; raise InvalidInput for others."""
    remedy = "give instants [s] that do not decrease, the same one twice at the most"
    try:
        values = np.asarray(times, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInput(f"solve.times is {times!r}: {remedy}.") from None
    if values.ndim != 1 or values.size == 0 or not np.isfinite(values).all():
        raise InvalidInput(f"solve.times has the shape {values.shape}: {remedy}, all finite.")
    if (np.diff(values) < 0).any() or (np.diff(values, n=2) == 0)[np.diff(values)[:-1] == 0].any():
        raise InvalidInput(f"solve.times is {times!r}: {remedy}.")
    if values[0] < load.start:
        raise InvalidInput(
            f"solve.times[0] is {float(values[0])!r}: give times from {load.start!r} s on, when the load begins."
        )
    return [float(value) for value in values]


# In the first integration, a pair of steps may add this fraction of the allowed error to the difference of two
# integrations.
INITIAL_TOLERANCE_FRACTION = 0.5
# Smallest and largest factor on the length of a step, and the fraction of the allowed length that is aimed at.
MIN_FACTOR, MAX_FACTOR, SAFETY = 0.2, 2.0, 0.9
# The error increment of a pair grows with its length to this power; that of all pairs, to this power minus 1.
ORDER = 2
# Duration of the first pair of steps over that of the integration: if it is too long, it is rejected.
INITIAL_STEP = 1e-2
# The least ratio of the error to the solver's tolerance, so that the solver's error does not count.
MIN_ERROR_OVER_TOLERANCE = 100


@dataclass(frozen=True)
class StepControl:
    """Control of the step length by the error increment, by which a pair of steps raises the error estimate.

    How far later steps damp that error is not known in advance: if the accumulated error exceeds the allowed one, the
    integration restarts with a :meth:`stricter` control.

    Attributes
    ----------
    error
        Allowed relative L1 error of the pressure.
    local_tolerance
        Allowed error increment of a pair of steps.
    """

    error: float
    local_tolerance: float

    @classmethod
    def for_error(cls, error: float, tolerance: float) -> "StepControl":
        """Return the control of a first integration.

        Parameters
        ----------
        error
            Allowed relative L1 error of the pressure.
        tolerance
            Tolerance of the solver.

        Raises
        ------
        InvalidInput
            If the error is not between 0 and 1, or too close to the tolerance for steps to meet it.
        """
        error = checked_relative_error("TimeSteps.error", error)
        if error < MIN_ERROR_OVER_TOLERANCE * tolerance:
            raise InvalidInput(
                f"TimeSteps.error is {error!r}: give at least {MIN_ERROR_OVER_TOLERANCE} times the tolerance of the "
                "contacts, or a smaller tolerance."
            )
        return cls(error, INITIAL_TOLERANCE_FRACTION * error)

    def accepts(self, error_increment: float) -> bool:
        """Return whether a pair of steps with this `error_increment` is short enough."""
        return error_increment <= self.local_tolerance

    def factor(self, error_increment: float) -> float:
        """Return the factor on the length of the next pair, after one with this `error_increment`."""
        if error_increment <= 0:
            return MAX_FACTOR
        longer: float = (self.local_tolerance / error_increment) ** (1 / ORDER)
        return min(max(SAFETY * longer, MIN_FACTOR), MAX_FACTOR)

    def stricter(self, excessive_error: float) -> "StepControl":
        """Return the control of the next integration, after one whose error is above the allowed one."""
        shorter = min(SAFETY * self.error / excessive_error, 0.7) ** (ORDER / (ORDER - 1))
        return StepControl(self.error, self.local_tolerance * shorter)

"""Breakpoints: the instants at which steps in time end."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, inf

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.checks import InvalidInput, finite
from contactstudy.scene.loads.load_history import ChangingLoad, PiecewiseLinear


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
        Whether the load, its rate or another history may jump or turn at this instant.
    history_jumps
        Whether another history jumps.
    """

    time: float
    before: float
    after: float
    times_recorded: int
    is_discontinuity: bool
    history_jumps: bool = False

    @property
    def jumps(self) -> bool:
        """True if the load or another history jumps at this instant."""
        return self.before != self.after or self.history_jumps


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
        If times decrease, are not finite, begin before the load or name an instant three times; if they are None and
        the load has no end.
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


def with_breakpoints_of(
    breakpoints: tuple[Breakpoint, ...], load: ChangingLoad, history: PiecewiseLinear
) -> tuple[Breakpoint, ...]:
    """Return `breakpoints` and more between them, where another `history` has a kink or jumps."""
    return tuple(
        replace(point, history_jumps=history.before(point.time) != history.at(point.time))
        for point in _with_breakpoints_at(breakpoints, load, history.times)
    )


def _with_breakpoints_at(
    breakpoints: tuple[Breakpoint, ...], load: ChangingLoad, times: Sequence[float]
) -> tuple[Breakpoint, ...]:
    """Return `breakpoints` and more at `times` [s] between."""
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


def with_turning_points(
    breakpoints: tuple[Breakpoint, ...], load: ChangingLoad
) -> tuple[Breakpoint, ...]:
    """Return `breakpoints` and the turning points of `load` between them."""
    return _with_breakpoints_at(breakpoints, load, load.turning_points(breakpoints[-1].time))


def all_recorded(breakpoints: tuple[Breakpoint, ...]) -> tuple[Breakpoint, ...]:
    """Return `breakpoints`, all recorded: before and after a jump, but the first only after it."""
    first, *others = breakpoints
    return (
        replace(first, times_recorded=1),
        *(replace(point, times_recorded=1 + point.jumps) for point in others),
    )


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
    remedy = "give finite instants [s] that do not decrease, the same one twice at the most"
    try:
        values = np.asarray(times, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInput(f"solve.times is {times!r}: {remedy}.") from None
    if values.ndim != 1 or values.size == 0:
        raise InvalidInput(f"solve.times has the shape {values.shape}: {remedy}.")
    if (
        not np.isfinite(values).all()
        or (np.diff(values) < 0).any()
        or (np.diff(values, n=2) == 0)[np.diff(values)[:-1] == 0].any()
    ):
        raise InvalidInput(f"solve.times is {times!r}: {remedy}.")
    if values[0] < load.start:
        raise InvalidInput(
            f"solve.times[0] is {float(values[0])!r}: give times from {load.start!r} s on, when the load begins."
        )
    return [float(value) for value in values]


def ascending(field: str, times: ArrayLike, least: int = 1) -> list[float]:
    """Return the instants [s] of a `field`; raise InvalidInput unless so many are finite and ascend."""
    instants = [finite(field, time, "give times in s") for time in np.ravel(times).tolist()]
    if len(instants) < least or sorted(set(instants)) != instants:
        count = "one" if least == 1 else "two"
        raise InvalidInput(f"{field} is {times!r}: give {count} or more, ascending.")
    return instants

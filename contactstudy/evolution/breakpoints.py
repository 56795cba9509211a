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


def schedule(
    load: ChangingLoad,
    times: ArrayLike | None,
    *,
    kinks: Sequence[float] = (),
    history: PiecewiseLinear | None = None,
    longest: float = inf,
) -> tuple[Breakpoint, ...]:
    """Return the instants at which steps end, from the start of the load to the last recorded time.

    Parameters
    ----------
    load
        Load over time.
    times
        Recorded times [s]; None ends where the load does.
    kinks
        Further times [s] at which steps end, such as those where the load turns.
    history
        Another history, which may have kinks or jump.
    longest
        Longest time [s] from one instant to the next.

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
    further = (*kinks, *(history.times if history is not None else ()))
    breaks = {
        load.start,
        *load.breaks(end),
        *(time for time in further if load.start <= time <= end),
    }
    places = sorted(breaks | set(counts) | {end})
    instants = places[:1]
    for first, last in pairwise(places):
        parts = ceil((last - first) / longest * (1 - 1e-9))
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


def all_recorded(breakpoints: tuple[Breakpoint, ...]) -> tuple[Breakpoint, ...]:
    """Return `breakpoints`, all recorded: before and after a jump, but the first only after it."""
    first, *others = breakpoints
    return (
        replace(first, times_recorded=1),
        *(replace(point, times_recorded=1 + point.jumps) for point in others),
    )


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

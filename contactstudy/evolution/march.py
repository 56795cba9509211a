"""March through time by pairs of steps, beside steps of twice the length, whose difference tells the error of all.

A method tells the error of one step itself, as the change by its correction or from its predictor: that chooses the
length of the steps. Source: Hairer, Norsett & Wanner (1993), sect. II.4, eq. 4.13.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, inf
from typing import Generic, Protocol, TypeVar

import numpy as np

from contactstudy.solvers.solution import Status, worst

# Smallest and largest factor on the length of a step, and the fraction of the allowed length that is aimed at.
MIN_FACTOR, MAX_FACTOR, SAFETY = 0.1, 2.0, 0.8
# A step shorter than this, over the time between two instants, is never rejected.
SHORTEST = 1e-6


class State(Protocol):
    """Protocol of a contact or film at one time."""

    @property
    def time(self) -> float:
        """Time [s]."""

    @property
    def status(self) -> Status:
        """Outcome of the step that led to it."""

    @property
    def change(self) -> float:
        """Error of that step as its method estimates it; infinite where it has no solution."""

    @property
    def work(self) -> Counter[str]:
        """Work of that step, such as iterations, by name."""


S = TypeVar("S", bound=State)


@dataclass(frozen=True, eq=False)
class Record(Generic[S]):
    """What is recorded at an instant.

    Attributes
    ----------
    time
        Time [s].
    state, coarse
        The state after short steps, and after steps twice as long.
    status
        The worst status of the accepted steps since the instant before.
    work
        Work since the instant before, with the number of ``steps`` and of ``rejected`` pairs of them.
    """

    time: float
    state: S
    coarse: S
    status: Status
    work: Counter[str]


def march(
    start: S,
    step: Callable[[S, float], S],
    instants: Sequence[float],
    error: float,
    *,
    order: int,
    first: float = inf,
    longest: float = inf,
    kinks: Sequence[float] = (),
    every_pair: bool = False,
    compare: Callable[[S, S], object] = lambda fine, coarse: None,
    progress: Callable[[float, float], None] | None = None,
) -> list[Record[S]]:
    """Return what is recorded at `instants`, up to a step without a solution.

    Parameters
    ----------
    start
        State at the first time.
    step
        Returns the state after a step of a duration [s].
    instants
        Times [s] to record, ascending.
    error
        Largest error of a step.
    order
        Power of the duration with which the error of a step grows.
    first, longest
        Length of the first step, and of any [s].
    kinks
        Further times [s] at which steps end.
    every_pair
        Whether each pair of steps is recorded.
    compare
        Called with the states after each pair of short steps and after the step of twice the length.
    progress
        Called with the time since the start and that of the whole [s], for each step of a pair once this is accepted.
    """
    fine = coarse = start
    length, work, status = min(first, longest), Counter(start.work), start.status
    records: list[Record[S]] = []

    def record(time: float) -> None:
        nonlocal work, status
        records.append(Record(time, fine, coarse, status, work))
        work, status = Counter(), fine.status

    if start.change == inf:
        record(start.time)
        return records
    for target in sorted({*instants, *kinks}):
        span = target - fine.time
        while (remaining := target - fine.time) > SHORTEST * span:
            duration = remaining / ceil(remaining / min(2 * length, remaining) - SHORTEST) / 2
            middle = step(fine, duration)
            work += middle.work
            change, is_shortest = middle.change, duration <= SHORTEST * span
            if change <= error or is_shortest:  # else the pair is given up at once
                end, double = step(middle, duration), step(coarse, 2 * duration)
                work += end.work + double.work
                change = max(change, end.change, double.change / 2**order)
            factor = SAFETY * (error / max(change, SHORTEST * error)) ** (1 / order)
            next_length = duration * float(np.clip(factor, MIN_FACTOR, MAX_FACTOR))
            if change > error and not is_shortest:
                work["rejected"] += 1
                length = next_length
                continue
            work["steps"] += 2
            fine, coarse = end, double
            status = worst((status, middle.status, end.status, double.status))
            if change == inf:
                record(fine.time)
                return records
            compare(fine, coarse)
            # a step shortened to end at an instant does not limit the next one
            length = min(max(next_length, length if duration < length else 0.0), longest)
            if progress is not None:
                for state in (middle, end):
                    progress(state.time - start.time, instants[-1] - start.time)
            if every_pair and target - fine.time > SHORTEST * span:
                record(fine.time)
        if every_pair or target in instants:
            record(target)
    return records

"""How an interface changes within a step."""

from collections import Counter
from dataclasses import dataclass
from enum import Enum
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.checks import InvalidInput, positive
from contactstudy.scene.load import ChangingLoad

# The stage length at which a two-stage scheme of second order damps stiff changes entirely.
STAGE = 1 - 1 / sqrt(2)


class Scheme(Enum):
    """Stages of a step: each a share of its duration, and the share of that which is explicit.

    It matters to wear alone; creep is exact for a pressure that is linear in each stage. All keep the worn volume.
    """

    #: Second order, stable however long the step, two solves.
    #: Source: Alexander (1977), SIAM J. Numer. Anal. 14, sect. 3.
    TWO_STAGE = ((STAGE, 0.0), (1 - STAGE, (1 - 2 * STAGE) / (1 - STAGE)))
    #: First order, stable however long the step, one solve.
    IMPLICIT = ((1.0, 0.0),)
    #: First order, unstable beyond :func:`~contactstudy.evolution.memory.explicit_limit`: for comparison.
    EXPLICIT = ((1.0, 1.0),)

    @property
    def stages(self) -> tuple[tuple[float, float], ...]:
        """(share of the duration, explicit share of the stage), in the order of time."""
        stages: tuple[tuple[float, float], ...] = self.value
        return stages


@dataclass(frozen=True)
class Mark:
    """An instant ``time`` [s]: the load there ``before`` and ``after`` a jump [N/m], equal where there is none.

    ``records``: how often it is recorded, 0 to 2. ``breaks``: whether the load jumps there or its rate does.
    """

    time: float
    before: float
    after: float
    records: int
    breaks: bool

    @property
    def jumps(self) -> bool:
        """Whether the load jumps."""
        return self.before != self.after


def schedule(load: ChangingLoad, times: ArrayLike | None) -> tuple[Mark, ...]:
    """Marks from the start of ``load`` to the last of ``times`` [s], or to its own end without them.

    Raises :class:`~contactstudy.InvalidInput` for times that cannot be marched through.
    """
    wanted = None if times is None else _checked(times, load)
    end = load.end if wanted is None else wanted[-1]
    if wanted is None and end <= load.start:
        raise InvalidInput("evolve.times is None, and Scene.load has no end: give times [s].")
    records = Counter(wanted or ())
    breaks = set(load.breaks(end)) | {load.start}
    return tuple(
        Mark(time, load.before(time), load.at(time), records[time], time in breaks)
        for time in sorted(breaks | set(records) | {end})
    )


def _checked(times: ArrayLike, load: ChangingLoad) -> list[float]:
    remedy = "give instants [s] that do not decrease, the same one twice at the most"
    try:
        values = np.asarray(times, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInput(f"evolve.times is {times!r}: {remedy}.") from None
    if values.ndim != 1 or values.size == 0 or not np.isfinite(values).all():
        raise InvalidInput(f"evolve.times has the shape {values.shape}: {remedy}, all finite.")
    if (np.diff(values) < 0).any() or (np.diff(values, n=2) == 0)[np.diff(values)[:-1] == 0].any():
        raise InvalidInput(f"evolve.times is {times!r}: {remedy}.")
    if values[0] < load.start:
        raise InvalidInput(
            f"evolve.times[0] is {float(values[0])!r}: give times from {load.start!r} s on, when the load begins."
        )
    return [float(value) for value in values]


# The first march may let the difference of two marches grow by this share of the error in a pair of steps.
SHARE = 0.5
# Change a step's length by no more than these factors, and aim a little short of what is allowed.
SHRINK, GROW, AIM = 0.2, 2.0, 0.9
# What a pair adds to the difference grows with its length to this power, all of it with the one below.
ORDER = 2
# The first pair of steps after a jump, over the whole time: too long ones are rejected.
FIRST = 1e-2
# An error should be so many times the solver's tolerance, or it would be the solver's.
ABOVE_TOLERANCE = 100


@dataclass(frozen=True)
class StepControl:
    """Steps for a relative L1 ``error`` of the pressure, by what a pair of them ``adds`` to it at the most.

    How much of it an evolution forgets cannot be known beforehand: where the sum gets too large, the march starts
    again with a :meth:`stricter` control.
    """

    error: float
    adds: float

    @classmethod
    def of(cls, error: float, tolerance: float) -> "StepControl":
        """For a first march; :class:`~contactstudy.InvalidInput` for an error that steps alone cannot meet."""
        remedy = "give a relative error above 0 and below 1, such as 1e-3"
        if positive("evolve.error", error, remedy) >= 1:
            raise InvalidInput(f"evolve.error is {error!r}: {remedy}.")
        if error < ABOVE_TOLERANCE * tolerance:
            raise InvalidInput(
                f"evolve.error is {error!r}: give {ABOVE_TOLERANCE} times evolve.tolerance or more, or a "
                "smaller tolerance."
            )
        return cls(error, SHARE * error)

    def accepts(self, added: float) -> bool:
        """Whether a pair of steps that has ``added`` so much is good."""
        return added <= self.adds

    def factor(self, added: float) -> float:
        """How much longer the next pair may be."""
        if added <= 0:
            return GROW
        longer: float = (self.adds / added) ** (1 / ORDER)
        return min(max(AIM * longer, SHRINK), GROW)

    def stricter(self, found: float) -> "StepControl":
        """After a march whose error was ``found``, above the one allowed."""
        shorter = min(AIM * self.error / found, 0.7) ** (ORDER / (ORDER - 1))
        return StepControl(self.error, self.adds * shorter)

"""The instants that a march must land on."""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.checks import InvalidInput
from contactstudy.scene.load import ChangingLoad


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

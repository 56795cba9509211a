"""The gap between the bodies under a pressure, split into free cells and cells at a limit."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.arrays import Array
from contactstudy.domain.device import arrays


@dataclass(frozen=True, eq=False)
class Gap:
    """Fields (x, y) and their level, all in units of the gap scale.

    ``free`` is 1 in cells whose pressure is at no limit and 0 in the others. ``contact_gap`` is the gap of those,
    which should be zero, ``penetration`` the depth of penetration of the others (below zero where they are
    apart); each is zero where the other belongs. Both count from the ``approach``, which is such that
    ``contact_gap`` has no mean.
    """

    free: Array
    contact_gap: Array
    penetration: Array
    approach: float


def violation(pressure: Array, penetration: Array) -> Array:
    """How far cells at a limit violate it: penetration where p = 0, an open gap where they yield."""
    xp = arrays()
    return xp.maximum(xp.where(pressure == 0, penetration, -penetration), 0)


def largest(*measures: float) -> float:
    """The largest, or nan where any is nan: Python's own ``max`` forgets a nan that comes later."""
    return float(np.max(measures))

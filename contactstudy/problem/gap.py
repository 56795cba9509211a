"""The gap between the bodies under a pressure."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.devices.arrays import Array
from contactstudy.domain.devices.device import arrays


@dataclass(frozen=True, eq=False)
class Gap:
    """``height`` (x, y) of the gap, counted from the ``approach``, all in units of the gap scale.

    The approach is such that cells whose pressure is at no limit have no mean height. It should be zero in these
    cells, not below zero in cells without pressure, and not above zero in cells at an upper limit. A pass that
    has found the ``residual`` and the ``farthest`` displacement along with the heights leaves them here.
    """

    height: Array
    approach: float
    residual: float | None = None
    farthest: float | None = None


def violation(pressure: Array, height: Array, free: Array) -> Array:
    """How far cells that are not ``free`` violate a limit: penetration where p = 0, an open gap where they yield."""
    xp = arrays()
    return xp.maximum(xp.where(pressure == 0, -height, height) * (1 - free), 0)


def largest(*measures: float) -> float:
    """The largest, or nan where any is nan: Python's own ``max`` forgets a nan that comes later."""
    return float(np.max(measures))

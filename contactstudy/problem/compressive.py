"""Pressures that are never tensile."""

from dataclasses import dataclass
from math import inf

import numpy as np

from contactstudy.domain.arrays import Array, inner, mean_over
from contactstudy.domain.arrays import total as sum_of
from contactstudy.domain.device import arrays
from contactstudy.domain.rows import change, in_blocks
from contactstudy.problem.constraint import shifted
from contactstudy.problem.gap import Gap, largest


@dataclass(frozen=True)
class Compressive:
    """``p >= 0``."""

    def scaled(self, pressure: float) -> "Compressive":
        """The same in any unit."""
        return self

    def of(self, pressure: Array, unit: float) -> Array:
        """``pressure`` in this unit."""
        return np.multiply(pressure, unit, dtype=np.float64)

    def capacity(self, cells: int) -> float:
        """Infinite."""
        return inf

    def free(self, pressure: Array) -> Array:
        """Cells that bear pressure."""
        return arrays().sign(pressure)

    def approach(self, pressure: Array, gap: Array, free: Array) -> float:
        """The mean gap of the contact."""
        return mean_over(free, gap)

    def cuts(self, trial: Array) -> bool:
        """Whether there is tension."""
        return bool(arrays().min(trial) < 0)

    def clip(self, trial: Array) -> Array:
        """Tension is set to zero."""
        return change(trial, lambda some: arrays().maximum(some, 0))

    def carrying(self, trial: Array, total: float) -> Array:
        """Tension is set to zero, the rest scaled."""
        self.clip(trial)
        trial *= float(np.divide(total, sum_of(trial)))
        return trial

    def nearest(self, trial: Array, total: float) -> Array:
        """Shifted, then cut off."""
        return shifted(trial, total, inf)

    def levelled(self, trial: Array, cells: Array, total: float) -> Array:
        """Shifted in Newton's steps, each of which cuts off more: the sum is convex in the shift."""
        xp = arrays()

        def lower(rows: slice, shift: float, chosen: Array | None) -> tuple[float, float, int]:
            some = trial[rows, :] - shift if chosen is None else trial[rows, :] * chosen[rows, :]
            trial[rows, :] = some = xp.maximum(some, 0)
            return float(xp.max(some)), float(xp.sum(some)), int(xp.count_nonzero(some))

        def lowered(shift: float, chosen: Array | None = None) -> tuple[float, float, int]:
            found = in_blocks(lambda rows: lower(rows, shift, chosen), trial.shape)
            most, sums, counts = zip(*found, strict=True)
            return max(most), sum(sums), sum(counts)

        highest, borne, bearing = lowered(0.0, cells)
        if highest > total:  # numbers of this size would drown the load
            chosen = cells > 0
            trial[chosen] = shifted(trial[chosen], total, inf)
            return trial
        while borne > total:
            before = bearing
            _, borne, bearing = lowered((borne - total) / bearing)
            if bearing == before:
                break
        if abs(borne / total - 1) > 16 * xp.finfo(trial.dtype).eps:
            trial *= total / borne
        return trial

    def wrong(self, pressure: Array, penetration: Array) -> Array:
        """Cells that penetrate."""
        return arrays().astype(penetration > 0, penetration.dtype)

    def residual(self, pressure: Array, gap: Gap, borne: float) -> float:
        """Complementarity and penetration."""
        xp = arrays()

        def measure(rows: slice) -> tuple[float, float]:
            moment = inner(pressure[rows, :], xp.abs(gap.contact_gap[rows, :]))
            return moment, float(xp.max(gap.penetration[rows, :]))

        moments, deepest = zip(*in_blocks(measure, pressure.shape), strict=True)
        return largest(sum(moments) / borne, *deepest)

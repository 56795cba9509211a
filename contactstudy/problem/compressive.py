"""Pressures that are never tensile."""

from dataclasses import dataclass
from math import inf

import numpy as np

from contactstudy.domain.arrays import Array, inner, mean_over
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

    def free(self, pressure: Array, out: Array | None = None) -> Array:
        """Cells that bear pressure."""
        return np.sign(pressure, out=out)

    def approach(self, pressure: Array, gap: Array, free: Array) -> float:
        """The mean gap of the contact."""
        return mean_over(free, gap)

    def cuts(self, trial: Array) -> bool:
        """Whether there is tension."""
        return bool(trial.min() < 0)

    def clip(self, trial: Array) -> Array:
        """Tension is set to zero."""
        return np.maximum(trial, 0, out=trial)

    def carrying(self, trial: Array, total: float) -> Array:
        """Tension is set to zero, the rest scaled."""
        self.clip(trial)
        trial *= total / trial.sum()
        return trial

    def nearest(self, trial: Array, total: float) -> Array:
        """Shifted, then cut off."""
        return shifted(trial, total, inf)

    def levelled(self, trial: Array, cells: Array, total: float) -> Array:
        """Shifted in Newton's steps, each of which cuts off more: the sum is convex in the shift."""
        if trial.max() > total:  # numbers of this size would drown the load
            chosen = cells > 0
            levelled = shifted(trial[chosen], total, inf)
            trial[...] = 0
            trial[chosen] = levelled
            return trial
        trial *= cells
        self.clip(trial)
        bearing = np.count_nonzero(trial)
        while (excess := float(trial.sum()) - total) > 0:
            trial -= excess / bearing
            self.clip(trial)
            before, bearing = bearing, np.count_nonzero(trial)
            if bearing == before:
                break
        trial *= total / trial.sum()
        return trial

    def wrong(self, pressure: Array, overlap: Array) -> Array:
        """Cells that penetrate."""
        return np.greater(overlap, 0).astype(overlap.dtype)

    def residual(self, pressure: Array, gap: Gap, borne: float) -> float:
        """Complementarity and penetration."""
        return largest(inner(pressure, np.abs(gap.held)) / borne, gap.overlap.max())

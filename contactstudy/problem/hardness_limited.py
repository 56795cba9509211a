"""Pressures of a contact whose softer body yields."""

from dataclasses import dataclass
from math import prod

import numpy as np

from contactstudy.domain.devices.arrays import Array, inner
from contactstudy.domain.devices.device import arrays
from contactstudy.domain.devices.rows import change
from contactstudy.problem.constraint import shifted
from contactstudy.problem.gap import Gap, largest, violation


@dataclass(frozen=True)
class HardnessLimited:
    """``0 <= p <= hardness``: perfectly plastic above the hardness.

    Where p is at the hardness the bodies may overlap, by what the softer one gives way.
    Source: Almqvist, Sahlin, Larsson & Glavatskih (2007), sect. 2.
    """

    hardness: float

    def scaled(self, pressure: float) -> "HardnessLimited":
        """The same in another unit."""
        return HardnessLimited(float(self.hardness * pressure))

    def of(self, pressure: Array, unit: float) -> Array:
        """In this unit; what yielded there has the hardness to the last bit here."""
        yielding = pressure >= self.scaled(1 / unit).hardness
        return np.where(yielding, self.hardness, np.multiply(pressure, unit, dtype=np.float64))

    def capacity(self, cells: int) -> float:
        """The hardness in every cell."""
        return self.hardness * cells

    def free(self, pressure: Array) -> Array:
        """Cells that bear pressure below the hardness."""
        return arrays().astype((pressure > 0) & (pressure < self.hardness), pressure.dtype)

    def approach(self, pressure: Array, height: Array) -> float:
        """The least that leaves no gap open where all have yielded."""
        return float(arrays().max(height[pressure > 0]))

    def cuts(self, trial: Array) -> bool:
        """Tension, or more than the hardness."""
        xp = arrays()
        return bool(xp.min(trial) < 0 or xp.max(trial) > self.hardness)

    def clip(self, trial: Array) -> Array:
        """No tension, and nothing above the hardness."""
        return change(trial, lambda some: arrays().clip(some, 0.0, self.hardness))

    def carrying(self, trial: Array, total: float) -> Array:
        """Scaled before it is cut off at the hardness, by the one factor that gives the sum ``total``."""
        xp = arrays()
        change(trial, lambda some: xp.maximum(some, 0))
        bearing = trial > 0
        count = int(xp.count_nonzero(bearing))
        if count * self.hardness <= total:
            others = max(prod(trial.shape) - count, 1)
            spread = min((total - self.hardness * count) / others, self.hardness)
            trial[~bearing] = spread
            trial[bearing] = self.hardness
            return trial
        borne = trial[bearing]
        rounding = 8 * float(xp.finfo(trial.dtype).eps)
        if xp.max(borne) == self.hardness and abs(float(xp.sum(borne)) / total - 1) <= rounding:
            return trial  # a factor one bit below 1 would take yielding cells off their limit
        # what is carried grows with the factor along a concave broken line: Newton's steps from the left
        # never pass the root, and end on its own segment
        factor = total / float(xp.sum(borne))
        while True:
            yielding = borne * factor >= self.hardness
            rest = total - self.hardness * int(xp.count_nonzero(yielding))
            below = float(xp.sum(borne[~yielding]))
            if not (below > 0 and rest / below > factor):
                break
            factor = rest / below
        return change(trial, lambda some: xp.minimum(some * factor, self.hardness))

    def nearest(self, trial: Array, total: float) -> Array:
        """Shifted, then cut off."""
        return shifted(trial, total, self.hardness)

    def levelled(self, trial: Array, cells: Array, total: float) -> Array:
        """Shifted, if these cells can make up for the others."""
        xp = arrays()
        self.clip(trial)
        chosen = cells > 0
        rest = total - float(xp.sum(trial[~chosen]))
        if not 0 < rest < self.capacity(int(xp.count_nonzero(chosen))):
            return self.carrying(trial, total)
        trial[chosen] = shifted(trial[chosen], rest, self.hardness)
        return trial

    def wrong(self, pressure: Array, height: Array) -> Array:
        """Cells that penetrate without pressure, and that are open at the hardness."""
        left = violation(pressure, height, self.free(pressure))
        return arrays().astype(left > 0, height.dtype)

    def residual(self, pressure: Array, gap: Gap, borne: float) -> float:
        """Complementarity of the free cells, penetration, and gaps that yielding cells leave open."""
        xp = arrays()
        free = self.free(pressure)
        moment, of_free = inner(pressure, xp.abs(gap.height) * free), inner(pressure, free)
        complementarity = moment / of_free if of_free > 0 else 0.0
        return largest(complementarity, float(xp.max(violation(pressure, gap.height, free))))

"""Pressures of a contact whose softer body yields."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.arrays import Array, inner, mean_over
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
        return HardnessLimited(self.hardness * pressure)

    def of(self, pressure: Array, unit: float) -> Array:
        """In this unit; what yielded there has the hardness to the last bit here."""
        yielding = pressure >= self.scaled(1 / unit).hardness
        return np.where(yielding, self.hardness, np.multiply(pressure, unit, dtype=np.float64))

    def capacity(self, cells: int) -> float:
        """The hardness in every cell."""
        return self.hardness * cells

    def free(self, pressure: Array, out: Array | None = None) -> Array:
        """Cells that bear pressure below the hardness."""
        return np.multiply(pressure > 0, pressure < self.hardness, out=out, dtype=pressure.dtype)

    def approach(self, pressure: Array, gap: Array, free: Array) -> float:
        """The mean gap of the free cells; where all have yielded, the least that leaves none open."""
        if not free.any():
            return float(gap[pressure > 0].max())
        return mean_over(free, gap)

    def cuts(self, trial: Array) -> bool:
        """Tension, or more than the hardness."""
        return bool(trial.min() < 0 or trial.max() > self.hardness)

    def clip(self, trial: Array) -> Array:
        """No tension, and nothing above the hardness."""
        return np.clip(trial, 0, self.hardness, out=trial)

    def carrying(self, trial: Array, total: float) -> Array:
        """Scaled before it is cut off at the hardness, by the one factor that gives the sum ``total``."""
        np.maximum(trial, 0, out=trial)
        bearing = trial > 0
        if np.count_nonzero(bearing) * self.hardness <= total:
            self._spread(trial, bearing, total)
            return trial
        borne = trial[bearing]
        rounding = 8 * np.finfo(trial.dtype).eps
        if borne.max() == self.hardness and abs(borne.sum() / total - 1) <= rounding:
            return trial  # a factor one bit below 1 would take yielding cells off their limit
        # what is carried grows with the factor along a concave broken line: Newton's steps from the left
        # never pass the root, and end on its own segment
        factor = total / borne.sum()
        while True:
            yielding = borne * factor >= self.hardness
            rest = total - self.hardness * np.count_nonzero(yielding)
            better = rest / borne[~yielding].sum()
            if not better > factor:
                break
            factor = better
        trial *= factor
        return np.minimum(trial, self.hardness, out=trial)

    def _spread(self, trial: Array, bearing: NDArray[np.bool_], total: float) -> None:
        """The bearing cells at the hardness, what they leave of the load evenly on the others."""
        others = trial.size - np.count_nonzero(bearing)
        rest = total - self.hardness * (trial.size - others)
        np.copyto(trial, min(rest / others, self.hardness) if others else self.hardness)
        trial[bearing] = self.hardness

    def nearest(self, trial: Array, total: float) -> Array:
        """Shifted, then cut off."""
        return shifted(trial, total, self.hardness)

    def levelled(self, trial: Array, cells: Array, total: float) -> Array:
        """Shifted, if these cells can make up for the others."""
        self.clip(trial)
        chosen = cells > 0
        rest = total - float(trial[~chosen].sum())
        if not 0 < rest < self.capacity(int(np.count_nonzero(chosen))):
            return self.carrying(trial, total)
        trial[chosen] = shifted(trial[chosen], rest, self.hardness)
        return trial

    def wrong(self, pressure: Array, penetration: Array) -> Array:
        """Cells that penetrate without pressure, and that are open at the hardness."""
        return (violation(pressure, penetration) > 0).astype(penetration.dtype)

    def residual(self, pressure: Array, gap: Gap, borne: float) -> float:
        """Complementarity of the free cells, penetration, and gaps that yielding cells leave open."""
        borne_free = inner(pressure, gap.free)
        complementarity = (
            inner(pressure, np.abs(gap.contact_gap)) / borne_free if borne_free > 0 else 0.0
        )
        return largest(complementarity, violation(pressure, gap.penetration).max())

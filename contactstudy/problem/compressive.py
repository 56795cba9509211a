"""Pressures that are never tensile."""

from dataclasses import dataclass
from math import inf, nan

import numpy as np

from contactstudy.domain.devices.arrays import Array, inner
from contactstudy.domain.devices.arrays import total as sum_of
from contactstudy.domain.devices.device import arrays, fused
from contactstudy.domain.devices.rows import change, in_blocks
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
        return arrays().astype(pressure > 0, pressure.dtype)

    def approach(self, pressure: Array, height: Array) -> float:
        """None: pressure that carries a load has free cells."""
        return nan

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
        xp, kernels = arrays(), fused()

        def chosen(rows: slice) -> float:
            if kernels is not None:
                return float(kernels.chosen(trial[rows, :], cells[rows, :]))
            some = xp.maximum(trial[rows, :] * cells[rows, :], 0)
            trial[rows, :] = some
            return float(xp.max(some))

        if max(in_blocks(chosen, trial.shape)) > total:  # numbers of this size would drown the load
            where = cells > 0
            trial[where] = shifted(trial[where], total, inf)
            return trial
        shift, before = 0.0, -1.0

        def measure(rows: slice) -> tuple[float, float]:
            if kernels is not None:
                found: tuple[float, float] = kernels.lowered(trial[rows, :], shift)
                return found
            some = xp.maximum(trial[rows, :] - shift, 0)
            return float(xp.sum(some)), int(xp.count_nonzero(some > 0))

        while True:
            borne, bearing = map(sum, zip(*in_blocks(measure, trial.shape), strict=True))
            if not borne > total or bearing == before:
                break
            shift, before = shift + (borne - total) / bearing, bearing
        scale = 1.0 if abs(borne / total - 1) <= 16 * xp.finfo(trial.dtype).eps else total / borne

        def lower(rows: slice) -> None:
            if kernels is not None:
                kernels.lower(trial[rows, :], shift, scale)
            else:
                trial[rows, :] = xp.maximum(trial[rows, :] - shift, 0) * scale

        in_blocks(lower, trial.shape)
        return trial

    def wrong(self, pressure: Array, height: Array) -> Array:
        """Cells that penetrate."""
        return arrays().astype((pressure == 0) & (height < 0), height.dtype)

    def residual(self, pressure: Array, gap: Gap, borne: float) -> float:
        """Complementarity and penetration."""
        xp = arrays()

        def measure(rows: slice) -> tuple[float, float]:
            some, height = pressure[rows, :], gap.height[rows, :]
            return inner(some, xp.abs(height)), float(xp.max((self.free(some) - 1) * height))

        moments, deepest = zip(*in_blocks(measure, pressure.shape), strict=True)
        return largest(sum(moments) / borne, *deepest)

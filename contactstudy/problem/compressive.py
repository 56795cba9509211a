"""Pressures that are never tensile."""

from dataclasses import dataclass
from math import inf, nan

import numpy as np

from contactstudy.domain.devices.arrays import Array, inner
from contactstudy.domain.devices.arrays import total as sum_of
from contactstudy.domain.devices.device import arrays, fused
from contactstudy.domain.devices.rows import change, compiled, in_blocks
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
        borne, bearing, most = _chosen(trial, cells)
        if most > total:  # numbers of this size would drown the load
            where = cells > 0
            trial[where] = shifted(trial[where], total, inf)
            return trial
        shift, before = 0.0, -1.0
        while borne > total and bearing != before:
            shift, before = shift + (borne - total) / bearing, bearing
            borne, bearing = _lowered(trial, shift)
        rounding = 16 * arrays().finfo(trial.dtype).eps
        return _lower(trial, shift, 1.0 if abs(borne / total - 1) <= rounding else total / borne)

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


def _chosen(trial: Array, cells: Array) -> tuple[float, ...]:
    """Tension and what is not among the ``cells`` cut off, in place; the load, in how many cells, the largest left."""
    xp, kernels = arrays(), fused()
    if kernels is not None:
        found = compiled(kernels.chosen, trial, cells, results=3)
        return (*found[:2].sum(axis=1).tolist(), float(found[2].max()))

    def some(rows: slice) -> tuple[float, float, float]:
        kept = xp.maximum(trial[rows, :] * cells[rows, :], 0)
        trial[rows, :] = kept
        return float(xp.sum(kept)), int(xp.count_nonzero(kept > 0)), float(xp.max(kept))

    borne, bearing, most = zip(*in_blocks(some, trial.shape), strict=True)
    return sum(borne), sum(bearing), max(most)


def _lowered(trial: Array, shift: float) -> tuple[float, ...]:
    """The load that is left of a pressure so much lower, and in how many cells."""
    xp, kernels = arrays(), fused()
    if kernels is not None:
        return tuple(compiled(kernels.lowered, trial, shift, results=2).sum(axis=1).tolist())

    def some(rows: slice) -> tuple[float, float]:
        left = xp.maximum(trial[rows, :] - shift, 0)
        return float(xp.sum(left)), int(xp.count_nonzero(left > 0))

    return tuple(map(sum, zip(*in_blocks(some, trial.shape), strict=True)))


def _lower(trial: Array, shift: float, scale: float) -> Array:
    """That pressure, in place, times a factor."""
    xp, kernels = arrays(), fused()
    if kernels is not None:
        compiled(kernels.lower, trial, shift, scale)
        return trial
    return change(trial, lambda some: xp.maximum(some - shift, 0) * scale)

"""The gap under a pressure, what limits the pressure of each cell, and what all cells carry together."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, nan, prod
from typing import Protocol, Self

import numpy as np

from contactstudy.domain.device import arrays
from contactstudy.domain.fields import Array, in_blocks, inner, replaced
from contactstudy.domain.fields import total as sum_of


@dataclass(frozen=True, eq=False)
class Gap:
    """``height`` (x, y) of the gap, counted from the ``approach``, all in units of the gap scale.

    The approach is such that cells whose pressure is at no limit have no mean height. It should be zero in these
    cells, not below zero in cells without pressure, and not above zero in cells at an upper limit. A pass that has
    found them along with the heights leaves here the ``measured`` violation of the constraint, the ``load`` (the sum of
    the pressure) and the size of the ``farthest`` displacement.
    """

    height: Array
    approach: float
    measured: float | None = None
    load: float | None = None
    farthest: float | None = None


def violation(pressure: Array, height: Array, free: Array) -> Array:
    """How far cells that are not ``free`` violate a limit: penetration where p = 0, an open gap where they yield."""
    xp = arrays()
    return xp.maximum(xp.where(pressure == 0, -height, height) * (1 - free), 0)


def largest(*measures: float) -> float:
    """The largest, or nan where any is nan: Python's own ``max`` forgets a nan that comes later."""
    return float(np.max(measures))


class Constraint(Protocol):
    """A convex set of pressures (x, y), cell by cell: cells at a limit are bound, the others free."""

    def scaled(self, pressure: float) -> Self:
        """The same set in another unit of pressure (times ``pressure``)."""
        ...

    def of(self, pressure: Array, unit: float) -> Array:
        """The field of this set that ``pressure`` is in another ``unit``."""
        ...

    def capacity(self, cells: int) -> float:
        """The largest sum of the pressures of so many cells."""
        ...

    def free(self, pressure: Array) -> Array:
        """1 for cells at no limit, where the gap should be zero, and 0 for the others.

        These are numbers, because a masked choice costs ten times a product on a rough contact.
        """
        ...

    def approach(self, pressure: Array, height: Array) -> float:
        """The approach from the ``height`` of the gap where no cell of ``pressure`` is free."""
        ...

    def cuts(self, trial: Array) -> bool:
        """Whether ``trial`` is beyond a limit anywhere."""
        ...

    def clip(self, trial: Array) -> Array:
        """``trial`` cut off at the limits, in place."""
        ...

    def carrying(self, trial: Array, total: float) -> Array:
        """``trial`` cut off at the limits and scaled to the sum ``total``, in place."""
        ...

    def nearest(self, trial: Array, total: float) -> Array:
        """The pressure of this set with the sum ``total`` that is nearest to ``trial``, in place."""
        ...

    def levelled(self, trial: Array, cells: Array, total: float) -> Array:
        """``trial`` cut off at the limits, its ``cells`` (1, others 0) shifted to the sum ``total``, in place.

        Where these cells alone cannot, all cells carry it.
        """
        ...

    def wrong(self, pressure: Array, height: Array) -> Array:
        """1 for cells at a limit that should leave it by the ``height`` of their gap, and 0 for the others."""
        ...

    def residual(self, pressure: Array, gap: Gap, borne: float) -> float:
        """The larger of complementarity and penetration, in units of the gap scale.

        ``borne`` is the sum of ``pressure``. See :func:`~contactstudy.solve`.
        """
        ...


def shifted(trial: Array, total: float, most: float) -> Array:
    """``trial`` shifted by the one height at which, cut off at 0 and ``most``, it sums to ``total``.

    In place. The sum is piecewise linear in the shift, with a bend where a cell begins to bear and where it
    reaches ``most``. Source: Held, Wolfe & Crowder (1974), here with an upper limit.
    """
    xp = arrays()
    # counted from the highest cell, so that the numbers have the size of the load where it is borne
    below = xp.astype(trial, xp.float64, copy=False)
    below -= float(xp.max(below))
    bends = xp.sort(xp.reshape(-below, (-1,)))
    cells = bends.shape[0]
    bearing = xp.arange(1, cells + 1, dtype=xp.float64)
    if most < inf:
        bends = xp.concat([bends, bends + most])
        order = xp.argsort(bends, stable=True)
        bends = xp.take(bends, order, axis=0)
        bearing = xp.cumulative_sum(1 - 2 * xp.astype(order >= cells, xp.float64))
    borne = xp.diff(bends)
    borne *= bearing[:-1]
    borne = xp.cumulative_sum(borne)
    last = int(xp.searchsorted(borne, xp.full_like(bends[:1], total))[0])
    rest, bear = total - (float(borne[last - 1]) if last else 0.0), max(float(bearing[last]), 1.0)
    shift = float(bends[last]) + rest / bear
    del bends, bearing, borne
    # a second correction, for the rounding of a cumulative sum
    shift += (total - float(xp.sum(xp.clip(below + shift, 0.0, most)))) / bear
    below += shift
    trial[...] = xp.astype(xp.clip(below, 0.0, most), trial.dtype, copy=False)
    return trial


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
        return replaced(trial, lambda block: arrays().maximum(block, 0))

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
        trial *= cells
        self.clip(trial)
        bearing = trial[trial != 0]
        borne = float(xp.sum(bearing))
        if bearing.shape[0] and float(xp.max(bearing)) > total:
            # numbers of this size would drown the load
            where = cells > 0
            trial[where] = shifted(trial[where], total, inf)
            return trial

        def lowered(shift: float) -> tuple[float, float]:
            rest = bearing[bearing > shift]
            return float(xp.sum(rest)) - shift * rest.shape[0], rest.shape[0]

        epsilon = float(xp.finfo(trial.dtype).eps)
        shift, factor = lowered_to(total, borne, bearing.shape[0], lowered, epsilon)
        return replaced(trial, lambda block: xp.maximum(block - shift, 0) * factor)

    def wrong(self, pressure: Array, height: Array) -> Array:
        """Cells that penetrate."""
        return arrays().astype((pressure == 0) & (height < 0), height.dtype)

    def residual(self, pressure: Array, gap: Gap, borne: float) -> float:
        """Complementarity and penetration."""
        xp = arrays()

        def measure(block: Array, height: Array) -> tuple[float, float]:
            overlap = xp.where(block == 0, height, 0.0)
            return inner(block, xp.abs(height)), -float(xp.min(overlap))

        moments, deepest = zip(*in_blocks(measure, pressure, gap.height), strict=True)
        return largest(sum(moments) / borne, *deepest)


def lowered_to(
    load: float,
    borne: float,
    bearing: float,
    lowered: Callable[[float], tuple[float, float]],
    epsilon: float,
) -> tuple[float, float]:
    """Return the shift and the factor that make a pressure carry `load`.

    The pressure carries `borne` in so many `bearing` cells; `lowered` tells the same of it after a shift. The factor
    makes up for what no shift can, and is 1 within some roundings `epsilon`.
    """
    shift, before = 0.0, -1.0
    while borne > load and bearing != before:
        shift, before = shift + (borne - load) / bearing, bearing
        borne, bearing = lowered(shift)
    return shift, 1.0 if abs(borne / load - 1) <= 16 * epsilon else load / borne


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
        return replaced(trial, lambda block: arrays().clip(block, 0.0, self.hardness))

    def carrying(self, trial: Array, total: float) -> Array:
        """Scaled before it is cut off at the hardness, by the one factor that gives the sum ``total``."""
        xp = arrays()
        replaced(trial, lambda block: xp.maximum(block, 0))
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
        return replaced(trial, lambda block: xp.minimum(block * factor, self.hardness))

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


class Resultant(Protocol):
    """What closes the problem beside the conditions in each cell."""

    def scaled(self, pressure: float, cells: int = 1) -> Self:
        """The same in another unit of pressure (times ``pressure``), on blocks of so many cells."""
        ...

    def is_met_by(self, constraint: Constraint, cells: int) -> bool:
        """Whether so many cells under ``constraint`` can meet it."""
        ...

    def uniform(self, cells: int) -> float:
        """The pressure that meets it if it is the same in so many cells."""
        ...

    def admit(self, trial: Array, constraint: Constraint) -> Array:
        """``trial`` cut off at the limits of ``constraint`` and made to meet this, in place."""
        ...

    def nearest(self, trial: Array, constraint: Constraint) -> Array:
        """The admissible pressure nearest to ``trial``, in place: a step against the gap, made so, is downhill."""
        ...

    def levelled(self, trial: Array, cells: Array, constraint: Constraint) -> Array:
        """``trial`` cut off at the limits and made to meet this by a shift of ``cells``, in place."""
        ...

    def error(self, borne: float) -> float:
        """How far a pressure whose sum is ``borne`` is from meeting it, dimensionless."""
        ...


@dataclass(frozen=True)
class PrescribedLoad:
    """``sum(p) = total``: the load over the area of a cell, in the unit of p."""

    total: float

    def scaled(self, pressure: float, cells: int = 1) -> "PrescribedLoad":
        """In another unit, on larger cells."""
        return PrescribedLoad(float(self.total * pressure / cells))

    def is_met_by(self, constraint: Constraint, cells: int) -> bool:
        """Whether the cells can carry the load."""
        return constraint.capacity(cells) >= self.total

    def uniform(self, cells: int) -> float:
        """The load spread evenly."""
        return self.total / cells

    def admit(self, trial: Array, constraint: Constraint) -> Array:
        """Scaled to the load."""
        return constraint.carrying(trial, self.total)

    def nearest(self, trial: Array, constraint: Constraint) -> Array:
        """Shifted to the load."""
        return constraint.nearest(trial, self.total)

    def levelled(self, trial: Array, cells: Array, constraint: Constraint) -> Array:
        """Shifted to the load."""
        return constraint.levelled(trial, cells, self.total)

    def error(self, borne: float) -> float:
        """``|borne / total - 1|``."""
        return abs(borne / self.total - 1)

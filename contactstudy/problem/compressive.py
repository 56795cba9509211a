"""The pressures a contact may take: never tensile, and carrying the load."""

from dataclasses import dataclass, replace
from math import inf
from typing import Protocol, Self

import numpy as np

from contactstudy.domain.arrays import Array, inner, mean_over
from contactstudy.problem.gap import Gap


class AdmissiblePressures(Protocol):
    """A convex set of pressures (width, length); cells at one of its limits are bound, others free."""

    @property
    def total(self) -> float:
        """``sum(p)``: the load over a cell's area, in the unit of p."""
        ...

    def scaled(self, pressure: float, cells: int = 1) -> Self:
        """The same set in another unit of pressure (times ``pressure``), on blocks of so many cells."""
        ...

    def of(self, pressure: Array, unit: float) -> Array:
        """The field of this set that ``pressure`` is in another ``unit``."""
        ...

    def is_empty(self, shape: tuple[int, ...]) -> bool:
        """Whether no field of that shape is in the set."""
        ...

    def free(self, pressure: Array, out: Array | None = None) -> Array:
        """1 for cells at no limit, where the bodies touch, no more and no less; 0 for the others.

        As numbers, for a masked choice costs ten times a product where the contact is rough.
        """
        ...

    def approach(self, pressure: Array, gap: Array, free: Array) -> float:
        """The approach at which ``gap`` is zero on the mean of the ``free`` cells of ``pressure``."""
        ...

    def cuts(self, trial: Array) -> bool:
        """Whether a limit cuts something off ``trial``."""
        ...

    def clip(self, trial: Array) -> Array:
        """``trial`` cut off at the limits, in place."""
        ...

    def admit(self, trial: Array) -> Array:
        """``trial`` cut off at the limits and made to carry the load, in place."""
        ...

    def nearest(self, trial: Array) -> Array:
        """The admissible pressure nearest to ``trial``, in place.

        A step against the gap, made so, is downhill.
        """
        ...

    def residual(self, pressure: Array, gap: Gap) -> float:
        """The measure of :func:`~contactstudy.solve`, of a ``gap`` in units of the gap scale."""
        ...


@dataclass(frozen=True)
class CompressivePressures:
    """``p >= 0`` and ``sum(p) = total``."""

    total: float

    def scaled(self, pressure: float, cells: int = 1) -> "CompressivePressures":
        """In another unit, on larger cells."""
        return replace(self, total=self.total * pressure / cells)

    def of(self, pressure: Array, unit: float) -> Array:
        """In this unit."""
        return np.multiply(pressure, unit, dtype=np.float64)

    def is_empty(self, shape: tuple[int, ...]) -> bool:
        """Never."""
        return False

    def free(self, pressure: Array, out: Array | None = None) -> Array:
        """Cells that bear pressure."""
        return np.sign(pressure, out=out)

    def approach(self, pressure: Array, gap: Array, free: Array) -> float:
        """The mean gap of the contact."""
        return mean_over(free, gap)

    def cuts(self, trial: Array) -> bool:
        """Tension."""
        return bool(trial.min() < 0)

    def clip(self, trial: Array) -> Array:
        """No tension."""
        return np.maximum(trial, 0, out=trial)

    def admit(self, trial: Array) -> Array:
        """Tension cut off, the rest scaled."""
        self.clip(trial)
        trial *= self.total / trial.sum()
        return trial

    def nearest(self, trial: Array) -> Array:
        """Shifted, then cut off."""
        return shifted(trial, self.total, inf)

    def residual(self, pressure: Array, gap: Gap) -> float:
        """Complementarity, penetration, load."""
        borne = pressure.sum()
        complementarity = inner(pressure, np.abs(gap.held)) / borne
        return largest(complementarity, gap.overlap.max(), abs(borne / self.total - 1))


def largest(*measures: float) -> float:
    """The largest, or nan where any is nan: Python's own ``max`` forgets a nan that comes later."""
    return float(np.max(measures))


def shifted(trial: Array, total: float, most: float) -> Array:
    """``trial`` shifted by the one height at which, cut off at 0 and ``most``, it sums to ``total``.

    In place. What is carried is a broken line in the shift: it bends where a cell begins to bear, and where
    it has all it can. Source: Held, Wolfe & Crowder (1974), here with a most.
    """
    # counted from the highest, so that the numbers are of the load's size where it is borne
    below = trial.astype(np.float64, copy=False)
    below -= below.max()
    bends = np.negative(below).ravel()
    bends.sort()
    bearing = np.arange(1.0, bends.size + 1)
    if most < inf:
        bends = np.concatenate([bends, bends + most])
        order = np.argsort(bends, kind="stable")
        bends, bearing = bends[order], np.cumsum(np.where(order < below.size, 1.0, -1.0))
    borne = np.diff(bends)
    borne *= bearing[:-1]
    np.cumsum(borne, out=borne)
    last = int(np.searchsorted(borne, total))
    rest, cells = total - (borne[last - 1] if last else 0.0), max(bearing[last], 1.0)
    shift = bends[last] + rest / cells
    del bends, bearing, borne
    # once more, for the rounding of a sum in order
    shift += (total - np.clip(below + shift, 0, most).sum()) / cells
    below += shift
    return np.asarray(np.clip(below, 0, most, out=below), dtype=trial.dtype)

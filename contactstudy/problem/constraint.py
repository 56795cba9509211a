"""What limits the pressure of each cell, whatever load they carry together."""

from math import inf
from typing import Protocol, Self

from contactstudy.domain.devices.arrays import Array
from contactstudy.domain.devices.device import arrays
from contactstudy.problem.gap import Gap


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

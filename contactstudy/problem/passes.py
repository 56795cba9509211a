"""Passes over the fields of an iteration, which are chosen once for a problem: array operations or compiled loops.

Both do the same, but for rounding. Array operations serve any device and any constraint. Compiled loops read and write
each field once; they pay on large fields of the two constraints of this package.
"""

from collections.abc import Callable
from math import inf
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from contactstudy.domain.device import Precision, arrays, threads
from contactstudy.domain.fields import (
    PART,
    Array,
    compiled_loops,
    in_blocks,
    in_parts,
    inner,
    total,
)
from contactstudy.problem.constraint import (
    Compressive,
    Constraint,
    Gap,
    HardnessLimited,
    PrescribedLoad,
    Resultant,
    largest,
    lowered_to,
)

# Heights beyond this are left to double precision: their squares and sums must be numbers in single precision too.
FAR = 1e15


class ArrayPasses:
    """Passes by operations of the device's array library, in blocks of rows."""

    def __init__(self, constraint: Constraint) -> None:
        self.constraint = constraint

    def preconditioner(self, undeformed_gap: Array) -> Precision | None:
        """None: a preconditioner works in the precision of the problem, else every field would be converted."""
        return None

    def gap(self, undeformed: Array, displacement: Array, pressure: Array, height: Array) -> Gap:
        """Return the gap, whose heights are written to `height`: zero on the mean of the free cells."""
        free_of = self.constraint.free

        def add(heights: Array, flat: Array, moved: Array, bearing: Array) -> tuple[float, float]:
            free = free_of(bearing)
            heights[...] = flat + moved
            return inner(heights, free), float(arrays().sum(free))

        sums = in_blocks(add, height, undeformed, displacement, pressure)
        heights, cells = map(sum, zip(*sums, strict=True))
        approach = heights / cells if cells else self.constraint.approach(pressure, height)

        in_blocks(lambda block: block.__isub__(approach), height)
        return Gap(height, approach)

    def contact(self, pressure: Array, height: Array, real: DTypeLike) -> tuple[Array, Array]:
        """Return the cells that bear pressure and are at no limit (1, others 0), and their gap, in `real` numbers."""
        cells, unlevel = (arrays().empty(pressure.shape, dtype=real) for _ in range(2))

        def some(free: Array, level: Array, bearing: Array, own: Array) -> None:
            free[...] = self.constraint.free(bearing)
            level[...] = own * free

        in_blocks(some, cells, unlevel, pressure, height)
        return cells, unlevel

    def joined(
        self, pressure: Array, height: Array, extended: Array, step_length: float, contact: Array
    ) -> Array:
        """Return the `contact` with the cells at a limit that should leave it after a step; itself if there are none.

        The step changes the gap everywhere by that share of the `extended` gap.
        """
        cells = arrays().empty_like(contact)

        def some(after: Array, before: Array, bearing: Array, own: Array, whole: Array) -> bool:
            wrong = self.constraint.wrong(bearing, own - step_length * whole)
            after[...] = before + wrong
            return bool(arrays().any(wrong > 0))

        joined = any(in_blocks(some, cells, contact, pressure, height, extended))
        return cells if joined else contact

    def product(self, height: Array, cells: Array, out: Array) -> Array:
        """Write the gap of `cells`, which are 1, and 0 for others, into `out`."""

        def some(own: Array, chosen: Array, product: Array) -> None:
            product[...] = own * chosen

        in_blocks(some, height, cells, out)
        return out

    def totals(self, cells: Array, closing: Array) -> tuple[float, ...]:
        """Return the number of `cells`, and the sum of the pressure that would close them."""
        return total(cells), total(closing)

    def products(self, *fields: Array) -> tuple[float, ...]:
        """Return the sums that make a direction conjugate, of gap, closing pressure, cells, step and response.

        The number of cells, the sum of the closing pressure, and the products of gap and closing pressure, closing
        pressure and response, cells and response, gap of the cells and step, cells and step.
        """

        def some(
            height: Array, closing: Array, cells: Array, step: Array, response: Array
        ) -> tuple[float, ...]:
            pairs = (height, closing), (closing, response), (cells, response)
            sums = (inner(*pair) for pair in (*pairs, (height * cells, step), (cells, step)))
            return total(cells), total(closing), *sums

        return tuple(map(sum, zip(*in_blocks(some, *fields), strict=True)))

    def trial(
        self,
        pressure: Array,
        closing: Array,
        cells: Array,
        level: float,
        conjugate: float,
        step_length: float,
        step: Array,
    ) -> bool:
        """Write the pressure one step ahead over the last `step`; whether a limit cuts it."""

        def some(ahead: Array, against: Array, chosen: Array, bearing: Array) -> bool:
            if conjugate:
                ahead *= conjugate
                ahead -= against
                ahead += level
            else:
                ahead[...] = level - against
            ahead *= chosen
            if step_length != 1:
                ahead *= step_length
            ahead += bearing
            return self.constraint.cuts(ahead)

        return any(in_blocks(some, step, closing, cells, pressure))

    def levelled(self, trial: Array, cells: Array, resultant: Resultant) -> Array:
        """Cut a trial pressure off at the limits and shift its `cells` to meet the `resultant`, in place."""
        return resultant.levelled(trial, cells, self.constraint)

    def slope(self, trial: Array, pressure: Array, height: Array) -> float:
        """Return how fast the energy grows along the step to `trial`."""

        fields = trial, pressure, height
        return sum(in_blocks(lambda there, here, gap: inner(gap, there - here), *fields))

    def curvature(self, trial: Array, pressure: Array, ahead: Array, displacement: Array) -> float:
        """Return the work of the step to `trial` on the change of displacement that it makes."""

        def some(there: Array, here: Array, after: Array, before: Array) -> float:
            return inner(there - here, after - before)

        return sum(in_blocks(some, trial, pressure, ahead, displacement))

    def meets_a_limit(self, trial: Array, pressure: Array, factor: float) -> bool:
        """Return whether a cell is beyond a limit after `factor` steps."""

        def some(there: Array, here: Array) -> bool:
            return self.constraint.cuts(here + factor * (there - here))

        return any(in_blocks(some, trial, pressure))

    def advance(
        self, trial: Array, pressure: Array, ahead: Array, displacement: Array, share: float
    ) -> None:
        """Take a `share` of a step: `trial` and `ahead` become the pressure and displacement that it leads to.

        The changes of both, from there back, are written over `pressure` and `displacement`.
        """

        def some(back: Array, there: Array) -> None:
            back -= there
            if share != 1:
                there += (1 - share) * back
                back *= share

        in_blocks(some, displacement, ahead)
        in_blocks(some, pressure, trial)
        if share != 1:
            self.constraint.clip(trial)


class CompiledPasses:
    """The passes of :class:`ArrayPasses`, compiled: for numpy arrays, and constraints with one upper limit."""

    def __init__(self, constraint: Constraint, loops: Any) -> None:
        self.constraint, self._loops = constraint, loops
        self._limit = constraint.capacity(1)

    def preconditioner(self, undeformed_gap: Array) -> Precision | None:
        """Single precision where heights allow it: passes then take half the time, and no more iterations."""
        return Precision.SINGLE if -FAR < float(undeformed_gap.max()) < FAR else None

    def gap(self, undeformed: Array, displacement: Array, pressure: Array, height: Array) -> Gap:
        """As :meth:`ArrayPasses.gap`, with measures of the residual."""
        fields, limit = (undeformed, displacement, pressure), self._limit
        heights, cells = _rows(self._loops.level, *fields, limit, results=2).sum(axis=1).tolist()
        at_limits = self.constraint.approach
        approach = heights / cells if cells else at_limits(pressure, undeformed + displacement)
        sums = _rows(self._loops.measured, *fields, approach, limit, height, results=5)
        load, moment, free_load = sums[:3].sum(axis=1).tolist()
        complementarity = moment / free_load if free_load > 0 else 0.0
        measured = largest(complementarity, sums[3].max())
        return Gap(height, approach, measured, load, float(sums[4].max()))

    def contact(self, pressure: Array, height: Array, real: DTypeLike) -> tuple[Array, Array]:
        """As :meth:`ArrayPasses.contact`."""
        cells, unlevel = (np.empty(pressure.shape, dtype=real) for _ in range(2))
        _rows(self._loops.contact, pressure, height, self._limit, cells, unlevel)
        return cells, unlevel

    def joined(
        self, pressure: Array, height: Array, extended: Array, step_length: float, contact: Array
    ) -> Array:
        """As :meth:`ArrayPasses.joined`."""
        cells = np.empty_like(contact)
        fields = pressure, height, extended, step_length, self._limit, contact, cells
        return cells if _rows(self._loops.joined, *fields, results=1).any() else contact

    def product(self, height: Array, cells: Array, out: Array) -> Array:
        """As :meth:`ArrayPasses.product`."""
        _rows(self._loops.product, height, cells, out)
        return out

    def totals(self, cells: Array, closing: Array) -> tuple[float, ...]:
        """As :meth:`ArrayPasses.totals`."""
        return tuple(_rows(self._loops.totals, cells, closing, results=2).sum(axis=1).tolist())

    def products(self, *fields: Array) -> tuple[float, ...]:
        """As :meth:`ArrayPasses.products`."""
        return tuple(_rows(self._loops.products, *fields, results=7).sum(axis=1).tolist())

    def trial(
        self,
        pressure: Array,
        closing: Array,
        cells: Array,
        level: float,
        conjugate: float,
        step_length: float,
        step: Array,
    ) -> bool:
        """As :meth:`ArrayPasses.trial`."""
        fields = pressure, closing, cells, level, conjugate, step_length, self._limit, step
        return bool(_rows(self._loops.trial, *fields, results=1).any())

    def levelled(self, trial: Array, cells: Array, resultant: Resultant) -> Array:
        """As :meth:`ArrayPasses.levelled`."""
        if self._limit < inf or not isinstance(resultant, PrescribedLoad):
            return resultant.levelled(trial, cells, self.constraint)
        load = resultant.total
        sums = _rows(self._loops.chosen, trial, cells, results=3)
        borne, bearing = sums[:2].sum(axis=1).tolist()
        if sums[2].max() > load:  # numbers of this size would drown the load
            return resultant.levelled(trial, cells, self.constraint)

        def lowered(shift: float) -> tuple[float, float]:
            borne, bearing = (
                _rows(self._loops.lowered, trial, shift, results=2).sum(axis=1).tolist()
            )
            return borne, bearing

        shift, factor = lowered_to(load, borne, bearing, lowered, float(np.finfo(trial.dtype).eps))
        _rows(self._loops.lower, trial, shift, factor)
        return trial

    def slope(self, trial: Array, pressure: Array, height: Array) -> float:
        """As :meth:`ArrayPasses.slope`."""
        return float(_rows(self._loops.slope, trial, pressure, height, results=1).sum())

    def curvature(self, trial: Array, pressure: Array, ahead: Array, displacement: Array) -> float:
        """As :meth:`ArrayPasses.curvature`."""
        fields = trial, pressure, ahead, displacement
        return float(_rows(self._loops.curvature, *fields, results=1).sum())

    def meets_a_limit(self, trial: Array, pressure: Array, factor: float) -> bool:
        """As :meth:`ArrayPasses.meets_a_limit`."""
        fields = trial, pressure, factor, self._limit
        return bool(_rows(self._loops.beyond, *fields, results=1).any())

    def advance(
        self, trial: Array, pressure: Array, ahead: Array, displacement: Array, share: float
    ) -> None:
        """As :meth:`ArrayPasses.advance`."""
        _rows(self._loops.advance, trial, pressure, ahead, displacement, share, self._limit)


Passes = ArrayPasses | CompiledPasses


def passes_for(constraint: Constraint, shape: tuple[int, ...]) -> Passes:
    """Return the passes over fields of that `shape` (x, y): compiled ones where they are there and pay."""
    loops = compiled_loops(shape)
    if loops is not None and isinstance(constraint, Compressive | HardnessLimited):
        return CompiledPasses(constraint, loops)
    return ArrayPasses(constraint)


def _rows(kernel: Callable[..., object], *arguments: Any, results: int = 0) -> Array:
    """Return what a compiled `kernel` over fields (x, y), its first `arguments`, finds in each row, (`results`, x).

    It gets a thread's part of each field, other arguments as they are, and last that part of an array
    for its results, if it has any: one call for each thread.
    """
    shape = arguments[0].shape
    values = np.empty((shape[0], results))
    if shape[0] * shape[1] < 2 * PART or threads() == 1:
        kernel(*arguments, *([values] if results else []))
        return values.T

    def some(rows: slice) -> None:
        parts = [one[rows] if isinstance(one, np.ndarray) else one for one in arguments]
        kernel(*parts, *([values[rows]] if results else []))

    in_parts(some, shape)
    return values.T

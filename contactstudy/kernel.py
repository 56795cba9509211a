"""Influence coefficients on a grid: every offset within one period, all images a padding sees."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contactstudy.arrays import Array
from contactstudy.doubly_periodic import boussinesq_cell_doubly_periodic
from contactstudy.grid import Grid
from contactstudy.influence import boussinesq_cell, boussinesq_cell_periodic
from contactstudy.padding import Padding, Paddings


@dataclass(frozen=True)
class _Axis:
    cells: int
    step: float
    period: float
    padding: Padding

    @property
    def known(self) -> int:
        """Offsets that hold all there is to know: the rest of a circle is its mirror image."""
        return self.cells // 2 + 1 if self.padding.wraps else self.cells

    @property
    def offsets(self) -> Array:
        return np.arange(float(self.known)) * self.step


def kernel(grid: Grid, paddings: Paddings, datum: float) -> Array:
    """Influence coefficients [m] at offsets of 0, 1, 2 ... cells, even along both axes.

    Along an axis of n cells that wraps there are ``n // 2 + 1`` offsets, along another n. ``datum`` [m]:
    the lateral distance from which displacement is counted, where images without end along one
    axis leave that open; along both it is counted from its mean.
    """
    axes = zip(grid.cells, grid.cell, grid.extent, paddings, strict=True)
    across, along = (_Axis(*axis) for axis in axes)
    return _kernel(across, along, datum)


def _kernel(across: _Axis, along: _Axis, datum: float) -> Array:
    cell = across.step, along.step
    if across.padding.window is None:
        if along.padding.window is not None:
            return _kernel(along, across, datum).T
        x, y = across.offsets[:, None], along.offsets
        return boussinesq_cell_doubly_periodic(x, y, *cell, across.period, along.period)

    def columns(x: Array) -> Array:
        if along.padding.window is None:
            shift = 2 * cell[0] * cell[1] / along.period * np.log(datum)
            images = boussinesq_cell_periodic(x[:, None], along.offsets, *cell, along.period)
            return np.asarray(shift + images)
        return _summed(lambda y: boussinesq_cell(x, y[:, None], *cell), along).T

    return _summed(columns, across)


def _summed(at: Callable[[Array], Array], axis: _Axis) -> Array:
    """The sum of ``at(d + m L)`` over the periods m of the axis's window, for its known offsets d.

    ``at`` is even, and takes distances along its first axis. So the offsets of one period serve two
    images: the one ahead and, read backwards, the next one behind. Far images first: small terms add
    up before they meet the large ones.
    """
    window, count = axis.padding.window, axis.cells
    assert window is not None
    total: Array | float = 0.0
    for period in range(max(window[-1], -window[0] - 1), -1, -1):
        ahead, behind = period in window, -period - 1 in window
        distances = np.arange(count + 1.0) if behind else np.arange(float(axis.known))
        block = at((period * count + distances) * axis.step)
        total = total + (block[: axis.known] if ahead else 0.0)
        total = total + (block[: -axis.known - 1 : -1] if behind else 0.0)
    return np.asarray(total)

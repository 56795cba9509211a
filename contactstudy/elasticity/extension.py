"""A displacement known in the contact, extended to all cells with little energy."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from contactstudy.domain.arrays import Array

# The weight of a block is this times the sum of the weights of its parts, and at most 1: for blocks made
# of 2 x 2 parts and of 2. An island of one cell thus loses weight a little faster than its capacity falls.
IN_SQUARES, IN_STRIPS = 0.35, 0.8
# Blocks grow along both axes while neither side of a part is longer than the other by more.
LONGER = 2**0.5


@dataclass(frozen=True, eq=False)
class _Level:
    """Parts of blocks: their weights, the rest to 1, and one over the sum of weights in each block.

    Two parts along each of some axes make a block; the last part of an odd number is a block alone.
    """

    weight: Array
    rest: Array
    inverse: Array
    axes: tuple[int, ...]

    def mean(self, parts: Array) -> Array:
        """Of ``parts``, times their weights already, over blocks."""
        for axis in self.axes:
            parts = _summed(parts, axis)
        parts *= self.inverse
        return parts

    def mean_transposed(self, blocks: Array) -> Array:
        """The transpose of :meth:`mean`, and the weights."""
        blocks *= self.inverse
        for axis in self.axes:
            blocks = _repeated(blocks, axis, self.weight.shape[axis])
        blocks *= self.weight
        return blocks

    def filled(self, blocks: Array) -> Array:
        """What parts take from their blocks: a field linear between the middles, times the rest."""
        for axis in self.axes:
            blocks = _interpolated(blocks, axis, self.weight.shape[axis])
        blocks *= self.rest
        return blocks

    def filled_transposed(self, parts: Array) -> Array:
        """The transpose of :meth:`filled`."""
        parts = parts * self.rest
        for axis in reversed(self.axes):
            parts = _gathered(parts, axis)
        return parts


class Extension:
    """A linear map from displacements of the cells in contact to displacements of all cells.

    The stiffness of a contact is that of the whole surface under the displacement outside which takes
    the least energy. Outside, this map takes means over the contact in blocks of 2, 4, 8 ... cells, each with
    a weight for how firmly the contact holds the block: a small gap follows the contact around
    it, far cells the mean of a wide block. ``contact`` (x, y) is 1 in the contact and 0 elsewhere;
    ``elongation`` is the length of a cell along y over that along x. Blocks wrap round the grid.

    Source: fictitious domains Nepomnyaschikh (1992); averages over blocks Gortler, Grzeszczuk, Szeliski &
    Cohen (1996), sect. 3.4; weights by capacity are of this package.
    """

    def __init__(self, contact: Array, elongation: float) -> None:
        self._levels: list[_Level] = []
        weight = contact
        while max(weight.shape) > 1:
            axes = _axes(weight.shape, elongation)
            total = weight
            for axis in axes:
                total = _summed(total, axis)
            inverse = np.divide(1, total, out=np.zeros_like(total), where=total > 0)
            self._levels.append(_Level(weight, 1 - weight, inverse, axes))
            total *= IN_SQUARES if len(axes) == 2 else IN_STRIPS
            weight = np.minimum(total, 1, out=total)
            elongation *= 2.0 ** (axes.count(1) - axes.count(0))

    def __call__(self, displacement: Array) -> Array:
        """``displacement`` (x, y), which is zero outside the contact, extended."""
        held, field = [displacement], displacement
        for level, next_level in pairwise(self._levels):
            held.append(level.mean(held[-1]) * next_level.weight)
        for number, level in enumerate(reversed(self._levels)):
            field = level.mean(held[-1]) if number == 0 else field
            field = level.filled(field)
            field += held.pop()
        return field

    def transposed(self, pressure: Array) -> Array:
        """The transposed map: a ``pressure`` (x, y) on all cells, gathered to those of the contact."""
        held = []
        for level in self._levels:
            held.append(level.weight * pressure)
            pressure = level.filled_transposed(pressure)
        for level in reversed(self._levels):
            pressure = level.mean_transposed(pressure)
            pressure += held.pop()
        return pressure


def _axes(shape: tuple[int, ...], elongation: float) -> tuple[int, ...]:
    """The axes along which parts make blocks: those on which a part is not the longer, by far."""
    across = shape[0] > 1 and (shape[1] == 1 or elongation > 1 / LONGER)
    along = shape[1] > 1 and (shape[0] == 1 or elongation < LONGER)
    return (0,) * across + (1,) * along


def _pairs(field: Array, axis: int) -> tuple[Array, Array]:
    """The first and the second of each pair, of which there may be one fewer."""
    return (field[0::2], field[1::2]) if axis == 0 else (field[:, 0::2], field[:, 1::2])


def _head(field: Array, like: Array, axis: int) -> Array:
    """As much of ``field`` as there is of ``like``."""
    return field[: len(like)] if axis == 0 else field[:, : like.shape[1]]


def _summed(field: Array, axis: int) -> Array:
    first, second = _pairs(field, axis)
    blocks = first.copy()
    _head(blocks, second, axis)[...] += second
    return blocks


def _repeated(blocks: Array, axis: int, count: int) -> Array:
    """The transpose of :func:`_summed`."""
    parts = _longer(blocks, axis, count)
    first, second = _pairs(parts, axis)
    first[...] = blocks
    second[...] = _head(blocks, second, axis)
    return parts


def _interpolated(blocks: Array, axis: int, count: int) -> Array:
    """Linear between the middles of blocks, once round."""
    parts = _longer(blocks, axis, count)
    first, second = _pairs(parts, axis)
    near, far = 0.75 * blocks, 0.25 * blocks
    np.add(near, np.roll(far, 1, axis), out=first)
    near += np.roll(far, -1, axis)
    second[...] = _head(near, second, axis)
    return parts


def _gathered(parts: Array, axis: int) -> Array:
    """The transpose of :func:`_interpolated`."""
    first, short = _pairs(parts, axis)
    second = np.zeros_like(first)
    _head(second, short, axis)[...] = short
    blocks = first + second
    blocks *= 0.75
    second *= 0.25
    blocks += np.roll(second, 1, axis)
    blocks += np.roll(0.25 * first, -1, axis)
    return blocks


def _longer(blocks: Array, axis: int, count: int) -> Array:
    shape = (count, blocks.shape[1]) if axis == 0 else (blocks.shape[0], count)
    return np.empty(shape, dtype=blocks.dtype)

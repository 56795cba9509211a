"""From the displacement of a contact to a pressure on it: the preconditioner of a contact problem.

The displacement known in the contact is extended to all cells with little energy, divided by the spectrum of the
periodic grid, and gathered to the contact again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from contactstudy.domain.device import arrays, device, fused
from contactstudy.domain.fields import Array, compiled, in_blocks, in_parts
from contactstudy.elasticity.transforms import Waves, transforms

# The weight of a block is this times the sum of the weights of its parts, and at most 1: for blocks made
# of 2 x 2 parts and of 2. An island of one cell thus loses weight a little faster than its capacity falls.
IN_SQUARES, IN_STRIPS = 0.35, 0.8
# Blocks grow along both axes while neither side of a part is longer than the other by more.
LONGER = 2**0.5


@dataclass(frozen=True, eq=False)
class _Level:
    """Parts of blocks: their weights, and one over the sum of weights in each block.

    Two parts along each of some axes make a block; the last part of an odd number is a block alone. All
    maps work through blocks of rows.
    """

    weight: Array
    inverse: Array
    axes: tuple[int, ...]

    def mean(self, parts: Array) -> Array:
        """Of ``parts``, times their weights already, over blocks."""
        means = arrays().empty_like(self.inverse)
        kernels, two = fused(), self._two
        if kernels is not None:
            self._on_blocks(kernels.means, parts, two, self.inverse, means)
            return means

        def some(rows: slice) -> None:
            out = self._blocks(rows)
            means[out, :] = _summed(parts[rows, :], self.axes) * self.inverse[out, :]

        in_blocks(some, parts.shape)
        return means

    def gathered_means(self, blocks: Array, pressure: Array) -> Array:
        """The transpose of :meth:`mean`, and of what parts keep of the ``pressure``, in place of that."""
        blocks *= self.inverse
        kernels, two = fused(), self._two
        if kernels is not None:
            self._on_parts(kernels.gathered, blocks, two, self.weight, pressure)
            return pressure

        def some(rows: slice) -> None:
            own = pressure[rows, :]
            own += _repeated(blocks[self._blocks(rows), :], self.axes, own.shape)
            own *= self.weight[rows, :]

        in_blocks(some, pressure.shape)
        return pressure

    def filled(self, blocks: Array, held: Array) -> Array:
        """``held``, and what parts lack of weight from ``blocks``, linear between their middles."""
        xp, kernels, two = arrays(), fused(), self._two
        field = xp.empty_like(held)
        if kernels is not None:
            self._on_parts(kernels.filled, blocks, two, self.weight, held, field)
            return field

        def some(rows: slice) -> None:
            out, count = self._blocks(rows), blocks.shape[0]
            # one more at either end, once round
            around = (out.start - 1, out.stop + 1) if 0 in self.axes else (out.start, out.stop)
            near = xp.take(blocks, xp.arange(*around) % count, axis=0)
            if 1 in self.axes:
                near = _interpolated(near, 1, held.shape[1])
            if 0 in self.axes:
                near = _interpolated(near, 0, 2 * near.shape[0])
                near = near[2 : 2 + rows.stop - rows.start, :]
            near *= 1 - self.weight[rows, :]
            near += held[rows, :]
            field[rows, :] = near

        in_blocks(some, held.shape)
        return field

    def spilled(self, pressure: Array) -> Array:
        """What the transpose of :meth:`filled` gives to the blocks."""
        xp, kernels, two = arrays(), fused(), self._two
        blocks = xp.empty_like(self.inverse)
        count = pressure.shape[0]
        if kernels is not None:
            self._on_blocks(kernels.spilled, pressure, two, self.weight, blocks)
            return blocks

        def some(rows: slice) -> None:
            if 0 not in self.axes:
                summed = (1 - self.weight[rows, :]) * pressure[rows, :]
            else:
                out = self._blocks(rows)
                begin, end = 2 * out.start - 1, 2 * out.stop + 1
                if begin >= 0 and end <= count:
                    parts = 1 - self.weight[begin:end, :]
                    parts *= pressure[begin:end, :]
                else:
                    index = xp.arange(begin, end) % (2 * blocks.shape[0])
                    # an odd number lacks the last part
                    index, there = xp.where(index < count, index, 0), index < count
                    parts = 1 - xp.take(self.weight, index, axis=0)
                    parts *= xp.take(pressure, index, axis=0)
                    parts *= xp.astype(there, parts.dtype)[:, None]
                summed = parts[1:-1:2, :] + parts[2:-1:2, :]
                summed *= 0.75
                far = parts[0:-2:2, :] + parts[3::2, :]
                far *= 0.25
                summed += far
            blocks[self._blocks(rows), :] = _gathered(summed) if 1 in self.axes else summed

        in_blocks(some, pressure.shape)
        return blocks

    @property
    def _two(self) -> tuple[bool, bool]:
        """Whether blocks have two parts along each axis."""
        return 0 in self.axes, 1 in self.axes

    def _on_parts(self, kernel: Callable[..., None], *arguments: Any) -> None:
        """A compiled pass over rows of parts, some for each thread."""
        in_parts(lambda rows: kernel(*arguments, rows.start, rows.stop), self.weight.shape)

    def _on_blocks(self, kernel: Callable[..., None], *arguments: Any) -> None:
        """The same over rows of blocks."""

        def some(rows: slice) -> None:
            own = self._blocks(rows)
            kernel(*arguments, own.start, own.stop)

        in_parts(some, self.weight.shape)

    def _blocks(self, rows: slice) -> slice:
        """The rows of blocks that these rows of parts make."""
        return slice(rows.start // 2, -(-rows.stop // 2)) if 0 in self.axes else rows


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
            level, weight = _coarser(weight, _axes(weight.shape, elongation))
            self._levels.append(level)
            elongation *= 2.0 ** (level.axes.count(1) - level.axes.count(0))

    def __call__(self, displacement: Array) -> Array:
        """``displacement`` (x, y), which is zero outside the contact, extended."""
        held, field = [displacement], displacement
        for level, coarser in pairwise(self._levels):
            held.append(level.mean(held[-1]))
            held[-1] *= coarser.weight
        for number, level in enumerate(reversed(self._levels)):
            field = level.mean(held[-1]) if number == 0 else field
            field = level.filled(field, held.pop())
        return field

    def transposed(self, pressure: Array) -> Array:
        """The transposed map: a ``pressure`` (x, y) on all cells gathered to those of the contact, in place."""
        spilled = []
        for level in self._levels:
            spilled.append(pressure)
            pressure = level.spilled(pressure)
        for level in reversed(self._levels):
            pressure = level.gathered_means(pressure, spilled.pop())
        return pressure


def _coarser(weight: Array, axes: tuple[int, ...]) -> tuple[_Level, Array]:
    """The parts with these weights, and the weights of the blocks they make."""
    xp = arrays()
    shape = tuple(-(-n // 2) if axis in axes else n for axis, n in enumerate(weight.shape))
    blocks, inverse = (xp.empty(shape, dtype=weight.dtype) for _ in range(2))
    level = _Level(weight, inverse, axes)
    factor = IN_SQUARES if len(axes) == 2 else IN_STRIPS

    kernels, two = fused(), level._two
    if kernels is not None:
        level._on_blocks(kernels.weights, weight, two, factor, inverse, blocks)
        return level, blocks

    def some(rows: slice) -> None:
        out = level._blocks(rows)
        total = _summed(weight[rows, :], axes)
        # no weight at all is no part of any mean
        inverse[out, :] = 1 / xp.where(total > 0, total, inf)
        blocks[out, :] = xp.minimum(factor * total, 1)

    in_blocks(some, weight.shape)
    return level, blocks


def _axes(shape: tuple[int, ...], elongation: float) -> tuple[int, ...]:
    """The axes along which parts make blocks: those on which a part is not the longer, by far."""
    across = shape[0] > 1 and (shape[1] == 1 or elongation > 1 / LONGER)
    along = shape[1] > 1 and (shape[0] == 1 or elongation < LONGER)
    return (0,) * across + (1,) * along


def _summed(parts: Array, axes: tuple[int, ...]) -> Array:
    for axis in axes:
        first, second = _pairs(parts, axis)
        if first.shape == second.shape:
            parts = first + second
        else:
            parts = arrays().asarray(first, copy=True)
            head = _head(parts, second, axis)
            head += second
    return parts


def _repeated(blocks: Array, axes: tuple[int, ...], shape: tuple[int, ...]) -> Array:
    """The transpose of :func:`_summed`."""
    for axis in axes:
        parts = _longer(blocks, axis, shape[axis])
        first, second = _pairs(parts, axis)
        first[...] = blocks
        second[...] = _head(blocks, second, axis)
        blocks = parts
    return blocks


def _interpolated(blocks: Array, axis: int, count: int) -> Array:
    """Linear between the middles of blocks, once round."""
    parts = _longer(blocks, axis, count)
    along = [0.75 * blocks, 0.25 * blocks, *_pairs(parts, axis)]
    near, far, first, second = along if axis else [field.T for field in along]
    first[:, 1:] = near[:, 1:] + far[:, :-1]
    first[:, :1] = near[:, :1] + far[:, -1:]
    last = near.shape[1] - 1
    second[:, :last] = near[:, :last] + far[:, 1:]
    if second.shape[1] > last:
        second[:, last:] = near[:, last:] + far[:, :1]
    return parts


def _gathered(parts: Array) -> Array:
    """The transpose of :func:`_interpolated` along y."""
    first, second = _pairs(parts, 1)
    blocks = 0.75 * _summed(parts, (1,))
    before, after = 0.25 * second, 0.25 * first
    last = blocks.shape[1] - 1
    blocks[:, 1:] += before[:, :last]
    if before.shape[1] > last:
        blocks[:, :1] += before[:, last:]
    blocks[:, :last] += after[:, 1:]
    blocks[:, last:] += after[:, :1]
    return blocks


def _pairs(field: Array, axis: int) -> tuple[Array, Array]:
    """The first and the second of each pair, of which there may be one fewer."""
    return (field[0::2, :], field[1::2, :]) if axis == 0 else (field[:, 0::2], field[:, 1::2])


def _head(field: Array, like: Array, axis: int) -> Array:
    """As much of ``field`` as there is of ``like``."""
    return field[: like.shape[0], :] if axis == 0 else field[:, : like.shape[1]]


def _longer(blocks: Array, axis: int, count: int) -> Array:
    shape = (count, blocks.shape[1]) if axis == 0 else (blocks.shape[0], count)
    return arrays().empty(shape, dtype=blocks.dtype)


# Single precision has noise in all waves: in the shortest, times this, it may be as large as the longest are.
WIDEST = 1e4


class ApproximateInverse:
    """Division by a ``spectrum`` on the unpadded grid of so many ``cells``, as if it were periodic.

    The displacement of the contact is extended to all cells first, and the pressure found on all
    cells is gathered to the contact by the transposed map, or a fragmented contact would seem far too
    stiff: by more with every halving of the cells. The mean over the grid is mapped to zero. ``room`` gives
    the work array of a transform. It works in ``real`` numbers of this type, if their digits span the range of the
    spectrum: a preconditioner needs few.

    Source: Vollebregt (2014), eq. 20, there on the padded grid and with zeros outside the contact.
    """

    def __init__(
        self,
        spectrum: Array,
        cells: tuple[int, int],
        room: Callable[[tuple[int, int], DTypeLike], Waves | None],
        real: DTypeLike,
    ) -> None:
        xp = arrays()
        inverse = 1 / spectrum
        inverse[0, 0] = 0.0
        if float(xp.max(inverse)) * float(xp.max(spectrum)) > WIDEST:
            real = spectrum.dtype
        self._inverse, self.real = xp.astype(inverse, real, copy=False), real
        self._cells, self._room = cells, room
        # displacements fall like wave numbers grow, so that the shortest waves tell the cell's sides
        self._elongation = float(spectrum[0, -1]) / float(spectrum[cells[0] // 2, 0])

    @property
    def work(self) -> float:
        """Cells transformed in one application."""
        return float(self._cells[0] * self._cells[1])

    def extension(self, contact: Array) -> Extension:
        """From the displacement of a ``contact`` (x, y), which is 1 there and 0 elsewhere, to that of all cells."""
        return Extension(contact, self._elongation)

    def waves(self, displacement: Array) -> Waves:
        """Waves of the pressure on all cells that makes a ``displacement`` (x, y) of all cells."""
        room = self._room(self._cells, self.real)
        waves = transforms().forward(displacement, self._cells, room)
        scale(waves, self._inverse)
        return waves

    def pressure(self, waves: Waves) -> Array:
        """The pressure (x, y) with these ``waves``, which are lost."""
        return transforms().backward(waves, self._cells, self._cells)

    def __call__(self, displacement: Array, contact: Array) -> Array:
        """The pressure on a ``contact`` with this ``displacement`` (x, y), which is zero elsewhere."""
        extension = self.extension(contact)
        return extension.transposed(self.pressure(self.waves(extension(displacement))))


def sampled(spectrum: Array, cells: tuple[int, int], padded: tuple[int, int]) -> Array:
    """The spectrum of a padded grid at the waves of the unpadded one, above zero."""
    xp, put = arrays(), device().put
    (nx, ny), (px, py) = cells, padded
    across = np.round(np.arange(nx) * (px / nx)).astype(int) % px
    along = np.minimum(np.round(np.arange(ny // 2 + 1) * (py / ny)).astype(int), py // 2)
    found = xp.take(xp.take(spectrum, put(across), axis=0), put(along), axis=1)
    # a window of images may make a coefficient zero or negative; that of the half-space is positive
    sizes = xp.abs(found)
    smallest = float(xp.min(sizes[1:, :])) if nx > 1 else float(xp.max(sizes))
    return xp.maximum(found, 1e-3 * smallest)


def scale(waves: Waves, factors: Array) -> None:
    """Multiply ``waves`` in place."""
    kernels = fused()
    if kernels is not None and np.isrealobj(factors):
        compiled(kernels.scale, waves.view(factors.dtype), factors)
        return

    def some(rows: slice) -> None:
        own = waves[rows, :]
        own *= factors[rows, :]

    in_blocks(some, waves.shape)

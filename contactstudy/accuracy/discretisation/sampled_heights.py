"""Heights sampled inside the cells of one axis: what a cubic through the centres misses, corners and kinks."""

from dataclasses import dataclass
from functools import cache, cached_property
from math import log, prod

import numpy as np

from contactstudy.accuracy.discretisation.cells import with_ends
from contactstudy.domain.fields import Array, matrix_product


@dataclass(frozen=True)
class CornerConstants:
    """Constants that tell corners and kinks from smooth bends.

    Attributes
    ----------
    corner_fraction
        Fraction of the slope change between two neighbouring points that their neighbours do not have, from which it
        is a corner.
    smooth_power
        Power n - 1 of a height ``|x|^n`` from which a bend counts as smooth.
    min_power
        Least such power that is not a corner.
    """

    corner_fraction: float = 0.7
    smooth_power: float = 0.95
    min_power: float = 0.1


CONSTANTS = CornerConstants()
# The cubic through the last four points of a row, at the second and the first place beyond them.
BEYOND = np.array([[10.0, -20.0, 15.0, -4.0], [4.0, -6.0, 4.0, -1.0]])


@dataclass(frozen=True)
class SampledHeights:
    """Heights inside the cells along one axis, of shapes (n, ...) for n cells.

    Attributes
    ----------
    missed
        What a cubic through the centres misses in each cell [m].
    slope_changes
        Change of the slope at each point (n points, ...), above zero where it points out of the body.
    wraps
        Whether the axis is periodic.
    padded
        Heights at the centres, and at two more at either end (n + 4, ...) [m].
    heights
        Heights inside the cells (n, points, ...) [m].
    """

    missed: Array
    slope_changes: Array
    wraps: bool
    padded: Array
    heights: Array

    @classmethod
    def from_heights(
        cls, centres: Array, inside: Array, step: float, *, wraps: bool
    ) -> "SampledHeights":
        """Return what heights (n, ...) at the centres, and (n points, ...) inside cells of width `step`, show [m]."""
        count = len(centres)
        points = len(inside) // count
        padded = np.ascontiguousarray(extended_by_two(centres, wraps=wraps))
        inside = np.ascontiguousarray(inside)  # along the length they are not, which takes longer
        heights = inside.reshape(count, points, -1)
        missed = cubics(padded, tuple((point + 0.5) / points - 0.5 for point in range(points)))
        missed -= heights.swapaxes(0, 1)
        missed = np.abs(missed, out=missed).max(axis=0)
        slope_changes = np.diff(with_ends(inside, 1, wraps=wraps), n=2, axis=0)
        rounding = 8 * np.finfo(float).eps * max(inside.max(), -inside.min())
        slope_changes[np.abs(slope_changes) < rounding] = 0.0
        slope_changes *= points / step
        if not wraps:
            slope_changes[[0, -1]] = 0.0
        return cls(missed, slope_changes, wraps, padded, heights)

    @property
    def protrusion(self) -> Array:
        """Heights above the centres of a cell and its neighbours (n, ...) [m]; a step between centres is not hidden."""
        lowest = np.minimum(np.minimum(self.padded[1:-3], self.padded[2:-2]), self.padded[3:-1])
        return np.asarray(np.maximum(lowest - self.heights.min(axis=1), 0))

    @cached_property
    def _outward(self) -> Array:
        """Slope changes that point out of the body (n points, ...); zero elsewhere."""
        return np.maximum(self.slope_changes, 0)

    @cached_property
    def _in_cells(self) -> tuple[Array, Array]:
        """Outward slope changes of pairs of neighbours (n points, ...), and the same by cells (n, points, ...)."""
        slope_changes = self._outward
        pairs = np.empty_like(slope_changes)
        np.add(slope_changes[:-1], slope_changes[1:], out=pairs[:-1])
        np.add(slope_changes[-1], slope_changes[0], out=pairs[-1])
        return pairs, pairs.reshape(len(self.missed), -1, *pairs.shape[1:])

    def corner(self) -> Array:
        """Return the slope of the corner in each cell (n, ...), 0 where its bend is that of a smooth surface.

        A corner bends between two neighbouring points alone, and more than the mean of its cell; a smooth surface bends
        as much on either side.
        """
        all_pairs, pairs = self._in_cells
        slope_changes = np.abs(self.slope_changes)
        slope = all_pairs - np.roll(slope_changes, 1, axis=0) - np.roll(slope_changes, -2, axis=0)
        slope[slope <= CONSTANTS.corner_fraction * all_pairs] = 0.0
        steepest = slope.reshape(pairs.shape).max(axis=1)
        usual = slope_changes.reshape(pairs.shape).mean(axis=1)
        return np.where(steepest > usual, steepest, 0.0)

    def kink(self) -> Array:
        """Return the slope of the corner that stands for a height ``|x|^n`` in each cell (n, ...), 0 without one.

        At each halving of the cells the pressure under such a height rises by ``2^(1 - n)`` of the rise before. The sum
        of all rises, a geometric series, is the rise at one halving under a corner with the slope change of the cell
        over ``1 - 2^(1 - n)``. The power n follows from the fraction ``(w / W)^(n - 1)`` of the slope change over a cell
        W that lies within w about the apex.
        """
        from scipy import ndimage  # imported late, since it is slow

        all_pairs, pairs = self._in_cells
        points = pairs.shape[1]
        strongest = pairs.max(axis=1)
        # the bend within half a cell to either side of each pair
        sums = np.cumsum(with_ends(self._outward, points // 2, wraps=self.wraps), axis=0)
        around = np.concatenate([sums[points - 1 : points], sums[points:] - sums[:-points]])
        apex = pairs.argmax(axis=1)[:, None]
        around = around[: len(all_pairs)].reshape(pairs.shape)
        about = np.take_along_axis(around, apex, axis=1)[:, 0]
        fraction = np.divide(strongest, about, out=np.ones_like(about), where=about > 0)
        power = np.log(np.maximum(fraction, 1 / points)) / log(2 / points)
        power = np.maximum(power, CONSTANTS.min_power)
        # an apex bends more than all about it; where a bend begins, half of the window is straight
        highest = ndimage.maximum_filter1d(all_pairs, points + 1, axis=0, mode="nearest")
        window_peak = np.take_along_axis(highest.reshape(pairs.shape), apex, axis=1)[:, 0]
        is_apex = (strongest > 0) & (strongest >= window_peak) & (power < CONSTANTS.smooth_power)
        if not self.wraps:
            is_apex[[0, -1]] = False
        return np.where(is_apex, about / (1 - 2**-power), 0.0)


def cubics(extended: Array, positions: tuple[float, ...]) -> Array:
    """Return the cubics through four neighbouring points, at `positions` in cells from each centre (places, n, lines).

    The points (n + 4, lines) are the centres, `extended` by two at either end.
    """
    count = len(extended) - 4
    nodes = np.stack([extended[node : node + count] for node in range(5)])
    weights = np.array([_weights(position) for position in positions])
    return matrix_product(weights, nodes.reshape(5, -1)).reshape(len(positions), *nodes.shape[1:])


@cache
def _weights(position: float) -> tuple[float, ...]:
    """Return the weights of a centre and two more on either side in the cubic at a `position`; one of five is zero."""
    nodes = range(-1, 3) if position > 0 else range(-2, 2)
    return tuple(
        prod((position - near) / (node - near) for near in nodes if near != node)
        if node in nodes
        else 0.0
        for node in range(-2, 3)
    )


def extended_by_two(centres: Array, *, wraps: bool) -> Array:
    """Return `centres` (n, lines) with two more at either end: periodic ones where it wraps, else of the last cubic.

    Fewer than four centres have no cubic: the last one is repeated.
    """
    padded = with_ends(centres, 2, wraps=wraps)
    if not wraps and len(centres) >= 4:
        for side in (padded, padded[::-1]):
            side[:2] = matrix_product(BEYOND, side[2:6])
    return padded

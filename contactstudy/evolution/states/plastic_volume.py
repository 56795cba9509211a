"""Cells below the surface that may yield: layers, the first volume, and how volumes grow."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.elasticity.eigenstrain.volume import Volume

# The first volume holds the columns of cells in contact, those whose elastic von Mises stress is anywhere above
# NEAR_YIELD of the yield stress, and a MARGIN of their width on both sides. Since a step is repeated in a larger volume
# where yield reaches its edge, these constants change the time and not the accuracy.
NEAR_YIELD, MARGIN = 0.9, 0.15
# Fraction of its width or depth by which a volume then grows.
GROWTH = 0.3


def layers(grid: Grid, length: float, depth: float) -> tuple[float, ...]:
    """Return the depths [m] of the edges of layers from 0 to at least `depth`, and of one more layer.

    A layer is as thick as a cell is wide down to the depth `length`, twice that down to ``3 length``, four times that
    down to ``7 length``, and so on, so that errors of layers and of cells fall alike and an operator is made once for
    each thickness. A larger depth adds layers and leaves the others unchanged.

    Parameters
    ----------
    grid
        Grid of the surface.
    length
        Length scale of the contact [m], such as its half-width.
    depth
        Depth that the layers cover [m].
    """
    edges, thickness = [0.0], grid.cell_size[0]
    while edges[-1] < depth:
        edges.append(edges[-1] + thickness)
        if edges[-1] >= (2 * thickness / grid.cell_size[0] - 1) * length:
            thickness *= 2
    return (*edges, edges[-1] + thickness)


def first_volume(grid: Grid, length: float, pressure: Array, yield_ratio: Callable[[Volume], Array]) -> Volume:
    """Return the cells below an elastic contact that may yield.

    They reach down to a layer in which the von Mises stress is below `NEAR_YIELD` of the yield stress, or, if it is so
    everywhere, below its maximum.

    Parameters
    ----------
    grid
        Grid of the surface.
    length
        Length scale of the contact [m], for which layers are made.
    pressure
        Elastic pressure (x, y) [Pa] under the largest load.
    yield_ratio
        Returns the von Mises stress over the yield stress (layers, x, y) in a volume.
    """
    loaded = np.flatnonzero(pressure.any(axis=1))
    first, last = (int(loaded[0]), int(loaded[-1]) + 1) if loaded.size else (0, grid.cells[0])
    depth = min(length, (last - first) * grid.cell_size[0] / 2)
    while True:
        volume = Volume(grid, 0, grid.cells[0], layers(grid, length, depth))
        ratio = yield_ratio(volume).max(axis=2)
        if ratio[-1].max() < min(NEAR_YIELD, ratio.max()) or depth > grid.extent[0]:
            break
        depth *= 1 + GROWTH
    near_yield = np.flatnonzero((ratio > NEAR_YIELD).any(axis=0))
    if near_yield.size:
        first, last = min(first, int(near_yield[0])), max(last, int(near_yield[-1]) + 1)
    margin = int(np.ceil(MARGIN * (last - first))) + 1
    return replace(volume, first=max(first - margin, 0), last=min(last + margin, grid.cells[0]))


def enlarged(volume: Volume, length: float, yielded: NDArray[np.bool_]) -> Volume:
    """Return `volume` with more margin on every side where plastic flow reaches its edge, within its grid.

    Parameters
    ----------
    volume
        Cells that could yield.
    length
        Length scale of the contact [m], for which layers are made.
    yielded
        Whether a cell yielded (layers, x, y).
    """
    margin = int(np.ceil(GROWTH * (volume.last - volume.first)))
    first = max(volume.first - margin, 0) if yielded[:, 0].any() else volume.first
    last = min(volume.last + margin, volume.grid.cells[0]) if yielded[:, -1].any() else volume.last
    edges = volume.edges
    if yielded[-1].any():
        edges = layers(volume.grid, length, (1 + GROWTH) * edges[-1])
    return Volume(volume.grid, first, last, edges)


def union(one: Volume, other: Volume) -> Volume:
    """Return the smallest volume that holds two of the same grid, whose layers are equal as far as both reach."""
    edges = max(one.edges, other.edges, key=len)
    return Volume(one.grid, min(one.first, other.first), max(one.last, other.last), edges)


def embedded(field: Array, first: int, volume: Volume) -> Array:
    """Return a field in a larger volume, with zeros in the added cells.

    Parameters
    ----------
    field
        Values (..., layers, x, y) in a smaller volume.
    first
        First cell across of the smaller volume.
    volume
        The larger volume.
    """
    depth, across = field.shape[-3:-1]
    values = np.zeros((*field.shape[:-3], *volume.shape))
    start = first - volume.first
    values[..., :depth, start : start + across, :] = field
    return values

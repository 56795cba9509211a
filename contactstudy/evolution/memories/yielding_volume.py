"""Which cells below the surface may yield, and how deep their layers reach."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.elasticity.eigenstrain.volume import Volume

# The first volume holds what the elastic stress makes bear this share of the yield stress, and some room.
SHARE, ROOM = 0.9, 0.15
# It is made so much larger on the side where it yields to its edge.
LARGER = 0.3


def layers(grid: Grid, length: float, depth: float) -> tuple[float, ...]:
    """Depths [m] between layers down to ``depth``, with one more below.

    A layer is as thick as a cell is wide down to the depth ``length``, twice that down to three times this depth, and
    so on, so that errors of layers and of cells fall alike: an operator is made once for each thickness. More
    depth adds layers and leaves the others as they are.
    """
    edges, thickness = [0.0], grid.cell[0]
    while edges[-1] < depth:
        edges.append(edges[-1] + thickness)
        if edges[-1] >= (2 * thickness / grid.cell[0] - 1) * length:
            thickness *= 2
    return (*edges, edges[-1] + thickness)


def first_volume(
    grid: Grid,
    length: float,
    pressure: Array,
    share_of_yield: Callable[[Volume], Array],
) -> Volume:
    """Below the contact of an elastic ``pressure`` (x, y), down to where von Mises' stress has become small.

    ``length`` [m] is that of the contact; ``share_of_yield`` is von Mises' stress over the yield
    stress (layers, x, y) in a volume.
    """
    bears = np.flatnonzero(pressure.any(axis=1))
    first, last = (int(bears[0]), int(bears[-1]) + 1) if bears.size else (0, grid.cells[0])
    depth = min(length, (last - first) * grid.cell[0] / 2)
    while True:
        volume = Volume(grid, 0, grid.cells[0], layers(grid, length, depth))
        share = share_of_yield(volume).max(axis=2)
        if share[-1].max() < min(SHARE, share.max()) or depth > grid.extent[0]:
            break
        depth *= 1 + LARGER
    high = np.flatnonzero((share > SHARE).any(axis=0))
    if high.size:
        first, last = min(first, int(high[0])), max(last, int(high[-1]) + 1)
    room = int(np.ceil(ROOM * (last - first))) + 1
    return replace(volume, first=max(first - room, 0), last=min(last + room, grid.cells[0]))


def larger(volume: Volume, length: float, flows: NDArray[np.bool_]) -> Volume:
    """``volume``, with more room on every side up to which it ``flows`` (layers, x, y), within its grid."""
    room = int(np.ceil(LARGER * (volume.last - volume.first)))
    first = max(volume.first - room, 0) if flows[:, 0].any() else volume.first
    last = min(volume.last + room, volume.grid.cells[0]) if flows[:, -1].any() else volume.last
    edges = volume.edges
    if flows[-1].any():
        edges = layers(volume.grid, length, (1 + LARGER) * edges[-1])
    return Volume(volume.grid, first, last, edges)


def both(one: Volume, other: Volume) -> Volume:
    """The smallest volume that holds both; their layers are the same as far as they reach."""
    edges = max(one.edges, other.edges, key=len)
    return Volume(one.grid, min(one.first, other.first), max(one.last, other.last), edges)


def spread(field: Array, first: int, volume: Volume) -> Array:
    """A field (..., layers, x, y) from cell ``first`` on, with zeros in the rest of a larger ``volume``."""
    layers, across = field.shape[-3:-1]
    whole = np.zeros((*field.shape[:-3], *volume.shape))
    start = first - volume.first
    whole[..., :layers, start : start + across, :] = field
    return whole

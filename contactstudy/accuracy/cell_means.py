"""A field of cell means on another grid of the same extent."""

import numpy as np

from contactstudy.domain.fields import Array


def on_cells(field: Array, cells: tuple[int, int]) -> Array:
    """The means over ``cells`` of a ``field`` (x, y) that is constant in each of its own cells."""
    for axis, count in enumerate(cells):
        along = np.moveaxis(field, axis, 0)
        own = len(along)
        if own == count:
            continue
        # the integral up to each border, linear inside a cell
        sums = np.concatenate([np.zeros((1, along.shape[1])), np.cumsum(along, axis=0)])
        border = np.arange(count + 1) * (own / count)
        whole = np.minimum(border.astype(int), own - 1)
        up_to = sums[whole] + (border - whole)[:, None] * along[whole]
        field = np.moveaxis(np.diff(up_to, axis=0) * (count / own), 0, axis)
    return field

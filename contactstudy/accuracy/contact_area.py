"""How far the area of the touching cells may be from the area in contact."""

import numpy as np

from contactstudy.accuracy.edge_law import edge_place
from contactstudy.domain.fields import Array

# Of a cell: how far the place of a single edge is uncertain, how far that of all in the mean, and how far
# that of a plateau's.
EACH, ALL, HALF = 0.35, 0.1, 0.65


def contact_area(pressure: Array, wraps: tuple[bool, bool]) -> float:
    """Relative error of the contact area, counted in cells that touch, by where its edges lie in their cells.

    ``pressure`` (x, y); ``wraps``: which axes close on themselves. A cell counts whole; the last two of a row
    tell where the smooth contact that they stand for ends (:mod:`~contactstudy.accuracy.edge_law`). Each
    axis tells it all, so the larger of both counts. Infinite where no area may be left.
    """
    touching, most = np.count_nonzero(pressure), 0.0
    for axis, closed in enumerate(wraps):
        along = np.moveaxis(pressure, axis, 0)
        if len(along) == 1:
            continue
        around = np.pad(along, ((1, 1), (0, 0)), mode="wrap" if closed else "edge")
        before, after = around[:-2], around[2:]
        beyond, unknown, ends = 0.0, 0.0, 0
        for outer, inner in ((before, after), (after, before)):
            end = (along > 0) & (outer == 0)
            # a plateau ends anywhere in the last cell, and where it is straight, everywhere alike
            plateau = end & (inner >= pressure.max())
            unknown += HALF * np.count_nonzero(plateau)
            end &= ~plateau
            beyond += float((0.5 - edge_place(along[end], inner[end])).sum())
            ends += int(np.count_nonzero(end))
        most = max(most, abs(beyond) + ALL * ends + EACH * ends**0.5 + unknown)
    share = most / touching
    return share / (1 - share) if share < 1 else float("inf")

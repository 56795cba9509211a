"""What cells of constant pressure cost, from the pressure they found."""

import numpy as np

from contactstudy.accuracy.edge_law import edge_error
from contactstudy.domain.fields import Array

# How far a maximum moves, over its second difference, with where the edges fall in their cells: by 1/16
# between two straight edges that fall alike; here a third more, for those that are neither.
EDGES = 1 / 12


def discretisation(pressure: Array, wraps: tuple[bool, bool]) -> tuple[float, float]:
    """Relative error of the peak pressure, and of all of it in L1, by the grid.

    ``pressure`` (x, y); ``wraps``: which axes close on themselves. The maximum lies beside a
    cell's centre, above it by the parabola through three cells, and the cell's pressure is a 24th of
    the second difference too high (its mean is right); the edges move both. In L1 each end of a row of touching
    cells adds what :func:`~contactstudy.accuracy.edge_law.edge_error` says of its last two, and each cell
    within that 24th. Both axes are added, since an edge that crosses the cells has ends on both. It
    sees what the pressure shows: heights between the cell centres leave no trace there.
    """
    highest = np.unravel_index(np.argmax(pressure), pressure.shape)
    level = float(pressure[highest])
    beside = edges = l1 = 0.0
    for axis, closed in enumerate(wraps):
        if pressure.shape[axis] == 1:
            continue
        along = np.moveaxis(pressure, axis, 0)
        # at an open end the cell stands for its own neighbour
        around = np.pad(along, ((1, 1), (0, 0)), mode="wrap" if closed else "edge")
        before, after = around[:-2], around[2:]
        bend = np.abs(before + after - 2 * along)
        within = (along > 0) & (before > 0) & (after > 0)
        l1 += bend[within].sum() / 24
        for outer, inner in ((before, after), (after, before)):
            end = (along > 0) & (outer == 0)
            l1 += edge_error(along[end], inner[end]).sum()
            # a plateau's last cell has the mean of what is half-way in it
            plateau = along[end & (inner >= level)]
            l1 += np.minimum(plateau, level - plateau).sum()
        slope, bent = (
            float(np.moveaxis(field, 0, axis)[highest]) for field in ((after - before) / 2, bend)
        )
        # the parabola's vertex is slope / bent cells away
        beside += slope**2 / bent / 2 - bent / 24 if bent > 0 else 0.0
        edges = max(edges, EDGES * bent)
    return (abs(beside) + edges) / level, float(l1 / pressure.sum())

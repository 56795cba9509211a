"""What cells of constant pressure cost, from the pressure they found."""

import numpy as np

from contactstudy.accuracy.contact_edge import edge_error, edge_place
from contactstudy.domain.fields import Array

# How far a maximum moves, over its second difference, with where the edges fall in their cells: by 1/16
# between two straight edges that fall alike; here a third more, for those that are neither.
EDGES = 1 / 12


def discretisation(pressure: Array, wraps: tuple[bool, bool]) -> tuple[float, float]:
    """Return the relative errors of the peak pressure and of the pressure in L1 that the cells cause.

    ``pressure`` has the shape (x, y); ``wraps`` says which axes close on themselves. The maximum lies beside a cell's
    centre, above it by the parabola through three cells, and the cell's pressure is a 24th of the second difference too
    high; the edges move both. In L1 each end of a row of touching cells adds what
    :func:`~contactstudy.accuracy.contact_edge.edge_error` says of its last two, and each cell within adds a 12th of its
    second difference: of a wave q the cells' pressure is ``1 / sinc(q dx / 2)`` times its value at the centre, and the
    mean in the cell sinc times it. Both axes are added, since an edge that crosses the cells has ends on both. Heights
    between the cell centres leave no trace here.
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
        l1 += bend[within].sum() / 12
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


# Of a cell: how far the place of a single edge is uncertain, how far that of all in the mean, and how far
# that of a plateau's.
EACH, ALL, HALF = 0.35, 0.1, 0.65


def contact_area(pressure: Array, wraps: tuple[bool, bool]) -> float:
    """Relative error of the contact area, counted in cells that touch, by where its edges lie in their cells.

    ``pressure`` (x, y); ``wraps``: which axes close on themselves. A cell counts whole; the last two of a row
    tell where the smooth contact that they stand for ends (:mod:`~contactstudy.accuracy.contact_edge`). Each
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

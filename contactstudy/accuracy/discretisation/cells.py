"""Discretisation errors of cells of constant pressure, from the pressure found on them."""

from dataclasses import dataclass
from math import inf, log, pi

import numpy as np
from numpy.typing import NDArray

from contactstudy.accuracy.discretisation.contact_edge import (
    edge_error,
    edge_position,
    resolved_edges,
)
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings, axis_first, is_free


@dataclass(frozen=True)
class DiscretisationConstants:
    """Constants of the errors due to the cells.

    Attributes
    ----------
    edge_effect
        Change of a maximum over its second difference with the places of the edges in their cells: 1/16 in closed form
        between two straight edges that fall alike; a third more for edges that are neither straight nor alike.
    edge_effect_beside
        The same where the maximum lies within two cells of an edge, where no parabola holds.
    edge_uncertainty
        Uncertainty, in cells, of the position of each edge, which may lie anywhere in its cell.
    side_uncertainty
        That of the area by which edges lie inside their cells in the mean, relative to it.
    side_excess
        Excess of the counted area per length of its outline along cell sides, in cells: ``(pi - 1 + ln 2) / 24``.
    plateau_uncertainty
        That of the end of a plateau, which lies anywhere in its cell.
    """

    edge_effect: float = 1 / 12
    edge_effect_beside: float = 1 / 3
    edge_uncertainty: float = 1.2
    side_uncertainty: float = 0.2
    side_excess: float = (pi - 1 + log(2)) / 24
    plateau_uncertainty: float = 0.65


CONSTANTS = DiscretisationConstants()
# Uncertainty, in cells, of an edge that the pressure beside it resolves, beside the difference of two laws of it.
RESOLVED_UNCERTAINTY = 0.003
# Difference of two edges in place, in cells, and in pressure of their last two cells, over the peak, up to which they
# lie alike. With 0.1 and 0.05 the bound held for egg-box waves with roughness of up to a tenth of their amplitude.
ALIKE_PLACE, ALIKE_PRESSURE = 0.1, 0.05


def with_ends(field: Array, count: int, *, wraps: bool) -> Array:
    """Return `field` (n, ...) with `count` more rows at either end: periodic ones where it wraps, else the last one."""
    before, after = (field[-count:], field[:count]) if wraps else (field[:1], field[-1:])
    repeats = 1 if wraps else count
    return np.concatenate([*[before] * repeats, field, *[after] * repeats])


def contact_perimeter(touching: NDArray[np.bool_], grid: Grid, paddings: Paddings | None) -> float:
    """Return the length [m] of the edges between cells in and out of contact, across the ends of a periodic axis too."""
    total = 0.0
    for axis in (0, 1):
        edge = grid.cell_size[1 - axis]
        total += edge * np.count_nonzero(np.diff(touching, axis=axis))
        if paddings is not None and not is_free(paddings[axis]):
            total += edge * np.count_nonzero(touching.take(0, axis) != touching.take(-1, axis))
    return float(total)


def around_contact(pressure: Array) -> slice:
    """Return the rows (x, y) of `pressure` in contact and one more on each side; all rows if one reaches an edge."""
    touching = np.flatnonzero(pressure.max(axis=1) > 0)
    if not touching.size or touching[0] == 0 or touching[-1] == len(pressure) - 1:
        return slice(None)
    return slice(int(touching[0]) - 1, int(touching[-1]) + 2)


def discretisation_errors(pressure: Array, wraps: tuple[bool, bool]) -> tuple[float, tuple[float, float]]:
    """Return the relative errors of the peak pressure and of the pressure in L1 (across, along) due to the cells.

    The maximum lies beside a cell's centre, above its pressure by the parabola through three cells, and that pressure
    is a 24th of the second difference too high; where the edges lie in their cells changes both. In L1 each end of a
    row of touching cells adds its :func:`~contactstudy.accuracy.discretisation.contact_edge.edge_error`, and each cell
    within adds a 12th of its second difference: for a wave number q the pressure of a cell is ``1 / sinc(q dx / 2)``
    times the true one at its centre, and the true mean in the cell is ``sinc(q dx / 2)`` times that. Both axes add up,
    since an edge that crosses the cells has ends on both. Heights between the cell centres are not included.

    Parameters
    ----------
    pressure
        Pressure (x, y).
    wraps
        Whether the surface wraps across and along.
    """
    highest = np.unravel_index(np.argmax(pressure), pressure.shape)
    level = float(pressure[highest])
    beside, edges, l1 = 0.0, 0.0, [0.0, 0.0]
    for axis, is_periodic in enumerate(wraps):
        if pressure.shape[axis] == 1:
            continue
        along = axis_first(pressure, axis)
        # beyond an open end the last cell is repeated
        padded = with_ends(along, 1, wraps=is_periodic)
        touching = padded > 0
        bends = np.abs(padded[:-2] + padded[2:] - 2 * padded[1:-1])
        within = touching[:-2] & touching[1:-1] & touching[2:]
        last, second = _ends(padded, touching)
        # a plateau ends half-way in its last cell, which has the mean pressure
        plateau = last[second >= level]
        l1[axis] = float(
            (bends * within).sum() / 12 + edge_error(last, second).sum() + np.minimum(plateau, level - plateau).sum()
        )
        index, line = highest[::-1] if axis else highest
        before, centre, after = padded[index : index + 3, line].tolist()
        slope, curvature = (after - before) / 2, abs(before + after - 2 * centre)
        # the parabola's vertex is slope / curvature cells away
        beside += slope**2 / curvature / 2 - curvature / 24 if curvature > 0 else 0.0
        around = padded[max(index - 1, 0) : index + 4, line] > 0
        edges = max(
            edges,
            (CONSTANTS.edge_effect if around.all() else CONSTANTS.edge_effect_beside) * curvature,
        )
    total = float(pressure.sum())
    return (abs(beside) + edges) / level, (l1[0] / total, l1[1] / total)


def _ends(padded: Array, touching: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return the pressures of all cells at an end of a row of `touching` cells, and of their neighbours inward.

    The rows run along the first axis, and `padded` has one more cell at either end.
    """
    first, last = (touching[1:-1] & ~beyond for beyond in (touching[:-2], touching[2:]))
    along, before, after = padded[1:-1], padded[:-2], padded[2:]
    ends = np.concatenate([along[first], along[last]])
    return ends, np.concatenate([after[first], before[last]])


def contact_area_in_cells(pressure: Array, wraps: tuple[bool, bool]) -> float:
    """Return the contact area in cells, with its edges inside them.

    A cell in contact counts as a whole. Straight edges across follow from the pressure beside them
    (:func:`~contactstudy.accuracy.discretisation.contact_edge.half_widths`); others are taken to lie inside their cells
    by :data:`CONSTANTS.side_excess` in the mean (Yastrebov, Anciaux & Molinari 2017, Tribology International 114, 161).
    """
    count = int(np.count_nonzero(pressure))
    if (edges := resolved_edges(pressure)) is not None:
        return float(sum(edge.sum() for edge in edges))
    sides = 0
    for axis, is_periodic in enumerate(wraps):
        touching = axis_first(pressure, axis) > 0
        if len(touching) > 1:
            sides += int(np.count_nonzero(np.diff(touching, axis=0)))
            sides += int(np.count_nonzero(touching[0] != touching[-1])) if is_periodic else 0
    return max(count - CONSTANTS.side_excess * sides, 0.0)


def contact_area_error(pressure: Array, wraps: tuple[bool, bool]) -> float:
    """Return the relative error of :func:`contact_area_in_cells`, by where its edges lie in their cells.

    The pressures of the last two cells of a row give the edge of the smooth contact
    (:mod:`~contactstudy.accuracy.discretisation.contact_edge`). Each axis shows the whole error, so the larger of both
    counts. It is infinite where no area may remain.

    Parameters
    ----------
    pressure
        Pressure (x, y).
    wraps
        Whether the surface wraps across and along.
    """
    cells, highest, area = (
        np.count_nonzero(pressure),
        pressure.max(),
        contact_area_in_cells(pressure, wraps),
    )
    is_resolved = resolved_edges(pressure) is not None
    found: list[tuple[int, float, int, float]] = []
    for axis, is_periodic in enumerate(wraps):
        along = axis_first(pressure, axis)
        if len(along) == 1:
            continue
        padded = with_ends(along, 1, wraps=is_periodic)
        last, second = _ends(padded, padded > 0)
        # a plateau ends anywhere in its last cell; a straight one at the same place in every row
        smooth = second < highest
        ends = int(np.count_nonzero(smooth))
        places = edge_position(last[smooth], second[smooth])
        beyond = float((0.5 - places).sum())
        alike = _alike_pairs(places, (last + second)[smooth] / highest)
        found.append((ends, abs(cells - beyond - area), len(last) - ends, alike))
    most = max((ends for ends, *_ in found), default=0)
    if is_resolved:
        excess = found[0][1] + RESOLVED_UNCERTAINTY * most
    else:
        # straight edges along an axis, which lie alike in their cells, have no ends along the other one
        straight = 1 - min(ends for ends, *_ in found) / most if most and len(found) > 1 else 1.0
        # errors of edges add up like independent ones, but those of edges that lie alike like equal ones
        alike = max((pairs for *_, pairs in found), default=0.0)
        pairs = straight * most + (1 - straight) * max(most, alike)
        excess = (
            straight * max((off for _, off, *_ in found), default=0.0)
            + CONSTANTS.side_uncertainty * (cells - area)
            + CONSTANTS.edge_uncertainty * pairs**0.5
            + CONSTANTS.plateau_uncertainty * max((flat for _, _, flat, _ in found), default=0)
        )
    return relative_loss(excess / area) if area else inf


def _alike_pairs(places: Array, beside: Array) -> float:
    """Return the number of pairs of edges, each with itself too, that lie alike in their cells.

    Those have the same place in their cell and the same pressure in the last two cells, as mirrored and repeated
    contacts have. Pairs that are alike by chance, a ninth of those within three times the differences, do not count.
    """
    edges = np.stack([places / ALIKE_PLACE, beside / ALIKE_PRESSURE])
    near, nearer = (
        int((np.unique(np.round(edges / width), axis=1, return_counts=True)[1] ** 2).sum()) for width in (3, 1)
    )
    return nearer - (near - len(places)) / 9


def relative_loss(fraction: float) -> float:
    """Return the relative error of a quantity that may have lost or gained the given `fraction` of itself."""
    return float(fraction / (1 - fraction)) if fraction < 1 else inf

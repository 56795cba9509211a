"""Edges of a smooth contact on cells of constant pressure: position and error, as of a cylinder on such cells.

Beside a straight edge, many cells from any other, the pressure is the square root of the distance from it. What cells
of constant pressure make of it depends on nothing but where in its cell the edge lies: a smooth cylinder, solved
directly on a row of cells with its edges at each place, says how, and is compared with Hertz's pressure.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from contactstudy.domain.grid import Array

# Cells across the cylinder: with half or twice as many the errors change by 2 % and 1 %, places by 0.01 cells.
CELLS = 80
# Places of the edge in cells outward of the last centre in contact, and their number: further inward that cell loses
# contact, further outward the next one gains it.
PLACES, STEPS = (-0.175, 0.83), 60
# Distance in cells within which the largest error counts. Without it the error is up to 41 % smaller.
JUMP_RANGE = 0.06
# Cells that touch beside each other, those of the opening beyond, and difference of the places by two pairs of cells, of
# a smooth edge.
MIN_TOUCHING, MIN_OPEN, MAX_DIFFERENCE = 12, 3, 0.5
# Steps between places by which the law of two cells is extended in a straight line, so that two pairs that both lie
# beyond it differ.
BEYOND = 10 * STEPS


class _EdgeLaw(NamedTuple):
    """Pressure of the cells beside an edge and its error, for places of the edge from inside outwards.

    Attributes
    ----------
    place
        Place of the edge, in cells outward of the centre of the last touching cell.
    error
        L1 error of the pressure, over that of the second cell.
    ratios
        Pressure of the last cell over the second, and of the second over the third.
    """

    place: Array
    error: Array
    ratios: tuple[Array, Array]


@cache
def _edge_law() -> _EdgeLaw:
    """Return the law of an edge, from cylinders whose pressure is ``sqrt(a^2 - x^2)``."""
    from scipy.linalg import toeplitz  # imported late, since it is slow

    places = np.linspace(*PLACES, STEPS)
    x = np.arange(CELLS) - (CELLS - 1) / 2
    borders = np.arange(CELLS + 1) - 0.5
    # displacements by the logarithm of the distance, and the approach, which the load determines
    matrix = np.ones((CELLS + 1, CELLS + 1))
    matrix[:-1, :-1] = toeplitz(-np.diff(borders * np.log(np.abs(borders))))
    matrix[:-1, -1], matrix[-1, -1] = -1.0, 0.0
    inverse = np.linalg.inv(matrix)
    errors, cells = np.empty(STEPS), np.empty((3, STEPS))
    for number, half_width in enumerate(x[-1] + places):
        pressure = (inverse @ np.append(-np.pi / 2 * x**2, np.pi / 2 * half_width**2))[:-1]
        angle = np.arcsin(np.clip(np.arange(CELLS // 2 + 2) / half_width, -1, 1))
        means = np.diff(half_width**2 / 2 * (angle + np.sin(angle) * np.cos(angle)))
        true = np.sqrt(np.maximum(half_width**2 - x**2, 0))
        right = pressure[CELLS // 2 :]
        # the cell beyond the last may hold the edge too
        of_means = np.abs(right - means[:-1]).sum() + means[-1]
        cells[:, number] = right[:-4:-1] / _narrowing(2 * half_width)
        errors[number] = max(np.abs(right - true[CELLS // 2 :]).sum(), of_means) / right[-2]
    near = np.abs(places[:, None] - places) <= JUMP_RANGE
    return _EdgeLaw(places, np.where(near, errors, 0).max(axis=1), (cells[0] / cells[1], cells[1] / cells[2]))


def _narrowing(width: float) -> Array:
    """Return by what an edge as far away as the `width` of the contact [cells] lowers the last three pressures."""
    return np.asarray(np.sqrt(1 - (np.arange(3) + 0.33) / width))


def edge_error(last: Array, inner: Array) -> Array:
    """Return the L1 pressure error at an edge, ``sum |p - true|``, from the two cells next to it.

    The true pressure is taken at the centres or as its mean in the cells, whichever error is larger. The ratio of the
    two cells tells where in its cell the edge of a smooth contact lies. The error jumps where the edge passes the
    centre of a cell, so the largest error within `JUMP_RANGE` cells to either side counts. Where a single cell
    touches, or `last` is the higher, the law no longer holds, and the edge is taken to lie as far out as it can.

    Parameters
    ----------
    last
        Pressure of the last touching cell at each edge.
    inner
        Pressure of the next cell inward; 0 where it does not touch.
    """
    _, error, (ratio, _) = _edge_law()
    inner = np.maximum(inner, last / ratio[-1])
    return np.asarray(np.interp(last / inner, ratio, error) * inner)


class StraightEdges(NamedTuple):
    """Straight, smooth edges across a contact.

    Attributes
    ----------
    places
        Places (side, y) of both edges, in cells outward of the middle of the grid.
    uncertainty
        Uncertainty [cells] of both places together: the difference of those by two pairs of cells, which fall with the
        curvature of the pressure, and what edges that bend along the length do so between two cells. The former was 1.7
        to 40 times the error on cylinders of 16 to 200 cells.
    """

    places: Array
    uncertainty: float


def _extended(values: Array) -> Array:
    """Return values with one more far beyond either end, in line with the last two."""
    first, last = values[0] + BEYOND * (values[0] - values[1]), values[-1] + BEYOND * (values[-1] - values[-2])
    return np.concatenate([[first], values, [last]])


def straight_edges(pressure: Array) -> StraightEdges | None:
    """Return the edges of a contact across; None unless they are straight and smooth.

    Each place along the length then touches in the same cells, a dozen and more without a gap, some cells are open, and
    those beside both edges follow the law of this module.
    """
    touching = np.flatnonzero(pressure[:, 0])
    first, last = (int(touching[0]), int(touching[-1])) if touching.size else (0, 0)
    is_straight = ((pressure > 0) == (pressure[:, :1] > 0)).all() and last - first == touching.size - 1
    if not is_straight or touching.size < MIN_TOUCHING or len(pressure) - touching.size < MIN_OPEN:
        return None
    if first == 0 or last == len(pressure) - 1:
        return None
    sides = np.stack([pressure[last : last - 3 : -1], pressure[first : first + 3]])
    sides = sides / _narrowing(touching.size)[:, None]
    place, _, ratios = _edge_law()
    places, others = (np.interp(sides[:, k] / sides[:, k + 1], _extended(ratios[k]), _extended(place)) for k in (0, 1))
    off = np.abs(places - others)
    if off.max() > MAX_DIFFERENCE:
        return None
    places = np.clip(places, place[0], place[-1])
    bends = np.abs(np.roll(places, 1, axis=1) + np.roll(places, -1, axis=1) - 2 * places)
    uncertainty = float((off.max(axis=1) + bends.max(axis=1)).sum())
    middle = (len(pressure) - 1) / 2
    return StraightEdges(places + np.array([[last - middle], [middle - first]]), uncertainty)

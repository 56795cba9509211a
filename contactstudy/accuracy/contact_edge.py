"""Where a smooth contact ends, finer than a cell, and what the pressure is beside that edge."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contactstudy.accuracy.edge_law import modes, offset, powers
from contactstudy.domain.fields import Array

# The law is fitted to these cells. An edge is resolved where so many touch without a break, the next
# rows end in the same cell, and the fit misses no pressure by more than this share of the largest.
FITTED, RESOLVED, MISFIT = 6, 12, 1e-3
# The law corrects the cells over one in so many of those that touch: from either edge, half of the half.
SHARE = 4


@dataclass(frozen=True)
class _Edges:
    """The resolved edges on the side of growing x.

    In each of ``rows`` the ``last`` cell that touches, how many are ``touching``, how many cells
    ``outward`` of that one's centre the edge lies, and the pressure D cells inside it, ``sqrt(D) (A + B D + G
    D^2)`` with ``shape`` (A, B, G), which the cells render with this ``strength`` of each mode.
    """

    rows: NDArray[np.intp]
    last: NDArray[np.intp]
    touching: NDArray[np.intp]
    outward: Array
    shape: Array
    strength: Array


def half_widths(pressure: Array, x: Array) -> Array:
    """Half the width of the contact in each row along the length, shape (length,) [unit of x].

    ``pressure`` (x, y) as solved for, ``x`` (width,) equidistant. Where the edge is smooth,
    straight over three rows and a dozen cells from any other, the cells beside it follow the law of
    :mod:`~contactstudy.accuracy.edge_law`, and the error falls like the cell cubed: on a smooth line contact
    2e-7 of the half-width at 128 cells across 2.4 of them. Elsewhere the outer faces of the
    touching cells count; zero where none touch.
    """
    return (_positions(pressure, x) + _positions(pressure[::-1], -x[::-1])) / 2


def corrected_pressure(pressure: Array) -> Array:
    """``pressure`` (x, y), with that of a continuous contact at the cell centres beside its edges.

    The cell that holds an edge is in error like the root of its size, whatever the solver does. Where
    the edge is resolved (see :func:`half_widths`) the law tells that error, and what is left falls like
    the cell to the power 3/2; elsewhere nothing changes. The load is no longer the sum over the cells.
    """
    corrected = pressure.copy()
    for given, result in ((pressure, corrected), (pressure[::-1], corrected[::-1])):
        edges = _resolved(given)
        reach = edges.touching // SHARE
        cells = np.arange(reach.max(initial=0))[:, None]
        inside = np.maximum(cells + edges.outward, 0)
        law = np.sqrt(inside) * np.polynomial.polynomial.polyval(inside, edges.shape, tensor=False)
        law -= modes(len(cells)) @ edges.strength
        result[edges.last - cells, edges.rows] += np.where(cells < reach, law, 0)
    return np.maximum(corrected, 0)


def _positions(pressure: Array, x: Array) -> Array:
    """Position of the edge on the side of growing x, in each row."""
    last, step = _last(pressure), x[1] - x[0]
    position = np.where((pressure > 0).any(axis=0), x[last] + step / 2, 0.0)
    edges = _resolved(pressure)
    position[edges.rows] = x[edges.last] + edges.outward * step
    return position


def _last(pressure: Array) -> NDArray[np.intp]:
    return np.asarray(len(pressure) - 1 - np.argmax(pressure[::-1] > 0, axis=0))


def _resolved(pressure: Array) -> _Edges:
    last, count = _last(pressure), len(pressure)
    # cells that touch without a break, from the last inward
    inward = np.minimum(np.arange(count)[:, None], last)
    touching = (pressure[last - inward, np.arange(pressure.shape[1])] > 0).cumprod(axis=0)
    within = np.arange(count)[:, None] <= last
    touching = (touching * within).sum(axis=0)
    straight = (last == np.roll(last, 1)) & (last == np.roll(last, -1)) & (last < count - 1)
    rows = np.flatnonzero(straight & (touching >= RESOLVED))
    beside = pressure[last[rows] - np.arange(FITTED)[:, None], rows]
    strength = np.linalg.lstsq(modes(FITTED), beside, rcond=None)[0]
    missed = np.abs(modes(FITTED) @ strength - beside).max(axis=0, initial=0)
    kept = missed <= MISFIT * beside.max(axis=0, initial=0)
    rows, strength = rows[kept], strength[:, kept]
    outward, shape = _continuous(strength)
    return _Edges(rows, last[rows], touching[rows], outward, shape, strength)


def _continuous(strength: Array) -> tuple[Array, Array]:
    """The edge, in cells beyond the last centre, and (A, B, G) of the contact whose cells have these modes.

    Away from the edge both are one but for a multiple of ``(2 b d - d^2)^(-3/2)``, b = -A / (4 B), which
    carries no load: so their powers of d are compared, with ``D = d + shift`` and that multiple unknown.
    """
    singular, inverse, root, cubed, g = powers() @ strength
    a, b, shift = root, cubed, 2 * inverse / root
    for _ in range(4):  # each gains two orders of cell over radius
        b = cubed - 2.5 * g * shift
        multiple = singular + a * shift**2 / 8
        a = root - 1.5 * b * shift - 7.5 * (b / a) ** 2 * multiple - 15 / 8 * g * shift**2
        # the square of the shift drops out
        shift = 2 * (inverse + 3 * b * singular / a) / a
    return offset() + shift, np.stack([a, b, g])

"""Where the contact ends, finer than a cell."""

import numpy as np

from contactstudy.arrays import Array

# The pressure of the last two cells is spoilt by the edge falling inside a cell; the next six show
# the edge law without leaving its neighbourhood.
SPOILT, FITTED = 2, 6


def half_widths(pressure: Array, x: Array) -> Array:
    """Half the width of the contact in each row along the length, shape (length,) [unit of x].

    ``pressure`` (width, length), ``x`` (width,) equidistant. At the edge of a smooth contact p^2 is
    linear in the distance from it (Johnson 1985, sect. 5.1); a parabola through p^2 of the cells
    beside the edge is extrapolated to zero. Error about 0.05 cells on a smooth line contact. Where
    fewer than ten cells touch, the outer faces of the touching cells count; zero where none touch.
    """
    right = _edge(pressure, x)
    left = _edge(pressure[::-1], -x[::-1])
    return (right + left) / 2


def _edge(pressure: Array, x: Array) -> Array:
    """Position of the edge on the side of growing x."""
    count, touching = len(x), pressure > 0
    step = x[1] - x[0]
    last = count - 1 - np.argmax(touching[::-1], axis=0)
    cells = touching.sum(axis=0)
    edge = np.where(cells > 0, x[last] + step / 2, 0.0)
    enough = np.flatnonzero(cells >= SPOILT + FITTED + 2)
    if enough.size:
        inward = np.arange(SPOILT, SPOILT + FITTED)
        squared = pressure[last[enough] - inward[:, None], enough] ** 2
        c, b, a = np.polynomial.polynomial.polyfit(inward, squared, 2)
        # the root next to the edge, in the form that survives a -> 0
        discriminant = b * b - 4 * a * c
        root = 2 * c / (-b - np.sqrt(np.where(discriminant >= 0, discriminant, b * b)))
        edge[enough] = x[last[enough]] - root * step
    return edge

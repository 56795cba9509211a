"""L1 error to expect of a smooth line contact before it is solved."""

from math import inf, pi, sqrt

from contactstudy.accuracy.contact_edge import worst_edge_error

# Factor of (dx / a)^2: what remains after the edges are corrected.
SECOND_ORDER = 0.1
MAX_CELL = 1e100  # half-widths: the square of a larger cell overflows


def smooth_l1(cell: float) -> float:
    """Return the largest relative L1 error of a smooth line contact, for a cell of `cell` half-widths.

    It includes the part that remains after the edges are corrected.
    """
    if cell > MAX_CELL:
        return inf
    return float(l1_factor() * cell**1.5 + SECOND_ORDER * cell**2)


def l1_factor() -> float:
    """Return the L1 error over (dx / a)^1.5, from both edges, where the pressure is ``sqrt(2 d / a)`` of the peak."""
    return 2 * sqrt(2) * worst_edge_error() / (pi / 2)

"""What of a solution an error may be asked of."""

from dataclasses import dataclass
from enum import Enum
from math import inf, pi, sqrt

from contactstudy.accuracy.contact_edge import worst_edge_error
from contactstudy.accuracy.truncation import expected_truncation
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Padding


class Metric(Enum):
    """What of a solution is to be accurate."""

    PEAK_PRESSURE = "peak pressure"
    L1 = "pressure in L1"
    HALF_WIDTH = "half-width"


class Edges(Enum):
    """Which pressure counts: as the cells have it, or :func:`~contactstudy.accuracy.contact_edge.corrected_pressure`."""

    AS_SOLVED = "as solved"
    CORRECTED = "corrected"


@dataclass(frozen=True)
class ErrorParts:
    """Upper estimate of a relative error by cause.

    ``truncation`` is that of the images left out, ``discretisation`` that of the cells, and ``residual`` that of
    the solver having stopped.
    """

    truncation: float
    discretisation: float
    residual: float

    @property
    def total(self) -> float:
        """Sum of the parts: the error if all of them have the same sign."""
        return self.truncation + self.discretisation + self.residual


# A maximum lies up to half a cell from a centre, where the parabola is dx^2 / (8 a^2) lower; the cell
# shows a 24th of the second difference more; the edges move it by a 16th.
PEAK = 1 / 8 - 1 / 24 + 1 / 16
# Factors of (dx / a)^2 and (dx / a)^3.
CORRECTED, HALF_WIDTH = 0.1, 0.05
# The law of the edge needs so many cells in contact; with fewer nothing is corrected.
RESOLVED = 24
# Errors over the tolerance of the preconditioned solver, where the tolerance tells which cells touch,
# which takes one of at most SETTLED (dx / a)^1.5.
PEAK_LEFT, L1_LEFT, CORRECTED_LEFT, HALF_WIDTH_LEFT = 8, 20, 80, 60
SETTLED = 1e-3


@dataclass(frozen=True)
class Contact:
    """A smooth line contact by its ``half_width`` [m]."""

    half_width: float

    def error(
        self, metric: Metric, edges: Edges, grid: Grid, padding: Padding, tolerance: float
    ) -> ErrorParts:
        """Upper estimate of the relative error by cause; infinite where no law holds.

        ``padding`` along the length. The half-width is that of :func:`~contactstudy.accuracy.contact_edge.half_widths`.
        ``edges`` matter to the L1 error alone, as they leave the peak pressure as it is.
        """
        cell = grid.cell[0] / self.half_width
        cut = expected_truncation(self.half_width, grid, padding)
        # where a window is centred on the domain the edge is not straight along the length
        resolved = 2 / cell >= RESOLVED and padding.wraps
        if metric is Metric.PEAK_PRESSURE:
            parts = cut.peak_pressure, PEAK * cell**2, PEAK_LEFT
        elif metric is Metric.HALF_WIDTH:
            parts = cut.half_width, HALF_WIDTH * cell**3 if resolved else cell, HALF_WIDTH_LEFT
        elif edges is Edges.CORRECTED and resolved:
            parts = cut.l1, CORRECTED * cell**2, CORRECTED_LEFT
        else:
            parts = cut.l1, smooth_l1(cell), L1_LEFT
        left = parts[2] * tolerance if tolerance <= SETTLED * cell**1.5 else inf
        return ErrorParts(parts[0], parts[1], left)


COARSEST = 1e100  # half-widths: beyond any cell whose square is a number


def smooth_l1(cell: float) -> float:
    """The L1 error of a smooth line contact at most, relative; ``cell`` in half-widths.

    What correcting the edges would leave is there all the same.
    """
    if cell > COARSEST:
        return inf
    return float(l1_factor() * cell**1.5 + CORRECTED * cell**2)


def l1_factor() -> float:
    """The L1 error over (dx / a)^1.5: at both edges ``sqrt(2 d / a)`` of the peak, d inside them."""
    return 2 * sqrt(2) * worst_edge_error() / (pi / 2)

"""Errors to expect of a smooth line contact before it is solved, by cause."""

from dataclasses import dataclass
from enum import Enum
from math import inf, pi, sqrt

from contactstudy.accuracy.contact_edge import worst_edge_error
from contactstudy.accuracy.truncation import expected_truncation
from contactstudy.domain.grid import Grid, Padding


class Metric(Enum):
    """Quantity of a solution that an error refers to."""

    PEAK_PRESSURE = "peak pressure"
    L1 = "pressure in L1"
    HALF_WIDTH = "half-width"


class Edges(Enum):
    """Choice of the pressure whose error counts: as the cells have it, or corrected at the edges of the contact.

    See :func:`~contactstudy.accuracy.contact_edge.corrected_pressure`.
    """

    AS_SOLVED = "as solved"
    CORRECTED = "corrected"


@dataclass(frozen=True)
class ErrorParts:
    """Upper estimate of a relative error by cause.

    Attributes
    ----------
    truncation
        Error by the images that the padding leaves out.
    discretisation
        Error by the cells.
    residual
        Error by the solver's remaining residual.
    """

    truncation: float
    discretisation: float
    residual: float

    @property
    def total(self) -> float:
        """Sum of the parts, the error if all of them have the same sign."""
        return self.truncation + self.discretisation + self.residual


# A maximum lies up to half a cell from a centre, where the parabola is dx^2 / (8 a^2) lower; the cell
# shows a 24th of the second difference more; the edges move it by a 16th.
PEAK = 1 / 8 - 1 / 24 + 1 / 16
# Factors of (dx / a)^2 and (dx / a)^3.
CORRECTED, HALF_WIDTH = 0.1, 0.05
# The least cells in contact for the law of the edge; with fewer, nothing is corrected.
RESOLVED = 24
# Errors over the tolerance of the preconditioned solver. They hold where the tolerance decides which cells touch: up to
# SETTLED (dx / a)^1.5.
PEAK_LEFT, L1_LEFT, CORRECTED_LEFT, HALF_WIDTH_LEFT = 8, 20, 80, 60
SETTLED = 1e-3


@dataclass(frozen=True)
class HertzianContact:
    """A smooth line contact with the half-width `half_width` [m]."""

    half_width: float

    def error(
        self, metric: Metric, edges: Edges, grid: Grid, padding: Padding, tolerance: float
    ) -> ErrorParts:
        """Return an upper estimate of the relative error by cause; infinite where no law holds.

        Parameters
        ----------
        metric
            The quantity. The half-width is that of :func:`~contactstudy.accuracy.contact_edge.half_widths`.
        edges
            The pressure whose L1 error counts; the peak pressure is the same for both.
        grid
            The cells.
        padding
            Boundary condition along the length.
        tolerance
            Tolerance of the solver.
        """
        cell = grid.cell[0] / self.half_width
        images = expected_truncation(self.half_width, grid, padding)
        # where a window is centred on the domain the edge is not straight along the length
        resolved = 2 / cell >= RESOLVED and padding.wraps
        if metric is Metric.PEAK_PRESSURE:
            parts = images.peak_pressure, PEAK * cell**2, PEAK_LEFT
        elif metric is Metric.HALF_WIDTH:
            parts = images.half_width, HALF_WIDTH * cell**3 if resolved else cell, HALF_WIDTH_LEFT
        elif edges is Edges.CORRECTED and resolved:
            parts = images.l1, CORRECTED * cell**2, CORRECTED_LEFT
        else:
            parts = images.l1, smooth_l1(cell), L1_LEFT
        residual = parts[2] * tolerance if tolerance <= SETTLED * cell**1.5 else inf
        return ErrorParts(parts[0], parts[1], residual)


COARSEST = 1e100  # half-widths: the square of a larger cell overflows


def smooth_l1(cell: float) -> float:
    """Return the largest relative L1 error of a smooth line contact, for a cell of `cell` half-widths.

    It includes the part that remains after the edges are corrected.
    """
    if cell > COARSEST:
        return inf
    return float(l1_factor() * cell**1.5 + CORRECTED * cell**2)


def l1_factor() -> float:
    """Return the L1 error over (dx / a)^1.5, from both edges, where the pressure is ``sqrt(2 d / a)`` of the peak."""
    return 2 * sqrt(2) * worst_edge_error() / (pi / 2)

"""A solution of a refinement, with its bounds."""

from dataclasses import dataclass
from functools import cached_property
from math import inf

from contactstudy.accuracy.discretisation.bound import shown_errors
from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.grid import Grid
from contactstudy.solvers.solution import Solution


@dataclass(frozen=True)
class BoundedSolution:
    """A solution with its bounds.

    Attributes
    ----------
    solution
        The solution.
    estimate
        Bounds by cause.
    seconds
        Seconds of processor time that it took in its refinement.
    """

    solution: Solution
    estimate: ErrorEstimate
    seconds: float

    @property
    def grid(self) -> Grid:
        """Grid of the solution."""
        return self.solution.problem.grid

    @property
    def bound(self) -> float:
        """Bound of the relative L1 error of the pressure, as calibrated: it is not proven."""
        return self.estimate.l1.total

    @property
    def discretisation_error(self) -> float:
        """Discretisation error, as part of the bound."""
        part = self.estimate.l1.discretisation
        return inf if part is None else part

    @cached_property
    def fractions(self) -> tuple[float, float]:
        """Contributions (across, along) to the discretisation error that the pressure shows, as fractions of it."""
        across, along = shown_errors(self.solution)[1]
        fraction = across / (across + along) if across + along else 1.0
        return fraction, 1 - fraction

    @property
    def is_sharp(self) -> bool:
        """Whether the peak has no bound, as at a corner or a roller's end, so that convergence is of first order."""
        peak = self.estimate.peak_pressure
        return peak is not None and peak.discretisation == inf

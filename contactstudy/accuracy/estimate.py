"""How far a solution is from the contact it stands for, by cause."""

from dataclasses import dataclass

import numpy as np

from contactstudy.accuracy.discretisation import discretisation
from contactstudy.accuracy.truncation import truncation
from contactstudy.domain.checks import NotDefined
from contactstudy.problem.gap import violation
from contactstudy.solvers.solution import Solution, Status

# An approximate inverse is out by up to this factor where the padding is a short window.
MARGIN = 1.5


@dataclass(frozen=True)
class ErrorParts:
    """A relative error's upper estimate by cause: images left out, cells, and the solver stopping."""

    truncation: float
    discretisation: float
    residual: float

    @property
    def total(self) -> float:
        """Of all three, should they have one sign."""
        return self.truncation + self.discretisation + self.residual


@dataclass(frozen=True)
class ErrorEstimate:
    """Relative errors of the highest pressure, and of the pressure in L1 against cell centres."""

    peak_pressure: ErrorParts
    l1: ErrorParts


def error_estimate(solution: Solution) -> ErrorEstimate:
    """Estimate the errors of ``solution`` from itself, at the cost of one approximate inverse.

    Meant as bounds that are a few times too large at most: not for a contact that reaches the edge of
    the width, nor for heights the grid does not resolve. Infinite where there is no solution.
    Raises :class:`~contactstudy.NotDefined` where the problem does not say its paddings, or no law is
    known for them (see :func:`~contactstudy.accuracy.truncation.truncation`).
    """
    problem = solution.problem
    if problem.paddings is None:
        raise NotDefined(
            "Problem.paddings is None: give the paddings of the two axes, (across, along)."
        )
    if solution.status in (Status.NOT_FINITE, Status.NO_ADMISSIBLE_PRESSURE):
        lost = ErrorParts(0.0, 0.0, np.inf)
        return ErrorEstimate(lost, lost)
    across, along = problem.paddings
    cut = truncation(solution.pressure, problem.grid, problem.paddings)
    cells = discretisation(solution.pressure, (across.wraps, along.wraps))
    left = _residual(solution)
    peak, l1 = (ErrorParts(*parts) for parts in zip(cut, cells, left, strict=True))
    return ErrorEstimate(peak, l1)


def _residual(solution: Solution) -> tuple[float, float]:
    """The same two errors by the gap left over: the pressure that would close it, to first order."""
    problem = solution.problem
    scales, operator = problem.scales, problem.bare().operator
    pressure, gap = solution.pressure / scales.pressure, solution.gap / scales.gap
    free = problem.constraint.free(solution.pressure) > 0
    closing = operator.approximate_inverse()[0](np.where(free, -gap, 0.0))
    closing = np.where(free, closing - closing.mean(where=free) if free.any() else 0.0, 0.0)
    # of cells at a limit that should not be
    bound = violation(pressure, np.where(free, 0.0, -gap)) / operator.own
    missing = MARGIN * (np.abs(closing) + bound)
    l1 = float(missing.sum() / pressure.sum())
    # another cell may yet become the highest; and the inverse, blind to where a length that does not wrap
    # ends, tells the whole better than the single cell
    highest = float(pressure.max())
    return max(float((pressure + missing).max()) / highest - 1, l1), l1

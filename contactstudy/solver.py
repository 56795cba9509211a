"""Problem -> Solution."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from contactstudy.arrays import Array, inner
from contactstudy.checks import positive, whole
from contactstudy.polonsky_keer import Iterate, PolonskyKeer
from contactstudy.pressures import AdmissiblePressures
from contactstudy.problem import Problem
from contactstudy.solution import Solution, Status


class Solver(Protocol):
    """An iteration for the dimensionless problem."""

    def iterate(
        self,
        undeformed_gap: Array,
        displacement: Callable[[Array], Array],
        pressures: AdmissiblePressures,
        residual: Callable[[Array, Array], float],
        *,
        tolerance: float,
        max_iterations: int,
    ) -> Iterate:
        """Iterate until ``residual(pressure, gap) <= tolerance`` or the limit."""
        ...


def solve(
    problem: Problem,
    *,
    tolerance: float = 1e-8,
    max_iterations: int = 2000,
    solver: Solver = PolonskyKeer(),  # noqa: B008 (a frozen value)
) -> Solution:
    """Solve ``problem`` and say how far the answer can be trusted.

    One stopping rule, dimensionless: the largest of complementarity, ``sum(p |gap|) / sum(p)``,
    penetration, ``max(-gap)`` where p = 0, both over the problem's gap scale ``p_H a / E*``, and load,
    ``|sum(p) / total - 1|``, is at most ``tolerance``. Numerical outcomes are a
    :class:`~contactstudy.Status`; only a tolerance that is not above zero or a negative limit raises
    :class:`~contactstudy.InvalidInput`.
    """
    positive("solve.tolerance", tolerance, "give a dimensionless tolerance above 0, such as 1e-8")
    whole("solve.max_iterations", max_iterations, 0, "give a whole number of iterations from 0 on")
    scales = problem.scales
    pressures = AdmissiblePressures(problem.pressures.total / scales.pressure)

    def displacement(pressure: Array) -> Array:
        return problem.displacement(pressure) * (scales.pressure / scales.gap)

    def residual(pressure: Array, gap: Array) -> float:
        total = pressure.sum()
        complementarity = inner(pressure, np.abs(gap)) / total
        penetration = np.max(-gap, where=pressure == 0, initial=0.0)
        return float(max(complementarity, penetration, abs(total / pressures.total - 1)))

    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        last = solver.iterate(
            problem.undeformed_gap / scales.gap,
            displacement,
            pressures,
            residual,
            tolerance=tolerance,
            max_iterations=max_iterations,
        )
    moved, approach = last.displacement * scales.gap, last.approach * scales.gap
    return Solution(
        problem=problem,
        pressure=last.pressure * scales.pressure,
        displacement=moved,
        gap=problem.undeformed_gap + moved - approach,
        approach=approach,
        status=_status(last, tolerance, problem.open_edges),
        iterations=last.iterations,
        convolutions=last.convolutions,
        residual=last.residual,
    )


def _status(last: Iterate, tolerance: float, open_edges: tuple[int, ...]) -> Status:
    if not np.isfinite(last.residual):
        return Status.NOT_FINITE
    if last.residual > tolerance:
        return Status.ITERATION_LIMIT
    if last.pressure[list(open_edges)].any():
        return Status.CONTACT_AT_EDGE
    return Status.CONVERGED

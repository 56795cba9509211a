"""Errors by the remaining residual of the solver."""

from typing import NamedTuple

import numpy as np

from contactstudy.accuracy.discretisation.cells import relative_loss
from contactstudy.domain.device import Precision
from contactstudy.domain.fields import MIN_COMPILED_CELLS, Array, in_blocks, inner
from contactstudy.problem.constraint import cell_violation
from contactstudy.solvers.solution import Solution

# Bound over the error of the approximate inverse, which was at most 2.3 in 2320 solves, where the padding is a window
# on an odd number of cells.
INVERSE_MARGIN = 2.5


class ResidualErrors(NamedTuple):
    """Relative errors of the peak pressure, the pressure in L1 and the contact area, and the error of the gap [m]."""

    peak_pressure: float
    l1: float
    contact_area: float
    gap: float


def residual_errors(solution: Solution, change: float = 0.0) -> ResidualErrors:
    """Return the errors by the remaining gap: of the pressure that would close it, and of the gap itself.

    Beside the contact the gap changes by no more than in it, by the maximum principle. A cell that enters or leaves the
    contact changes the pressure by its own: the cells of the smallest pressures, as many as carry the L1 error, may do
    so. The error of the load, and of a gap beside far larger heights, add to that of the pressure. A relative `change`
    of the pressure may be left beside the residual.
    """
    pressure, gap, scales = solution.pressure, solution.gap, solution.problem.scales
    scale = scales.pressure / scales.gap
    operator = solution.problem.operator.scaled(scale, Precision.DOUBLE)
    compliance = operator.self_compliance
    # single precision takes half the time
    inverse = operator.approximate_inverse(Precision.SINGLE if pressure.size >= MIN_COMPILED_CELLS else None)
    cells = solution.problem.constraint.active(pressure).astype(inverse.real, copy=False)
    correction, level = np.empty_like(cells), 0.0

    def of_cells(height: Array, gap: Array, cells: Array) -> None:
        np.multiply(gap / scales.gap, cells, out=height, casting="same_kind")

    in_blocks(of_cells, correction, gap, cells)
    if count := np.count_nonzero(cells):  # not where all pressures are at a limit
        extension = inverse.extension(cells)
        correction = extension.pressure(extension(correction))
        level = inner(correction, cells) / count

    def errors_in_block(pressure: Array, gap: Array, cells: Array, correction: Array) -> tuple[float, ...]:
        # cells at a limit that should not be there, and the pressure that closes the others
        violation = cell_violation(pressure, gap, cells)
        pressure_error = violation / (scales.gap * compliance)
        pressure_error += np.abs((correction - level) * cells)
        pressure_error *= INVERSE_MARGIN * scales.pressure
        violation += np.abs(gap) * cells
        largest = (pressure + pressure_error).max()
        return float(pressure_error.sum()), float(largest), float(violation.max())

    results = in_blocks(errors_in_block, pressure, gap, cells, correction)
    sums, peaks, gaps = zip(*results, strict=True)
    load = float(pressure.sum())
    by_load = min(solution.problem.control.error(load), solution.residual)
    l1 = float(sum(sums) / load + by_load)
    # what a gap in metres has lost beside far larger heights, if the residual allows for it
    largest_gap = float(np.abs(solution.problem.undeformed_gap).max())
    lost = min(np.finfo(float).eps * largest_gap / scales.gap, solution.residual)
    l1 += INVERSE_MARGIN * float(lost / compliance * scales.pressure * count / load)
    if solution.problem.control.approach is not None:
        # the inverse leaves a uniform gap out, which changes the load: by at least a multiple of this pressure, as that
        # has not the least energy of all with the same mean displacement
        displacement = inner(pressure, solution.problem.operator(pressure))
        l1 += INVERSE_MARGIN * abs(inner(pressure, gap)) / displacement
    # the peak may be in another cell; the inverse, which takes both axes for periodic, is more accurate for the sum than
    # for a single cell
    peak = max(float(max(peaks) / pressure.max()) - 1, l1) + change
    return ResidualErrors(peak, l1 + change, _area_error(pressure, l1 + change), max(gaps))


def _area_error(pressure: Array, l1: float) -> float:
    """Return the fraction of the contact in the cells of smallest `pressure` that together carry its fraction `l1`."""
    allowed = l1 * float(pressure.sum())
    smallest = np.cumsum(np.sort(pressure[(pressure > 0) & (pressure <= allowed)]))
    count = np.searchsorted(smallest, allowed, side="right")
    return relative_loss(count / np.count_nonzero(pressure))

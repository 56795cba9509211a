"""Errors of the pressure by the remaining residual of the solver."""

import numpy as np

from contactstudy.domain.device import Precision
from contactstudy.domain.fields import MIN_COMPILED_CELLS, Array, in_blocks, inner
from contactstudy.problem.constraint import cell_violation
from contactstudy.solvers.solution import Solution

# Largest error of the approximate inverse, as a factor; it occurs where the padding is a short window.
INVERSE_MARGIN = 2.0


def residual_errors(solution: Solution) -> tuple[float, float]:
    """Return the errors of peak pressure and pressure in L1 by the remaining gap: the pressure that would close it."""
    pressure, gap, scales = solution.pressure, solution.gap, solution.problem.scales
    scale = scales.pressure / scales.gap
    operator = solution.problem.operator.scaled(scale, Precision.DOUBLE)
    compliance = operator.self_compliance
    # single precision takes half the time
    inverse = operator.approximate_inverse(
        Precision.SINGLE if pressure.size >= MIN_COMPILED_CELLS else None
    )
    cells = solution.problem.constraint.active(pressure).astype(inverse.real, copy=False)
    correction, level = np.empty_like(cells), 0.0

    def of_cells(height: Array, gap: Array, cells: Array) -> None:
        np.multiply(gap / scales.gap, cells, out=height, casting="same_kind")

    in_blocks(of_cells, correction, gap, cells)
    if count := np.count_nonzero(cells):  # not where all pressures are at a limit
        extension = inverse.extension(cells)
        correction = extension.pressure(extension(correction))
        level = inner(correction, cells) / count

    def errors_in_block(
        pressure: Array, gap: Array, cells: Array, correction: Array
    ) -> tuple[float, ...]:
        # cells at a limit that should not be there, and the pressure that closes the others
        pressure_error = cell_violation(pressure, gap, cells) / (scales.gap * compliance)
        pressure_error += np.abs((correction - level) * cells)
        pressure_error *= INVERSE_MARGIN * scales.pressure
        return float(pressure_error.sum()), float((pressure + pressure_error).max())

    sums, peaks = zip(*in_blocks(errors_in_block, pressure, gap, cells, correction), strict=True)
    l1 = float(sum(sums) / pressure.sum())
    if solution.problem.control.approach is not None:
        # the inverse leaves a uniform gap out, which changes the load: by at least a multiple of this pressure, as that
        # has not the least energy of all with the same mean displacement
        displacement = inner(pressure, solution.problem.operator(pressure))
        l1 += INVERSE_MARGIN * abs(inner(pressure, gap)) / displacement
    # the peak may be in another cell; the inverse, which takes a free length for a periodic one, is more accurate for
    # the sum than for a single cell
    return max(float(max(peaks) / pressure.max()) - 1, l1), l1

"""Estimated errors of a solution, by cause: truncation of images, discretisation, and the solver's residual."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from contactstudy.accuracy.coarser import Change, change, coarse_solution, halved
from contactstudy.accuracy.discretisation import (
    around_contact,
    axis_first,
    contact_area,
    discretisation,
)
from contactstudy.accuracy.expected_error import ErrorParts
from contactstudy.accuracy.plausibility import implausible
from contactstudy.accuracy.subcell import CONFIDENCE, HeightsInside, Subcell
from contactstudy.accuracy.truncation import truncation
from contactstudy.domain.checks import InvalidInput, NotDefined
from contactstudy.domain.device import Precision
from contactstudy.domain.fields import LARGE, Array, in_blocks, inner
from contactstudy.domain.reuse import ArrayStore, open_store, reusing
from contactstudy.problem.constraint import violation
from contactstudy.problem.problem import Problem
from contactstudy.scene.bodies import is_layered
from contactstudy.scene.scene import PosedScene
from contactstudy.solvers.solution import Solution, Status

# Largest factor by which the approximate inverse is wrong, where the padding is a short window.
MARGIN = 2.0
# Ratio of the hidden share of the load to the error of smooth edges. Below SMOOTH no coarser solution is needed; up to
# RESOLVED the L1 error is at most L1_RESOLVED times that of the edges; up to half of RESOLVED the error of the peak
# pressure grows by PEAK_RESOLVED times the ratio.
SMOOTH, RESOLVED = 0.25, 2.0
L1_RESOLVED, PEAK_RESOLVED = 1.6, 2.0
# Largest error over the change from cells of twice the size (of the pressure, of the area), and over the hidden share of
# the load, on nearly all surfaces of the accuracy matrix. Two pressures of one load differ by LARGEST at most.
CHANGE, AREA_CHANGE, HIDDEN, LARGEST = 1.4, 1.25, 0.5, 2.0
# Rise of the peak pressure at a halving of the cells from which it counts as unbounded: like the inverse root of the
# cell it would be 41 %. Error over a rise that shrinks like the root of the cell (2.4 times as much follows), and over a
# fall.
UNBOUNDED, RISE, FALL = 0.2, 2.5, 1.5
# Share of the peak pressure that a corner adds at each halving of the cells, from which it counts as sharp.
SHARP = 0.01
# Error of the mean gap: of a smooth contact, over the L1 error of the pressure times the depth that is flattened; else
# over the L1 error by the edges and the change from cells of twice the size; and over the L1 error by images left out.
GAP_DEPTH, GAP_EDGES, GAP_CHANGE, GAP_IMAGES = 0.15, 0.3, 3.0, 8.0
# The least cells across a spot for which the law of a smooth edge holds.
FEW = 5
# Pressure at a roller's end over the peak pressure, from which that end may have the peak.
AT_END = 0.5
# Under a coat more than STIFF_COAT times as stiff as its substrate, pressure rises at the edges over a share of the
# thickness. With fewer than IN_COAT cells in it, estimates were up to three times too low (ratios up to 300).
STIFF_COAT, IN_COAT, COAT_FACTOR = 2.0, 8, 3.5
SHARP_EDGE = "a sharp edge or corner"
# L1 error above which the peak pressure is not known either.
LOST = 0.5
UNKNOWN_HEIGHTS = (
    "No bound by the cells: Problem.source does not say the heights on other grids, so nothing is "
    "known of them between the cell centres; make the problem from a Scene."
)
STANDING_OUT = (
    "No bound by the cells: between their centres the surface stands out by more than the contact "
    "presses it in; give more cells, or the shape a `detail` that names its finest length."
)


@dataclass(frozen=True)
class ErrorEstimate:
    """Relative errors of a solution, as upper estimates by cause.

    The pressure in L1 is judged against the true pressure's cell means: that is what a cell of constant
    pressure stands for.

    Attributes
    ----------
    peak_pressure
        Error of the peak pressure.
    l1
        Error of the pressure in L1.
    contact_area
        Error of the contact area.
    mean_gap
        Error of the mean gap.
    warnings
        A sentence for each bound that is infinite, or what to change.
    """

    peak_pressure: ErrorParts
    l1: ErrorParts
    contact_area: ErrorParts
    mean_gap: ErrorParts
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Cells:
    """Relative errors that the cells cause, with the reasons for infinite ones."""

    peak_pressure: float
    l1: float
    contact_area: float
    mean_gap: float
    warnings: tuple[str, ...] = ()


def error_estimate(
    solution: Solution,
    *,
    coarse: Solution | None = None,
    heights: HeightsInside | None = None,
    confidence: float = CONFIDENCE,
) -> ErrorEstimate:
    """Estimate the errors of `solution`.

    Where heights and edges are smooth, the solution itself shows them. Otherwise the same contact is solved once more
    on cells of twice the size, its heights sampled anew, and the heights are examined inside the cells. That costs
    up to two solves of a hundred cells a side, and half of one of some hundred. An error is infinite, with the
    reason in ``warnings``, where no bound can be given: no solution, a contact cut off, the pressure at a sharp edge,
    heights finer than the cells.

    Parameters
    ----------
    solution
        The solution.
    coarse
        The same contact on cells of twice the size, if at hand, see
        :func:`~contactstudy.accuracy.coarser.coarse_solution`.
    heights
        The heights inside the cells, if at hand, such as those of an earlier instant on the same grid.
    confidence
        Probability, between 0 and 1, with which a feature over 3 % of a cell is found in a shape without a ``detail``.
        It sets the number of points examined in each cell.

    Returns
    -------
    ErrorEstimate
        Relative errors by cause.

    Raises
    ------
    InvalidInput
        If the confidence is not between 0 and 1.
    NotDefined
        If the problem does not say its paddings, or no law is known for them, see
        :func:`~contactstudy.accuracy.truncation.truncation`.
    """
    problem = solution.problem
    if not 0 < confidence < 1:
        raise InvalidInput(
            f"error_estimate.confidence is {confidence!r}: give a share between 0 and 1, such as 0.95."
        )
    if problem.paddings is None:
        raise NotDefined(
            "Problem.paddings is None: give the paddings of the two axes, (across, along)."
        )
    if solution.status in (Status.NOT_FINITE, Status.NO_ADMISSIBLE_PRESSURE):
        no_bound = ErrorParts(0.0, 0.0, inf)
        return ErrorEstimate(
            no_bound, no_bound, no_bound, no_bound, (f"No bound: {solution.status}",)
        )
    peak_images, l1_images = 0.0, 0.0
    if problem.source is None or not problem.source.ends_along:
        peak_images, l1_images = truncation(solution.pressure, problem.grid, problem.paddings)
    peak_residual, l1_residual = _residual(solution)
    # the heights on several grids have the same waves
    with reusing(open_store() or ArrayStore(problem.undeformed_gap.nbytes)):
        cells = _cells(solution, coarse, heights, confidence)
    if reason := _thin_coat_warning(problem):
        cells = replace(
            cells,
            peak_pressure=COAT_FACTOR * cells.peak_pressure,
            l1=COAT_FACTOR * cells.l1,
            warnings=(*cells.warnings, reason),
        )
    return ErrorEstimate(
        ErrorParts(peak_images, cells.peak_pressure, peak_residual),
        ErrorParts(l1_images, cells.l1, l1_residual),
        ErrorParts(l1_images, cells.contact_area, l1_residual),
        ErrorParts(GAP_IMAGES * l1_images, cells.mean_gap, l1_residual),
        (*cells.warnings, *filter(None, (implausible(solution),))),
    )


def _thin_coat_warning(problem: Problem) -> str:
    """Return a sentence if the cells are too large for a coat stiffer than its substrate, else an empty string."""
    if not isinstance(problem.description, PosedScene):
        return ""
    for coat in problem.description.scene.solids:
        if not is_layered(coat):
            continue
        stiffer = coat.substrate.compliance / coat.compliance
        cells = coat.thickness / problem.grid.cell[0]
        if stiffer > STIFF_COAT and cells < IN_COAT:
            return (
                f"The grid has {cells:.2g} cells in a coat {stiffer:.3g} times as stiff as its substrate, where errors "
                f"were seen up to three times what cells show: the bounds are {COAT_FACTOR:g} times as large."
            )
    return ""


def _cells(
    solution: Solution, coarse: Solution | None, heights: HeightsInside | None, confidence: float
) -> _Cells:
    """Return the errors that the cells cause."""
    problem = solution.problem
    pressure = solution.pressure[around_contact(solution.pressure)]
    assert problem.paddings is not None
    wraps = problem.paddings[0].wraps, problem.paddings[1].wraps
    if reason := _cut_off(solution) or _unresolved_length(problem):
        return _Cells(inf, inf, inf, inf, (reason,))
    heights = heights or HeightsInside.from_problem(problem, confidence)
    if heights is None:
        return _Cells(inf, inf, inf, inf, (UNKNOWN_HEIGHTS,))
    inside = heights.under(problem, solution.pressure)
    if inside.stands_out:
        return _Cells(inf, inf, inf, inf, (STANDING_OUT,))
    peak, l1 = discretisation(pressure, wraps)
    area = contact_area(pressure, wraps)
    yields, sharp_end = _at_hardness(solution), _at_sharp_end(problem, pressure)
    ends = problem.source is not None and problem.source.ends_along
    at_end = ends and pressure[:, [0, -1]].any()
    regular = not (yields or at_end) and _spot_width(pressure, wraps) >= FEW
    if regular and inside.uncertain <= SMOOTH * l1 and inside.corner <= SHARP:
        peak *= 1 + PEAK_RESOLVED * inside.uncertain / l1 if l1 else 1.0
        peak += inside.rise + inside.kink
        return _with_area_warning(_Cells(peak, l1, area, _smooth_gap_error(solution, l1)))
    coarse = coarse or coarse_solution(problem, solution.pressure)
    if coarse is None or coarse.status in (Status.NOT_FINITE, Status.NO_ADMISSIBLE_PRESSURE):
        reason = "No bound by the cells: there is no solution on cells of twice the size to compare with."
        return _Cells(inf, inf, inf, inf, (reason,))
    changes = change(solution, coarse)
    hidden_ratio = inside.uncertain / l1 if l1 else inf
    l1_by_change = max(CHANGE * changes.l1, HIDDEN * inside.uncertain)
    peak_by_change = (RISE if changes.peak_pressure > 0 else FALL) * abs(changes.peak_pressure)
    smooth = regular and inside.corner <= SHARP
    if smooth and hidden_ratio <= RESOLVED:
        l1_by_change = min(l1_by_change, L1_RESOLVED * l1)
    bounded = smooth and hidden_ratio <= RESOLVED / 2
    if bounded:
        peak_by_change = min(peak_by_change, (1 + PEAK_RESOLVED * hidden_ratio) * peak)
    estimate = _Cells(
        0.0 if yields else max(peak, peak_by_change) + inside.rise + inside.kink,
        LARGEST if _has_isolated_cells(pressure) else min(LARGEST, max(l1, l1_by_change)),
        max(
            area, _relative_loss(AREA_CHANGE * changes.contact_area), HIDDEN / 2 * inside.uncertain
        ),
        max(
            GAP_CHANGE * changes.mean_gap, GAP_EDGES * l1, _sampling_error(solution, coarse.problem)
        ),
    )
    return _with_area_warning(
        _unbounded(estimate, problem, inside, changes, sharp_end=sharp_end, exact=yields or bounded)
    )


def _cut_off(solution: Solution) -> str:
    """Return a sentence if the contact is cut off at the edge of the grid, else an empty string."""
    if solution.status is not Status.CONTACT_AT_EDGE:
        return ""
    return (
        "No bound: the contact is cut off at the edge of the grid, give Grid.extent a larger one."
    )


def _smooth_gap_error(solution: Solution, l1: float) -> float:
    """Return the relative error of the mean gap of a smooth contact whose edges have the error `l1`.

    They move the approach by a share of the depth that the contact flattens.
    """
    rows, mean_gap = around_contact(solution.pressure), solution.mean_gap
    touching = solution.pressure[rows] > 0
    if not mean_gap > 0 or not touching.any():
        return l1
    depth = float(np.ptp(solution.problem.undeformed_gap[rows][touching]))
    return GAP_DEPTH * l1 * depth / mean_gap + _sampling_error(solution)


def _sampling_error(solution: Solution, coarse: Problem | None = None) -> float:
    """Return the relative error of the mean gap by heights that are sampled at the centres of cells.

    On ever finer cells their mean changes no more than from cells of twice the size, those of `coarse`.
    """
    problem, mean_gap, means = solution.problem, solution.mean_gap, []
    if problem.source is None or not mean_gap > 0:
        return 0.0
    sources = problem.source, (coarse and coarse.source) or problem.source
    for source, grid in zip(sources, (problem.grid, halved(problem.grid)), strict=True):
        try:
            rows = source.gap(grid).mean(axis=0)
        except InvalidInput:
            return 0.0
        lengths = getattr(source, "row_lengths", lambda _: None)(grid)
        means.append(float(np.average(np.broadcast_to(rows, grid.cells[1]), weights=lengths)))
    return abs(means[0] - means[1]) / mean_gap


def _with_area_warning(cells: _Cells) -> _Cells:
    """Return `cells`, with the reason if the contact area alone has no bound."""
    if cells.contact_area < inf or cells.l1 == inf:
        return cells
    reason = "No bound for the contact area: the spots are one or two cells wide, give more cells."
    return replace(cells, warnings=(*cells.warnings, reason))


def _has_isolated_cells(pressure: np.ndarray) -> bool:
    """Return whether along an axis no two touching cells are neighbours, so that their edges are unknown."""
    touching = pressure > 0
    return any(
        len(along) > 1 and not (along[1:] & along[:-1]).any() for along in (touching, touching.T)
    )


def _relative_loss(share: float) -> float:
    """Return the relative error of a quantity that may have lost or gained the given share of itself."""
    return share / (1 - share) if share < 1 else inf


def _spot_width(pressure: np.ndarray, wraps: tuple[bool, bool]) -> int:
    """Return the number of cells that touch in a row through the peak pressure, along the axis with the fewest."""
    peak = np.unravel_index(np.argmax(pressure), pressure.shape)
    fewest = pressure.size
    for axis, is_periodic in enumerate(wraps):
        row = axis_first(pressure, axis)[:, peak[1 - axis]] > 0
        if len(row) > 1 and not row.all():
            row = np.roll(row, len(row) // 2 - int(peak[axis])) if is_periodic else row
            middle = len(row) // 2 if is_periodic else int(peak[axis])
            gaps = np.flatnonzero(~row)
            before, after = gaps[gaps < middle], gaps[gaps > middle]
            first = before[-1] if before.size else -1
            last = after[0] if after.size else len(row)
            fewest = min(fewest, int(last - first - 1))
    return fewest


def _unbounded(
    cells: _Cells,
    problem: Problem,
    inside: Subcell,
    changes: Change,
    *,
    sharp_end: bool,
    exact: bool,
) -> _Cells:
    """Return `cells` with an infinite error of the peak pressure where it has no bound, and the reason."""
    if exact:
        return cells
    reason = ""
    if inside.corner > SHARP:
        reason = f"it lies at {SHARP_EDGE}, where it is infinite: round the edge, or ask for another quantity"
    elif sharp_end:
        reason = "the roller bears pressure up to its sharp end, where it is infinite: give a profile that drops more"
    elif changes.peak_pressure >= UNBOUNDED:
        reason = (
            f"it grew by {changes.peak_pressure:.0%} when the cells were halved: give more cells, unless the "
            "surface has a sharp edge"
        )
    elif max(CHANGE * changes.l1, HIDDEN * inside.uncertain) >= LOST:
        reason = "the grid hardly shows the surface: give more cells"
    if not reason:
        return cells
    return replace(
        cells, peak_pressure=inf, warnings=(f"No bound for the peak pressure: {reason}.",)
    )


def _unresolved_length(problem: Problem) -> str:
    """Return why the cells are too large for a length that a shape names; an empty string where they are not."""
    finest = problem.source.finest if problem.source is not None else (inf, inf)
    for axis, (cell, length) in enumerate(zip(problem.grid.cell, finest, strict=True)):
        if cell > length * (1 + 1e-9) and problem.grid.cells[axis] > 1:
            count = int(np.ceil(2 * problem.grid.extent[axis] / length))
            return (
                f"No bound by the cells: Grid.cells[{axis}] is {problem.grid.cells[axis]}, whose cells of "
                f"{cell:.4g} m do not show lengths of {length:.4g} m, give {count} or more."
            )
    return ""


def _at_hardness(solution: Solution) -> bool:
    """Return whether the peak pressure is a limit of the constraint, which finer cells have too."""
    row, column = np.unravel_index(np.argmax(solution.pressure), solution.pressure.shape)
    free = solution.problem.constraint.free(solution.pressure[row : row + 1])
    return bool(free[0, column] == 0)


def _at_sharp_end(problem: Problem, pressure: np.ndarray) -> bool:
    """Return whether an end of the roller bears pressure of the order of the peak pressure.

    There it is infinite in the limit of small cells, though coarse cells may not show a rise.
    """
    if problem.source is None or not problem.source.ends_along:
        return False
    return bool(max(pressure[:, 0].max(), pressure[:, -1].max()) > AT_END * pressure.max())


def _residual(solution: Solution) -> tuple[float, float]:
    """Return the errors of peak pressure and pressure in L1 by the remaining gap: the pressure that would close it."""
    pressure, gap, scales = solution.pressure, solution.gap, solution.problem.scales
    scale = scales.pressure / scales.gap
    operator = solution.problem.operator.scaled(scale, Precision.DOUBLE)
    compliance = operator.self_compliance
    # half as many digits take half the time
    inverse = operator.approximate_inverse(Precision.SINGLE if pressure.size >= LARGE else None)
    cells = solution.problem.constraint.free(pressure).astype(inverse.real, copy=False)
    closing, level = np.empty_like(cells), 0.0

    def of_cells(height: Array, gap: Array, cells: Array) -> None:
        np.multiply(gap / scales.gap, cells, out=height, casting="same_kind")

    in_blocks(of_cells, closing, gap, cells)
    if count := np.count_nonzero(cells):  # not where all pressures are at a limit
        extension = inverse.extension(cells)
        closing = extension.closing(extension(closing))
        level = inner(closing, cells) / count

    def missing(pressure: Array, gap: Array, cells: Array, closing: Array) -> tuple[float, ...]:
        # cells at a limit that should not be there, and the pressure that closes the others
        bound = violation(pressure, gap, cells) / (scales.gap * compliance)
        bound += np.abs((closing - level) * cells)
        bound *= MARGIN * scales.pressure
        return float(bound.sum()), float((pressure + bound).max())

    sums, peaks = zip(*in_blocks(missing, pressure, gap, cells, closing), strict=True)
    l1 = float(sum(sums) / pressure.sum())
    # another cell may have the peak; and the inverse, which ignores the ends of a length that does not wrap, is more
    # accurate for the sum than for a single cell
    return max(float(max(peaks) / pressure.max()) - 1, l1), l1

"""How far a solution is from the contact it stands for, by cause."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from contactstudy.accuracy.coarser import Change, change, coarse_solution
from contactstudy.accuracy.discretisation import contact_area, discretisation
from contactstudy.accuracy.expected_error import ErrorParts
from contactstudy.accuracy.subcell import Subcell, subcell
from contactstudy.accuracy.truncation import truncation
from contactstudy.domain.checks import InvalidInput, NotDefined
from contactstudy.problem.constraint import violation
from contactstudy.problem.problem import Problem
from contactstudy.scene.bodies import Layered
from contactstudy.scene.scene import PosedScene
from contactstudy.solvers.solution import Solution, Status

# An approximate inverse is out by up to this factor where the padding is a short window.
MARGIN = 2.0
# What cells hide over the error of smooth edges: below SMOOTH that error is all there is, and no coarser solution
# is needed; up to RESOLVED the pressure in L1 is in error by no more than so many times it. The error of the
# peak pressure grows by so many times what they hide, up to half of that.
SMOOTH, RESOLVED = 0.25, 2.0
L1_RESOLVED, PEAK_RESOLVED = 1.6, 2.0
# Error over the change from cells of twice the size, and over the share of the load whose cells hide heights:
# at most, over nearly all surfaces of the accuracy matrix. Two pressures of one load differ by 2 at most.
CHANGE, AREA_CHANGE, HIDDEN, LARGEST = 1.4, 1.25, 0.5, 2.0
# A pressure that rises like the inverse root of the cell, which is not bounded, by 41 % at a halving. One
# whose rise shrinks like the root of the cell has 2.4 times as much to come.
UNBOUNDED, RISE, FALL = 0.2, 2.5, 1.5
# A corner may add so much of the peak pressure at each halving before it counts as sharp.
SHARP = 0.01
# The mean gap is that much less in error by smooth edges than the pressure, and more by images left out; its
# own change from cells of twice the size counts so much.
GAP_EDGES, GAP_IMAGES, GAP_CHANGE = 0.5, 8.0, 3.0
# A spot of so few cells across is not what the law of a smooth edge is about.
FEW = 5
# Pressure at a roller's end, over the highest, from which the peak at that end may become the highest.
AT_END = 0.5
# Under a coat stiffer than its substrate by more than this, pressure rises at the edges over a share of the
# thickness: with fewer cells in it, errors were up to three times too low (ratios up to 300).
STIFF_COAT, IN_COAT, COAT_FACTOR = 2.0, 8, 3.5
SHARP_EDGE = "a sharp edge or corner"
# Beyond such an error of the whole, the peak pressure is not known either.
LOST = 0.5


@dataclass(frozen=True)
class ErrorEstimate:
    """Relative errors of the peak pressure, the pressure in L1, the contact area and the mean gap.

    The pressure in L1 is judged against the true pressure's cell means: that is what a cell of constant
    pressure stands for. ``warnings`` say in a sentence each why a bound is infinite, or what to change.
    """

    peak_pressure: ErrorParts
    l1: ErrorParts
    contact_area: ErrorParts
    mean_gap: ErrorParts
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Cells:
    """What the cells cost, relative, and why a bound is infinite."""

    peak_pressure: float
    l1: float
    contact_area: float
    mean_gap: float
    warnings: tuple[str, ...] = ()


def error_estimate(
    solution: Solution, *, coarse: Solution | None = None, confidence: float = 0.95
) -> ErrorEstimate:
    """Estimate the errors of ``solution``.

    Where heights and edges are smooth, from the solution itself; else the same contact is solved once more on
    cells of twice the size, its heights sampled anew, and the heights are looked at inside the cells. That
    costs a fifth to two thirds of a solve of a few hundred cells a side. ``coarse`` is that solution, where at hand (see
    :func:`~contactstudy.accuracy.coarser.coarse_solution`). Infinite, with the reason in ``warnings``, where no
    bound can be given: no solution, a contact cut off, a sharp edge's pressure, heights finer than the cells.
    A shape without a ``detail`` is looked at in as many points of each cell as find a feature over 3 % of it with the
    ``confidence``, between 0 and 1.
    Raises :class:`~contactstudy.NotDefined` where the problem does not say its paddings, or no law is
    known for them (see :func:`~contactstudy.accuracy.truncation.truncation`).
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
        lost = ErrorParts(0.0, 0.0, inf)
        return ErrorEstimate(lost, lost, lost, lost, (f"No bound: {solution.status}",))
    peak_cut, l1_cut = 0.0, 0.0
    if problem.source is None or not problem.source.ends_along:
        peak_cut, l1_cut = truncation(solution.pressure, problem.grid, problem.paddings)
    peak_left, l1_left = _residual(solution)
    cells = _cells(solution, coarse, confidence)
    if said := _hidden_coat(problem):
        cells = replace(
            cells,
            peak_pressure=COAT_FACTOR * cells.peak_pressure,
            l1=COAT_FACTOR * cells.l1,
            warnings=(*cells.warnings, said),
        )
    return ErrorEstimate(
        ErrorParts(peak_cut, cells.peak_pressure, peak_left),
        ErrorParts(l1_cut, cells.l1, l1_left),
        ErrorParts(l1_cut, cells.contact_area, l1_left),
        ErrorParts(GAP_IMAGES * l1_cut, cells.mean_gap, l1_left),
        cells.warnings,
    )


def _hidden_coat(problem: Problem) -> str:
    """What there is to say where the cells do not show a coat that is stiffer than its substrate."""
    if not isinstance(problem.description, PosedScene):
        return ""
    for coat in problem.description.scene.solids:
        if not isinstance(coat, Layered):
            continue
        stiffer = coat.substrate.compliance / coat.compliance
        cells = coat.thickness / problem.grid.cell[0]
        if stiffer > STIFF_COAT and cells < IN_COAT:
            return (
                f"The grid has {cells:.2g} cells in a coat {stiffer:.3g} times as stiff as its substrate, where errors "
                f"were seen up to three times what cells show: the bounds are {COAT_FACTOR:g} times as large."
            )
    return ""


def _cells(solution: Solution, coarse: Solution | None, confidence: float) -> _Cells:
    """What the grid costs."""
    problem, pressure = solution.problem, solution.pressure
    assert problem.paddings is not None
    wraps = problem.paddings[0].wraps, problem.paddings[1].wraps
    peak, l1 = discretisation(pressure, wraps)
    area = contact_area(pressure, wraps)
    if solution.status is Status.CONTACT_AT_EDGE:
        said = "No bound: the contact is cut off at the edge of the grid, give Grid.extent a larger one."
        return _Cells(inf, inf, inf, inf, (said,))
    if unseen := _unseen(problem):
        return _Cells(inf, inf, inf, inf, (unseen,))
    inside = subcell(problem, pressure, confidence)
    if inside is None:
        said = (
            "No bound by the cells: Problem.source does not say the heights on other grids, so nothing is "
            "known of them between the cell centres; make the problem from a Scene."
        )
        return _Cells(inf, inf, inf, inf, (said,))
    if inside.stands_out:
        said = (
            "No bound by the cells: between their centres the surface stands out by more than the contact "
            "presses it in; give more cells, or the shape a `detail` that names its finest length."
        )
        return _Cells(inf, inf, inf, inf, (said,))
    yields, sharp_end = _at_hardness(solution), _at_sharp_end(problem, pressure)
    at_end = problem.source is not None and problem.source.ends_along
    at_end = at_end and bool(pressure[:, [0, -1]].any())
    regular = not (yields or at_end) and _spot(pressure, wraps) >= FEW
    if regular and inside.uncertain <= SMOOTH * l1 and inside.corner <= SHARP:
        peak *= 1 + PEAK_RESOLVED * inside.uncertain / l1 if l1 else 1.0
        peak += inside.rise + inside.kink
        return _with_area_warning(_Cells(peak, l1, area, GAP_EDGES * l1))
    coarse = coarse or coarse_solution(problem)
    if coarse is None or coarse.status in (Status.NOT_FINITE, Status.NO_ADMISSIBLE_PRESSURE):
        said = "No bound by the cells: there is no solution on cells of twice the size to compare with."
        return _Cells(inf, inf, inf, inf, (said,))
    seen = change(solution, coarse)
    hides = inside.uncertain / l1 if l1 else inf
    l1_seen = max(CHANGE * seen.l1, HIDDEN * inside.uncertain)
    peak_seen = (RISE if seen.peak_pressure > 0 else FALL) * abs(seen.peak_pressure)
    smooth = regular and inside.corner <= SHARP
    if smooth and hides <= RESOLVED:
        l1_seen = min(l1_seen, L1_RESOLVED * l1)
    peak_known = smooth and hides <= RESOLVED / 2
    if peak_known:
        peak_seen = min(peak_seen, (1 + PEAK_RESOLVED * hides) * peak)
    both = _Cells(
        0.0 if yields else max(peak, peak_seen) + inside.rise + inside.kink,
        LARGEST if _all_alone(pressure) else min(LARGEST, max(l1, l1_seen)),
        max(area, _lost(AREA_CHANGE * seen.contact_area), HIDDEN / 2 * inside.uncertain),
        max(GAP_CHANGE * seen.mean_gap, GAP_EDGES / 2 * l1),
    )
    return _with_area_warning(
        _unbounded(both, problem, inside, seen, sharp_end=sharp_end, exact=yields or peak_known)
    )


def _with_area_warning(cells: _Cells) -> _Cells:
    """``cells``, with a reason where the contact area alone has no bound."""
    if cells.contact_area < inf or cells.l1 == inf:
        return cells
    said = "No bound for the contact area: the spots are one or two cells wide, give more cells."
    return replace(cells, warnings=(*cells.warnings, said))


def _all_alone(pressure: np.ndarray) -> bool:
    """Whether along an axis no two touching cells are neighbours, so that nothing is known inside them."""
    touching = pressure > 0
    return any(
        len(along) > 1 and not (along[1:] & along[:-1]).any() for along in (touching, touching.T)
    )


def _lost(share: float) -> float:
    """The relative error of what may have lost that ``share`` of itself, or gained it."""
    return share / (1 - share) if share < 1 else inf


def _spot(pressure: np.ndarray, wraps: tuple[bool, bool]) -> int:
    """How many cells touch in a row through the peak pressure, along the axis where they are fewest."""
    highest = np.unravel_index(np.argmax(pressure), pressure.shape)
    fewest = pressure.size
    for axis, closed in enumerate(wraps):
        row = np.moveaxis(pressure, axis, 0)[:, highest[1 - axis]] > 0
        if len(row) > 1 and not row.all():
            row = np.roll(row, len(row) // 2 - int(highest[axis])) if closed else row
            middle = len(row) // 2 if closed else int(highest[axis])
            apart = np.flatnonzero(~row)
            before, after = apart[apart < middle], apart[apart > middle]
            first = before[-1] if before.size else -1
            last = after[0] if after.size else len(row)
            fewest = min(fewest, int(last - first - 1))
    return fewest


def _unbounded(
    cells: _Cells, problem: Problem, inside: Subcell, seen: Change, *, sharp_end: bool, exact: bool
) -> _Cells:
    """``cells`` with infinity where no bound can be given, and the reasons."""
    if exact:
        return cells
    why = ""
    if inside.corner > SHARP:
        why = f"it lies at {SHARP_EDGE}, where it is infinite: round the edge, or ask for another quantity"
    elif sharp_end:
        why = "the roller bears pressure up to its sharp end, where it is infinite: give a profile that drops more"
    elif seen.peak_pressure >= UNBOUNDED:
        why = (
            f"it grew by {seen.peak_pressure:.0%} when the cells were halved: give more cells, unless the "
            "surface has a sharp edge"
        )
    elif max(CHANGE * seen.l1, HIDDEN * inside.uncertain) >= LOST:
        why = "the grid hardly shows the surface: give more cells"
    if not why:
        return cells
    return replace(cells, peak_pressure=inf, warnings=(f"No bound for the peak pressure: {why}.",))


def _unseen(problem: Problem) -> str:
    """Why the cells are too large for a length that a shape names; empty where they are not."""
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
    """Whether the peak pressure is a limit of the constraint, which finer cells have too."""
    pressure = solution.pressure
    free = solution.problem.constraint.free(pressure)
    return bool(((pressure == pressure.max()) & (free == 0)).any())


def _at_sharp_end(problem: Problem, pressure: np.ndarray) -> bool:
    """Whether an end of the roller bears pressure of the order of the highest.

    There it is infinite in the limit of small cells, though coarse cells may not show a rise.
    """
    if problem.source is None or not problem.source.ends_along:
        return False
    return bool(max(pressure[:, 0].max(), pressure[:, -1].max()) > AT_END * pressure.max())


def _residual(solution: Solution) -> tuple[float, float]:
    """The same two errors by the gap left over: the pressure that would close it, to first order."""
    problem = solution.problem
    scales, operator = problem.scales, problem.bare().operator
    pressure, gap = solution.pressure / scales.pressure, solution.gap / scales.gap
    free = problem.constraint.free(solution.pressure) > 0
    cells = free.astype(np.float64)
    closing = operator.approximate_inverse()(np.where(free, -gap, 0.0), cells)
    closing = np.where(free, closing - closing.mean(where=free) if free.any() else 0.0, 0.0)
    # of cells at a limit that should not be
    bound = violation(pressure, gap, cells) / operator.own
    missing = MARGIN * (np.abs(closing) + bound)
    l1 = float(missing.sum() / pressure.sum())
    # another cell may yet become the highest; and the inverse, blind to where a length that does not wrap
    # ends, tells the whole better than the single cell
    highest = float(pressure.max())
    return max(float((pressure + missing).max()) / highest - 1, l1), l1

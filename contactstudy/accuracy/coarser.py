"""Errors due to the cells: from a pressure on one grid, and from the same contact solved on cells of twice the size.

A pressure (x, y) is constant in each cell. It wraps along an axis where the padding makes that axis periodic. Sides are
borders between a cell in contact and one out of contact, the discrete outline of the contact.

Beside a straight edge, many cells from any other, the pressure goes with the square root of the distance from it. Its
error in cells of constant pressure depends on the place of the edge alone: how many cells outward of the centre of the
last cell in contact it lies. The law of an edge says how: smooth cylinders with edges at each place are solved directly
on a row of cells, and compared with Hertz's pressure.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import ceil, inf, log, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.errors import MARGIN
from contactstudy.domain.grid import Array, Grid, Paddings, axis_first, edge_fraction, is_free, on_cells
from contactstudy.domain.validation import InvalidInput
from contactstudy.problem.constraint import Dugdale, Exponential
from contactstudy.problem.problem import Problem, Source
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Cells across the cylinder: with half or twice as many the errors change by 2 % and 1 %, places by 0.01 cells.
CELLS = 80
# First and last place of the edge, and number of places: further inward the last cell loses contact, further outward
# the next one gains it. The places are 0.017 cells apart.
PLACES, STEPS = (-0.175, 0.83), 60
# Distance in cells within which the largest error counts, since the error jumps where the edge passes the centre of a
# cell. Without it the error is up to 41 % smaller.
JUMP_RANGE = 0.06
# Conditions under which a straight edge follows the law. At least MIN_TOUCHING cells touch across: the other edge then
# changes the last three pressures by a tenth at most. At least MIN_OPEN cells are open, so that the edge is not that of
# a narrow opening inside the contact. Its places by two pairs of cells differ by at most MAX_DIFFERENCE cells, half the
# range of places.
MIN_TOUCHING, MIN_OPEN, MAX_DIFFERENCE = 12, 3, 0.5
# Steps between places by which the law is extended in a straight line beyond either end, so that pairs of cells that
# both lie beyond it give different places.
BEYOND = 10 * STEPS


class _EdgeLaw(NamedTuple):
    """Pressure of the cells beside an edge and its error, for each place of the edge from inside outwards.

    Attributes
    ----------
    place
        Place (n,) of the edge, in cells outward of the centre of the last touching cell.
    error
        L1 error (n,) of the pressure at one edge [cells], over the pressure of the second touching cell.
    ratios
        Pressure (n,) of the last touching cell over that of the second, and of the second over that of the third.
    """

    place: Array
    error: Array
    ratios: tuple[Array, Array]


@cache
def _edge_law() -> _EdgeLaw:
    """Return the law of an edge, from cylinders of the half-width a [cells] whose pressure is ``sqrt(a^2 - x^2)``.

    The contact modulus is 2 / pi and the radius of the cylinder is such that its gap is ``pi x^2 / 2`` without load.
    """
    from scipy.linalg import toeplitz  # imported late, since it is slow

    places = np.linspace(*PLACES, STEPS)
    x = np.arange(CELLS) - (CELLS - 1) / 2
    borders = np.arange(CELLS + 1) - 0.5
    # displacements, by the integral of ln |x| over a cell, and the approach, which the load pi a^2 / 2 determines
    matrix = np.ones((CELLS + 1, CELLS + 1))
    matrix[:-1, :-1] = toeplitz(-np.diff(borders * np.log(np.abs(borders))))
    matrix[:-1, -1], matrix[-1, -1] = -1.0, 0.0
    inverse = np.linalg.inv(matrix)
    errors, last_three = np.empty(STEPS), np.empty((3, STEPS))
    for number, half_width in enumerate(x[-1] + places):
        pressure = (inverse @ np.append(-np.pi / 2 * x**2, np.pi / 2 * half_width**2))[:-1]
        # the true pressure as its means in the cells of the right half, and at the centres
        angle = np.arcsin(np.clip(np.arange(CELLS // 2 + 2) / half_width, -1, 1))
        means = np.diff(half_width**2 / 2 * (angle + np.sin(angle) * np.cos(angle)))
        true = np.sqrt(np.maximum(half_width**2 - x**2, 0))
        right = pressure[CELLS // 2 :]
        # the cell beyond the last may hold the edge too
        of_means = np.abs(right - means[:-1]).sum() + means[-1]
        last_three[:, number] = right[:-4:-1] / _opposite_edge(2 * half_width)
        errors[number] = max(np.abs(right - true[CELLS // 2 :]).sum(), of_means) / right[-2]
    near = np.abs(places[:, None] - places) <= JUMP_RANGE
    last, second, third = last_three
    return _EdgeLaw(places, np.where(near, errors, 0).max(axis=1), (last / second, second / third))


def _opposite_edge(width: float) -> Array:
    """Return the factors by which the opposite edge, at the `width` [cells], lowers the last three pressures.

    Hertz's pressure is the root of the product of the distances s and width - s from both edges, s being 0.33 cells in
    the last touching cell in the mean of all places of the edge.
    """
    return np.asarray(np.sqrt(1 - (np.arange(3) + 0.33) / width))


def edge_error(last: Array, inner: Array) -> Array:
    """Return the L1 error of the pressure at an edge, ``sum |p - true|`` over the cells, from the two next to the edge.

    The true pressure is taken at the centres or as its mean in the cells, whichever error is larger. The ratio of the
    two cells tells where in its cell the edge of a smooth contact lies. The error jumps where the edge passes the
    centre of a cell, so the largest error within `JUMP_RANGE` cells to either side counts. Where a single cell
    touches, or `last` is the higher, the law no longer holds, and the edge is taken to lie as far out as it can.

    Parameters
    ----------
    last
        Pressure (n,) of the last touching cell at each edge.
    inner
        Pressure (n,) of the next cell inward; 0 where it does not touch.
    """
    law = _edge_law()
    last_over_second = law.ratios[0]
    inner = np.maximum(inner, last / last_over_second[-1])
    return np.asarray(np.interp(last / inner, last_over_second, law.error) * inner)


class StraightEdges(NamedTuple):
    """Straight, smooth edges across a contact.

    Attributes
    ----------
    places
        Places (side, y) of both edges, in cells outward of the middle of the grid; the side at larger x comes first.
    uncertainty
        Uncertainty [cells] of both places together, the sum of two parts. The difference between the place by the last
        two cells and that by the second and third was 1.7 to 40 times the error on cylinders of 16 to 200 cells. The
        second difference of the places along y is that by which an edge bends within a cell.
    """

    places: Array
    uncertainty: float


def _extended(values: Array) -> Array:
    """Return `values` of the law (n,) with one more `BEYOND` steps from either end, in line with the two before it."""
    first, last = values[0] + BEYOND * (values[0] - values[1]), values[-1] + BEYOND * (values[-1] - values[-2])
    return np.concatenate([[first], values, [last]])


def straight_edges(pressure: Array) -> StraightEdges | None:
    """Return the edges across of a contact with the `pressure` (x, y); None unless they are straight and smooth.

    All rows across then touch in the same cells, `MIN_TOUCHING` and more without a gap. At least `MIN_OPEN` cells are
    open, some of them at either end, and the cells beside both edges follow the law of an edge.
    """
    touching = np.flatnonzero(pressure[:, 0])
    first, last = (int(touching[0]), int(touching[-1])) if touching.size else (0, 0)
    is_straight = ((pressure > 0) == (pressure[:, :1] > 0)).all() and last - first == touching.size - 1
    if not is_straight or touching.size < MIN_TOUCHING or len(pressure) - touching.size < MIN_OPEN:
        return None
    if first == 0 or last == len(pressure) - 1:
        return None
    sides = np.stack([pressure[last : last - 3 : -1], pressure[first : first + 3]])
    sides = sides / _opposite_edge(touching.size)[:, None]
    place, _, ratios = _edge_law()
    # by the last two cells, and by the second and the third
    places, others = (np.interp(sides[:, k] / sides[:, k + 1], _extended(ratios[k]), _extended(place)) for k in (0, 1))
    differences = np.abs(places - others)
    if differences.max() > MAX_DIFFERENCE:
        return None
    places = np.clip(places, place[0], place[-1])
    bends = np.abs(np.roll(places, 1, axis=1) + np.roll(places, -1, axis=1) - 2 * places)
    uncertainty = float((differences.max(axis=1) + bends.max(axis=1)).sum())
    middle = (len(pressure) - 1) / 2
    return StraightEdges(places + np.array([[last - middle], [middle - first]]), uncertainty)


# Change of a maximum, over its second difference, as edges move in their cells. It is 1/16 in closed form between two
# straight edges that fall alike, and taken a third larger for edges that are neither straight nor alike.
EDGE_EFFECT = 1 / 12
# The same where the maximum lies within two cells of an edge, where no parabola holds: four times as much. Cylinders
# three and four cells across needed 0.05; edges that are not straight may need more.
EDGE_EFFECT_BESIDE = 1 / 3
# Uncertainty, in cells, of the place of an edge that is not straight: it may lie anywhere in its cell, half a cell to
# either side of the middle.
EDGE_UNCERTAINTY = 0.5
# Excess of the counted area per side of its outline, in cells: ``(pi - 1 + ln 2) / 24`` in the mean of all directions
# of an edge (Yastrebov, Anciaux & Molinari 2017, Tribology Int. 114, 161).
SIDE_EXCESS = (pi - 1 + log(2)) / 24
# Uncertainty, in cells, of two straight edges together, in addition to that of :class:`StraightEdges`. At most 0.0017
# cells were needed on 150 cylinders of 12 to 150 cells across the contact.
STRAIGHT_UNCERTAINTY = 0.006
# Fraction of the grid in contact from which openings as narrow as a cell count. Below it, the edges of wider openings
# leave more of the area open than these.
NEARLY_FULL = 0.9


def with_ends(field: Array, count: int, *, wraps: bool) -> Array:
    """Return `field` (n, ...) with `count` more rows at either end: periodic ones where it wraps, else the last one."""
    before, after = (field[-count:], field[:count]) if wraps else (field[:1], field[-1:])
    repeats = 1 if wraps else count
    return np.concatenate([*[before] * repeats, field, *[after] * repeats])


def wraps_of(problem: Problem) -> tuple[bool, bool]:
    """Return whether a pressure of `problem` wraps (across, along); not where its paddings are not known."""
    return (False, False) if problem.paddings is None else (problem.paddings[0].wraps, problem.paddings[1].wraps)


def contact_perimeter(touching: NDArray[np.bool_], grid: Grid, paddings: Paddings | None) -> float:
    """Return the length [m] of all sides between `touching` cells (x, y) and others.

    Sides across the ends of an axis count too, unless its padding leaves the surface free beyond them; None as
    `paddings` counts none.
    """
    wraps = (False, False) if paddings is None else tuple(not is_free(padding) for padding in paddings)
    across, along = _lengths_of_sides(touching, wraps)
    return float(across.sum() * grid.cell_size[1] + along.sum() * grid.cell_size[0])


def _lengths_of_sides(touching: NDArray[np.bool_], wraps: Sequence[bool]) -> list[NDArray[np.intp]]:
    """Return the lengths [cells] of all straight rows of sides of `touching` cells (x, y), for both axes.

    Those of the first array lie between neighbours across, those of the second between neighbours along. Sides across
    the ends of an axis count where it wraps.
    """
    lengths = []
    for axis, is_periodic in enumerate(wraps):
        rows = np.moveaxis(touching, axis, 0)
        sides = np.diff(np.concatenate([rows, rows[:1]] if is_periodic else [rows]), axis=0)
        steps = np.diff(np.pad(sides, ((0, 0), (1, 1))).astype(int), axis=1)
        lengths.append(np.flatnonzero(steps == -1) - np.flatnonzero(steps == 1))
    return lengths


def around_contact(pressure: Array) -> slice:
    """Return the rows along x of a `pressure` (x, y) with contact, and one more on each side; all rows if one lacks."""
    touching = np.flatnonzero(pressure.max(axis=1) > 0)
    if not touching.size or touching[0] == 0 or touching[-1] == len(pressure) - 1:
        return slice(None)
    return slice(int(touching[0]) - 1, int(touching[-1]) + 2)


def discretisation_errors(pressure: Array, wraps: tuple[bool, bool]) -> tuple[float, tuple[float, float]]:
    """Return the relative errors of the peak pressure and of the pressure in L1 (across, along) due to the cells.

    The maximum lies beside a cell's centre, above the pressure of that cell by the parabola through three cells. That
    pressure is itself a 24th of the second difference too high. Both depend on where the edges lie in their cells.

    In L1 each end of a row of touching cells adds its :func:`~contactstudy.accuracy.coarser.edge_error`, and each cell
    within adds a 12th of its second difference. For a wave of the wave number q on cells of the size dx, the pressure of
    a cell is ``1 / sinc(q dx / 2)`` times the true one at its centre, with ``sinc(t) = sin(t) / t``. The true mean in
    the cell is ``sinc(q dx / 2)`` times the latter. The errors of both axes add up, since an edge that is oblique to
    the cells has ends along both. Heights between the cell centres are not included.

    Parameters
    ----------
    pressure
        Pressure (x, y).
    wraps
        Whether the surface wraps across and along.
    """
    highest = np.unravel_index(np.argmax(pressure), pressure.shape)
    level = float(pressure[highest])
    beside, edges, l1 = 0.0, 0.0, [0.0, 0.0]
    for axis, is_periodic in enumerate(wraps):
        if pressure.shape[axis] == 1:
            continue
        along = axis_first(pressure, axis)
        # beyond an open end the last cell is repeated
        padded = with_ends(along, 1, wraps=is_periodic)
        touching = padded > 0
        bends = np.abs(padded[:-2] + padded[2:] - 2 * padded[1:-1])
        within = touching[:-2] & touching[1:-1] & touching[2:]
        last, second = _ends(padded, touching)
        # a plateau ends half-way in its last cell, which has the mean pressure
        plateau = last[second >= level]
        l1[axis] = float(
            (bends * within).sum() / 12 + edge_error(last, second).sum() + np.minimum(plateau, level - plateau).sum()
        )
        index, line = highest[::-1] if axis else highest
        before, centre, after = padded[index : index + 3, line].tolist()
        slope, curvature = (after - before) / 2, abs(before + after - 2 * centre)
        # the parabola's vertex is slope / curvature cells away
        beside += slope**2 / curvature / 2 - curvature / 24 if curvature > 0 else 0.0
        around = padded[max(index - 1, 0) : index + 4, line] > 0
        edges = max(edges, (EDGE_EFFECT if around.all() else EDGE_EFFECT_BESIDE) * curvature)
    total = float(pressure.sum())
    return (abs(beside) + edges) / level, (l1[0] / total, l1[1] / total)


def _ends(padded: Array, touching: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return the pressures of all cells at an end of a row of `touching` cells, and of their neighbours inward.

    The rows run along the first axis of the pressure `padded` (n + 2, lines), which has one more cell at either end, as
    has `touching`.
    """
    first, last = (touching[1:-1] & ~beyond for beyond in (touching[:-2], touching[2:]))
    along, before, after = padded[1:-1], padded[:-2], padded[2:]
    ends = np.concatenate([along[first], along[last]])
    return ends, np.concatenate([after[first], before[last]])


def contact_area_in_cells(pressure: Array, wraps: tuple[bool, bool], edges: StraightEdges | None = None) -> float:
    """Return the contact area of a `pressure` (x, y) in cells, with its edges inside them.

    Straight `edges` across follow from the pressure beside them, and are found if not at hand
    (:func:`~contactstudy.accuracy.coarser.straight_edges`). Along others each cell in contact counts as a whole,
    less ``SIDE_EXCESS`` for each side of the outline.
    """
    if (edges := edges or straight_edges(pressure)) is not None:
        return float(edges.places.sum())
    sides = sum(int(lengths.sum()) for lengths in _lengths_of_sides(pressure > 0, wraps))
    return float(max(np.count_nonzero(pressure) - SIDE_EXCESS * sides, 0.0))


def unseen_area_error(pressure: Array, wraps: tuple[bool, bool], edges: StraightEdges | None) -> float:
    """Return the relative error of :func:`contact_area_in_cells` of the same arguments that no change of grids shows.

    It is the uncertainty of the edges, and in a nearly full contact that of openings as narrow as a cell, which may be
    there or not. Errors of edges that lie anywhere in their cells cancel for the most part, but along one straight row
    of sides they are alike. The error is infinite where no area may remain.
    """
    area, lost = contact_area_in_cells(pressure, wraps, edges), float(_narrow_openings(pressure, wraps))
    if edges is not None:
        lost += pressure.shape[1] * (edges.uncertainty + STRAIGHT_UNCERTAINTY)
    else:
        lengths = np.concatenate(_lengths_of_sides(pressure > 0, wraps))
        lost += EDGE_UNCERTAINTY * float((lengths**2).sum()) ** 0.5
    return relative_loss(lost / area) if area else inf


def _narrow_openings(pressure: Array, wraps: tuple[bool, bool]) -> int:
    """Return the number of cells, between two touching ones, that are open or so little pressed that they may open.

    A parabola whose least value is zero, half a cell beside a centre, has an eighth of its second difference at that
    centre; up to twice that pressure the contact may open between the centres. Where less than `NEARLY_FULL` of the
    grid is in contact, the number is 0.
    """
    if np.count_nonzero(pressure) < NEARLY_FULL * pressure.size:
        return 0
    bends = np.zeros(pressure.shape)
    for axis, is_periodic in enumerate(wraps):
        if pressure.shape[axis] > 1:
            padded = with_ends(axis_first(pressure, axis), 1, wraps=is_periodic)
            are_between = (padded[:-2] > 0) & (padded[2:] > 0)
            second_difference = np.maximum(padded[:-2] + padded[2:] - 2 * padded[1:-1], 0) * are_between
            bends += axis_first(second_difference, axis)
    return int(np.count_nonzero(pressure < bends / 4))


def relative_loss(fraction: float) -> float:
    """Return the relative error of a quantity that may have lost or gained the given `fraction` of itself."""
    return float(fraction / (1 - fraction)) if fraction < 1 else inf


# Tolerance of the coarse solution. Its solve begins with means of the fine pressure, which on several hundred cells are
# within 1e-4 of the coarse one: with a larger tolerance it would end at once, and show no change.
COARSE_TOLERANCE = 1e-6
# Tolerance of a coarse solution with adhesion: near separation the iteration changes so slowly that it meets a larger
# tolerance before the bodies come apart.
ADHESIVE_TOLERANCE = 1e-7
# Relative error of the work of adhesion by which cells trap the edge of a contact, times the cells in the cohesive
# zone, by the law of the attraction. The loads at which an edge passes from cell to cell, up and down, differ by it. By
# pull-off loads it was at most 0.04 with the exponential law, on 1.3 cells and more; with Dugdale's 0.11, on 3.5 to 14.
TRAPPED_WORK: dict[type, float] = {Exponential: 0.06, Dugdale: 0.25}


@dataclass(frozen=True)
class DiscretisationErrors:
    """Relative errors due to the cells, or changes of a solution from other cells.

    Attributes
    ----------
    l1
        Error of the net pressure in L1; a change is that of its means over the coarser cells.
    peak_pressure, contact_area, load
        Errors of these numbers; that of the `load` is None where the load is given.
    warnings
        A sentence for each infinite error, or on what to change.
    """

    l1: float
    peak_pressure: float
    contact_area: float
    load: float | None = None
    warnings: tuple[str, ...] = ()

    @classmethod
    def of_each(cls, number: Callable[..., float], *errors: "DiscretisationErrors") -> "DiscretisationErrors":
        """Return for each of the four numbers what `number` makes of its `errors`; a load that is given has none."""
        rows = ((error.l1, error.peak_pressure, error.contact_area, error.load or 0.0) for error in errors)
        l1, peak, area, load = (number(*of_each) for of_each in zip(*rows, strict=True))
        return cls(l1, peak, area, load)

    @classmethod
    def unbounded(cls, reason: str, load: float | None = None) -> "DiscretisationErrors":
        """Return infinite errors with their reason; that of the `load` is None where the load is given."""
        return cls(inf, inf, inf, load, (reason,))


def coarsened(grid: Grid, factor: int) -> Grid:
    """Return `grid` with 1 / `factor` of the cells along each axis, rounded up, at least 2 across, on its extent."""
    nx, ny = grid.cells
    return Grid((max(2, ceil(nx / factor)), ceil(ny / factor)), grid.extent)


def coarser_problem(problem: Problem, factor: int = 2) -> Problem | None:
    """Return `problem` on cells of about `factor` times the size.

    It is None without a source, which samples the heights on other grids, where the source refuses such cells, and
    where the grid is two cells wide. Heights that the source does not contain, such as wear, are averaged over the
    larger cells. Constraint and control are those of `problem`; with adhesion they are those of the source, as the law
    of the attraction may belong to the grid.
    """
    source = problem.source
    if source is None or problem.grid.cells[0] == 2:
        return None
    try:
        coarse = source.problem(coarsened(problem.grid, factor))
    except InvalidInput:
        return None
    if problem.adhesion is None:
        area_ratio = problem.grid.cell_area / coarse.grid.cell_area  # the control has the load as a sum over cells
        control = problem.control.scaled(area_ratio)
        coarse = replace(coarse, constraint=problem.constraint, control=control)
    added = _added_heights(source, problem)
    if added is None:
        return coarse
    gap = coarse.undeformed_gap + on_cells(added, coarse.grid.cells)
    return replace(coarse, undeformed_gap=gap)


def change_between_grids(fine: Solution, coarse: Solution) -> DiscretisationErrors:
    """Return the changes from `coarse`, the same contact on larger cells, to `fine`.

    They are relative to the values of `fine`, that of the peak pressure to its value of `coarse`.
    """
    net = fine.net_pressure
    means = on_cells(net, coarse.pressure.shape)
    areas = [touching_fraction(solution) for solution in (fine, coarse)]
    loads = [solution.load_per_length for solution in (fine, coarse)]
    return DiscretisationErrors(
        float(np.abs(means - coarse.net_pressure).sum() / np.abs(means).sum()),
        abs(fine.peak_pressure / coarse.peak_pressure - 1) if coarse.peak_pressure else inf,
        abs(areas[1] / areas[0] - 1),
        abs(loads[0] - loads[1]) / abs(loads[0]) if loads[0] else inf,
    )


def touching_fraction(solution: Solution) -> float:
    """Return the fraction of the grid in contact, with edges inside their cells; with adhesion that of whole cells."""
    pressure = solution.pressure
    if solution.adhesion is not None or solution.problem.paddings is None:
        return float((pressure > 0).mean())
    return contact_area_in_cells(pressure, wraps_of(solution.problem)) / pressure.size


def comparable(coarse: Solution | None) -> Solution | None:
    """Return a `coarse` solution that others can be compared with, else None.

    It converged, is as accurate as rounding lets it be, or found that the bodies do not touch.
    """
    if coarse is None:
        return None
    ended = coarse.status in (Status.PRECISION_LIMIT, Status.DETACHED)
    return coarse if ended or coarse.status.has_converged else None


def error_by_change(solution: Solution, coarse: Solution | None) -> DiscretisationErrors:
    """Return the errors of `solution` by its change from cells of twice the size.

    `coarse` is the solution on those; None solves for it. The errors are infinite where that fails, or where the bodies
    do not touch on those cells. Under a given load the change itself counts. With adhesion or at a given approach
    errors fall less steeply, so that `MARGIN` times the change counts, and of the area at least the cells at its edge.
    """
    start = solution.pressure, solution.attraction
    coarse = comparable(coarse or coarse_solution(solution.problem, *start))
    if coarse is None or not coarse.pressure.any():
        why = "there is no solution" if coarse is None else "the bodies do not touch"
        reason = f"No bound for the discretisation error: on cells of twice the size {why}, give more cells."
        return DiscretisationErrors.unbounded(reason, load=inf)
    change = change_between_grids(solution, coarse)
    if solution.adhesion is None and solution.problem.control.approach is None:
        return change
    errors = DiscretisationErrors.of_each(lambda number: MARGIN * number, change)
    errors = replace(errors, contact_area=max(errors.contact_area, edge_fraction(solution.pressure > 0)))
    return errors if solution.adhesion is None else _with_trapping(errors, solution)


def _with_trapping(errors: DiscretisationErrors, solution: Solution) -> DiscretisationErrors:
    """Return the `errors` of a contact with adhesion with those by trapping of its edge (lattice trapping).

    Cells hold the edge of the contact as if the work of adhesion were off by a fraction, `TRAPPED_WORK` over the cells
    in the cohesive zone. The contact is solved with more and with less work by that fraction, at the same strength, and
    the larger change of each number adds to its error. The errors are infinite where the bodies then come apart, or no
    solution is found.
    """
    problem, adhesion = solution.problem, solution.adhesion
    assert adhesion is not None
    if adhesion.first_unstable_load is not None:  # the search for a pull-off load has its own part
        return errors
    solver: Any = problem.adhesion
    fraction = TRAPPED_WORK[type(solver.law)] / adhesion.cells_in_zone
    changes = []
    for sign in (1, -1):
        factor = 1 + sign * fraction
        law = replace(solver.law, work=factor * solver.law.work, range=factor * solver.law.range)
        adhesive = replace(solver.continued(adhesion.attraction), law=law)
        posed = replace(problem, friction=None, adhesion=adhesive)  # the pressure alone is compared
        other = solve_contact(posed, SolveOptions(ADHESIVE_TOLERANCE), solution.pressure)
        if comparable(other) is None or not other.pressure.any():
            reason = (
                f"No bound for the discretisation error: the cells hold the edge of the contact as a work of adhesion "
                f"that is off by {fraction:.1%}, with which the bodies come apart, give more cells."
            )
            return DiscretisationErrors.unbounded(reason, load=inf)
        changes.append(change_between_grids(solution, other))
    return DiscretisationErrors.of_each(lambda error, more, less: error + max(more, less), errors, *changes)


def coarse_solution(
    problem: Problem, pressure: Array | None = None, attraction: Array | None = None, factor: int = 2
) -> Solution | None:
    """Return the solution on cells of `factor` times the size, as accurate as a comparison needs where it converges.

    It begins with the means of a `pressure` and an `attraction` (x, y) [Pa] on the grid of `problem`, if they are
    given. It is None where `coarser_problem` is.
    """
    coarse = coarser_problem(problem, factor)
    if coarse is None:
        return None
    start = None if pressure is None else on_cells(pressure, coarse.grid.cells)
    if coarse.adhesion is not None and attraction is not None:
        adhesion = coarse.adhesion.continued(on_cells(attraction, coarse.grid.cells))
        coarse = replace(coarse, adhesion=adhesion)
    tolerance = COARSE_TOLERANCE if coarse.adhesion is None else ADHESIVE_TOLERANCE
    return solve_contact(coarse, SolveOptions(tolerance), start)


def _added_heights(source: Source, problem: Problem) -> Array | None:
    """Return the heights (x, y) [m] in `problem` that its source does not contain, such as wear; None without any.

    Differences below a relative 1e-9 of the largest gap are rounding.
    """
    heights = source.gap(problem.grid)
    if problem.undeformed_gap is heights:
        return None
    added = problem.undeformed_gap - heights
    if not added.any():
        return None
    largest_gap = np.abs(problem.undeformed_gap).max()
    return added if np.abs(added).max() > 1e-9 * largest_gap else None

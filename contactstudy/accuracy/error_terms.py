"""Error terms beside those of the cells: images left out, the residual of the solver, a finite range of attraction.

All are relative to the number that they belong to. Images are the periods of the pressure beside the domain; a padding
sums those of its `window`, a range of periods relative to that of a point, and all of them where the window is None. In
the JKR limit (Johnson, Kendall & Roberts 1971) the range of the attraction is zero; where no range is given, the solver
takes the shortest that the cells hold, and the attraction is called `regularised`.
"""

from dataclasses import replace
from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from contactstudy.accuracy.coarser import ADHESIVE_TOLERANCE, TRAPPED_WORK, coarsened, contact_perimeter, relative_loss
from contactstudy.domain.device import Precision
from contactstudy.domain.errors import ErrorParts
from contactstudy.domain.grid import MIN_COMPILED_CELLS, Array, Grid, Padding, Paddings, in_blocks, inner
from contactstudy.domain.validation import NotDefined, readable
from contactstudy.problem.constraint import cell_violation, zone_length
from contactstudy.scene.scene import PosedScene, scene_of
from contactstudy.scene.solids.bodies import contact_modulus
from contactstudy.solvers.solution import AdhesiveTraction, Solution
from contactstudy.solvers.solve import SolveOptions, solve_contact

# A cylinder that is cut off by a domain has neighbours; a sphere, or a roller that ends, may have none.
IMAGES_REMEDY = (
    "give ExactPeriodicity along their axis, or for a body without neighbours ZeroPadding and a grid that holds its "
    "contact"
)
# Relative L1 change of Hertz's ellipse under one load, over the small fraction of its half-width by which it is made
# narrower, ``(2 / pi) int |cos 2 t| dt`` over half a turn, or shifted.
L1_OVER_NARROWING = 4 / np.pi
# With n images to each side, in a window centred on the domain, the line load varies by
# END_VARIATION (a / L)^END_VARIATION_POWER / (2 n + 1)^2 in the mean over the length L, a being the half-width:
# measured for L from 0.15 to 9.6 half-widths, on 32 to 288 cells.
END_VARIATION, END_VARIATION_POWER = 0.5, 0.7
# Bound for a roller that ends, over the law of an endless contact with the larger of the half-widths across and along:
# errors were at most 1.31 times that law on 336 sharp and Lundberg rollers of 2.5 to 30 half-widths, on grids of 1 to 3
# times the length with 1 to 4 images on either axis.
ENDS_MARGIN = 1.5


def image_errors(pressure: Array, grid: Grid, paddings: Paddings, margin: float = 1.0) -> tuple[float, float]:
    """Return the relative errors of the peak pressure and of the pressure in L1 due to images left out by a padding.

    The displacement by a uniform line of pressure at the distance x is a logarithm of x. A window that reaches the
    distance D to each side along that line takes ``x^2 / (2 D^2)`` from the logarithm, and so makes the contact, of the
    half-width ``a = 2 rms(x)``, too highly curved by the factor ``1 + a^2 / (4 D^2)``. A window centred on the domain,
    of the length L with n images to each side, also misses more at the ends ``y = L / 2``, by
    ``-ln(1 - (2 y / L)^2 / (2 n + 1)^2)``: under that kink the pressure rises, j cells from the end by the fraction
    ``(2 / pi) (a / L) ln(cells / (2 j + 1)) / (2 n + 1)^2``. Without any images the solution's own line load shows the
    error at the ends. The errors are zero where all images are summed, or a length without images holds the whole
    contact. A body that ends along the length is not uniform along it, so that the images bend it along both axes, by
    its larger half-width, within `ENDS_MARGIN`. An attraction beside the contact bends it as pressure does, so that the
    load at pull-off, which goes with the third root of the radius, has an error below that in L1.

    Parameters
    ----------
    pressure
        Pressure (x, y) in any unit; with adhesion the size of the net pressure.
    grid
        Its grid.
    paddings
        Paddings (across, along).
    margin
        Factor on the law of an endless contact: `ENDS_MARGIN` for a body that ends along the length, where contact may
        reach the ends of a length without images.

    Raises
    ------
    NotDefined
        For a window on one axis with images on the other.
    """
    across, along = paddings
    if _counts_images(across):  # the law is that along the axis of the images: exchange the axes
        pressure, (along, across) = pressure.T, (across, along)
        period, positions, others = grid.extent[0], grid.y, grid.x
    else:
        period, positions, others = grid.extent[1], grid.x, grid.y
    ends = margin > 1
    reaches_ends = not ends and _reaches_ends(pressure)
    # zeros about a contact that ends within the length leave nothing out
    free = not (hasattr(along, "images") or along.wraps or reaches_ends)
    if along.window is None or (free and len(along.window) == 1):
        return 0.0, 0.0
    if across.window is None or _counts_images(across) or across.wraps:
        raise NotDefined(
            f"padding is {paddings!r}: give ExactPeriodicity() for the axis that counts images, or "
            "ZeroPadding() for the other; only then is the error of a window known."
        )
    half_width = _half_width(pressure, positions)
    if ends:
        half_width = max(half_width, _half_width(pressure.T, others))
    narrowing = margin * _narrowing(half_width, period, pressure.shape[1], along)
    peak, mean = _end_errors(pressure, along, half_width / period)
    return float((1 + narrowing) * (1 + peak) - 1), float(L1_OVER_NARROWING * narrowing + mean)


def _counts_images(padding: Padding) -> bool:
    """Return whether a `padding` sums images, and a finite number of them."""
    return padding.window is not None and len(padding.window) > 1


def _narrowing(half_width: float, period: float, cells: int, along: Padding) -> float:
    """Return the fraction by which the images left out raise the peak of a contact and narrow it.

    The contact has a `half_width` [m]; the images repeat after a `period` [m] of some `cells` under the padding
    `along`.
    """
    assert along.window is not None
    reach = along.reach(period)
    # an even number of cells cannot lie symmetrically about the cell whose displacement is summed
    asymmetry = period / cells / 2 if along.wraps and len(along.window) * cells % 2 == 0 else 0.0
    inverse_square = ((reach + asymmetry) ** -2 + (reach - asymmetry) ** -2) / 2
    return float(np.sqrt(1 + half_width**2 * inverse_square / 4) - 1)


def _kink(ratio: float, periods: int, cells: int) -> Array:
    """Return the factor (y,) by which the pressure rises towards the ends of a window centred on the domain.

    The `ratio` is that of half-width and period. The window has this number of `periods`, of some `cells` each.
    """
    odd = 2 * np.minimum(np.arange(cells), np.arange(cells)[::-1]) + 1
    return np.asarray(1 + 2 / np.pi * ratio * np.log(cells / odd) / periods**2)


def _end_errors(pressure: Array, along: Padding, ratio: float) -> tuple[float, float]:
    """Return the errors of the peak pressure and of the pressure in L1 by its variation along the length.

    Parameters
    ----------
    pressure
        Pressure (x, y).
    along
        Padding along the length.
    ratio
        Half-width over period.
    """
    assert along.window is not None
    if along.wraps or pressure.shape[1] == 1:  # a window is centred on the only cell
        return 0.0, 0.0
    if len(along.window) == 1 and _reaches_ends(pressure):
        load = pressure.sum(axis=0) / pressure.sum(axis=0).mean()
        return max(load[0], load[-1], 1.0) - 1, float(np.abs(load - 1).mean())
    kink = _kink(ratio, len(along.window), pressure.shape[1])
    row_peaks = pressure.max(axis=0)
    # a maximum away from the ends is not raised by them
    peak_rise = float(row_peaks.max() / (row_peaks / kink).max()) - 1
    return peak_rise, END_VARIATION * ratio**END_VARIATION_POWER / len(along.window) ** 2


def _reaches_ends(pressure: Array) -> bool:
    """Return whether a `pressure` (x, y) acts at either end of the length."""
    return bool(pressure[:, [0, -1]].any())


def _half_width(pressure: Array, x: Array) -> float:
    """Return the half-width of the Hertz contact whose load has the same rms distance from its axis as a `pressure`.

    The pressure is (x, y), and the half-width has the unit of the positions `x` (x, 1) or (x,) of its rows.
    """
    fraction = pressure.sum(axis=1) / pressure.sum()
    middle = (fraction * x).sum()
    return 2 * float(np.sqrt((fraction * (x - middle) ** 2).sum()))


# Factor on the pressure by the approximate inverse, which was too small by a factor of up to 2.3 in 2320 solves, most
# where the padding is a window on an odd number of cells.
INVERSE_MARGIN = 2.5


class ResidualErrors(NamedTuple):
    """Errors by the residual: those of peak pressure, pressure in L1 and contact area are relative, `gap` is in m."""

    peak_pressure: float
    l1: float
    contact_area: float
    gap: float


def residual_errors(solution: Solution, change: float = 0.0) -> ResidualErrors:
    """Return the errors by the gap that the solver left on cells in contact: of the pressure that would close it.

    That pressure follows from the preconditioner of the solver, an approximate inverse of the operator. Beside the
    contact the gap changes by no more than in it, by the maximum principle. A cell that enters or leaves the contact
    changes the pressure by its own: the cells of the smallest pressures, as many as carry the L1 error, may do so. The
    error of the load, and of a gap beside far larger heights, add to that of the pressure. A relative `change` of the
    pressure, such as that of an attraction in the last iteration around the contact, may be left beside the residual.
    """
    pressure, gap, scales = solution.pressure, solution.gap, solution.problem.scales
    scale = scales.pressure / scales.gap
    operator = solution.problem.operator.scaled(scale, Precision.DOUBLE)
    compliance = operator.self_compliance
    # single precision takes half the time, which counts where compiled loops pay; None takes that of the operator
    inverse = operator.approximate_inverse(Precision.SINGLE if pressure.size >= MIN_COMPILED_CELLS else None)
    cells = solution.problem.constraint.active(pressure).astype(inverse.real, copy=False)
    correction, level = (gap / scales.gap).astype(cells.dtype) * cells, 0.0
    # the active set, in which a gap is an error, is empty where all pressures are at a limit; the mean of the correction
    # is left out, as it changes the load. The gap of the set is extended to all cells; the inverse makes pressure of it
    if count := np.count_nonzero(cells):
        extension = inverse.extension(cells)
        correction = extension.pressure(extension(correction))
        level = inner(correction, cells) / count

    def errors_in_block(pressure: Array, gap: Array, cells: Array, correction: Array) -> tuple[float, ...]:
        """Return the sum of pressure errors [Pa], the largest pressure with its error [Pa], and the largest gap [m]."""
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
    # the residual includes the error of a given load, which is the net load with adhesion, not that of the pressure
    by_load = min(solution.problem.control.error(load), solution.residual)
    l1 = float(sum(sums) / load + by_load)
    # what a gap in metres has lost beside far larger heights, if the residual allows for it
    largest_gap = float(np.abs(solution.problem.undeformed_gap).max())
    lost = min(np.finfo(float).eps * largest_gap / scales.gap, solution.residual)
    l1 += INVERSE_MARGIN * float(lost / compliance * scales.pressure * count / load)
    if solution.problem.control.approach is not None:
        # the inverse leaves a uniform gap out, which changes the load: at least by the multiple of this pressure whose
        # work on its displacement is that on the gap; a flat punch's pressure, of the least energy, needs more
        displacement = inner(pressure, solution.problem.operator(pressure))
        l1 += INVERSE_MARGIN * abs(inner(pressure, gap)) / displacement
    # the peak may be in another cell; the inverse, which takes both axes for periodic, is more accurate for the sum
    # than for a single cell
    peak = max(float(max(peaks) / pressure.max()) - 1, l1) + change
    return ResidualErrors(peak, l1 + change, _area_error(pressure, l1 + change), max(gaps))


def _area_error(pressure: Array, l1: float) -> float:
    """Return the relative error of the contact area, of which the cells of smallest `pressure` may be no part.

    They are those that together carry the fraction `l1` of the load.
    """
    allowed = l1 * float(pressure.sum())
    smallest = np.cumsum(np.sort(pressure[(pressure > 0) & (pressure <= allowed)]))
    count = np.searchsorted(smallest, allowed, side="right")
    return relative_loss(count / np.count_nonzero(pressure))


# Factor on the errors due to a finite range: for cylinders of a Tabor parameter of 0.4 to 6.4 the difference from the
# JKR limit was at most 1.09 times what :func:`range_errors` has without this factor, most at the largest parameter, so
# that a margin is left for larger ones.
RANGE_MARGIN = 1.25
# Error of the peak net pressure over that of the area times the sum of peak and mean net pressure: at most 0.06 for 15
# cylinders, from near pull-off to loads of many times it, on 152 to 2432 cells. Of other shapes no limit is known, and
# four times that is taken.
PEAK_BY_RANGE = 0.25
# Of contacts that change in time, used where these are evolved and answered.
NO_BOUND_OF_STATES = "No bound: this error is not estimated in a contact that has crept, worn or yielded."
NO_LIMIT = (
    "No bound: in the JKR limit the repulsive part of the pressure and the attraction grow without limit, give "
    "Adhesion.range."
)
NO_LONGER_RANGE = (
    "No bound for the pull-off load: on cells of twice the size, with the longer range that they hold, none was found, "
    "give more cells."
)
PRESSED_FLAT = (
    "No bound for the pull-off load: the surface is pressed flat, and without an edge of the contact the load at which "
    "it opens grows without limit as the range of the attraction shrinks, give Adhesion.range."
)
# Largest gap over the range of the attraction, up to which a surface counts as pressed flat: waves that are flat on
# fine grids have at most 1.2 on coarse ones, others 2.4 and more.
FLAT_GAP = 2.0
# Error of the load at a given approach, over the L1 norm of the net traction and the error of the area by the range: at
# most 0.015 for cylinders on 96 to 384 cells, before and after contact is made by the load.
LOAD_BY_RANGE = 0.03
ZERO_PULL_OFF = "No bound for the pull-off load: it is zero, and its error is relative to it."
# Power of the work of adhesion to which the pull-off load of a cylinder is proportional (Barquins 1988, J. Adhesion 26,
# 1, in the JKR limit).
POWER_OF_WORK = 2 / 3


class RangeErrors(NamedTuple):
    """Relative errors of net pressure in L1 and contact area due to a range that was chosen for the grid."""

    l1: float
    area: float


def range_errors(solution: Solution) -> RangeErrors | None:
    """Return the relative errors of net pressure and contact area due to a range that was chosen for the grid.

    It is None for a range that is given, and without a scene. In the JKR limit the traction has an inverse square-root
    singularity at the edge of the contact, which a range r replaces by a cohesive zone. That moves a force E* r per
    length of edge, where E* is the contact modulus, and the edge by at most the length of the zone (Maugis 1992). As r
    goes to zero, pressure and attraction grow without limit at the edge, and only their difference, the net pressure,
    converges. The L1 error is that of the net pressure.
    """
    adhesion, problem = solution.adhesion, solution.problem
    scene = scene_of(problem)
    if adhesion is None or not adhesion.regularised or scene is None:
        return None
    assert scene.adhesion is not None
    touching, grid = solution.pressure > 0, problem.grid
    modulus = contact_modulus(scene.solids, adhesion.cells_in_zone * grid.cell_size[0])
    work = scene.adhesion.work
    zone = zone_length(modulus, work, work / adhesion.range)
    perimeter = contact_perimeter(touching, grid, problem.paddings)
    net_force = grid.cell_area * float(np.abs(solution.pressure - adhesion.attraction).sum())
    area_error = RANGE_MARGIN * perimeter * zone / (grid.cell_area * int(touching.sum()))
    return RangeErrors(RANGE_MARGIN * perimeter * modulus * adhesion.range / net_force, area_error)


def peak_range_error(solution: Solution, area_error: float) -> float:
    """Return the relative error of the peak net pressure due to a range that was chosen for the grid.

    `area_error` is the relative error of the contact area due to it.
    """
    mean = float(np.abs(solution.net_pressure).sum() / np.count_nonzero(solution.pressure))
    peak = abs(solution.peak_pressure)
    return PEAK_BY_RANGE * area_error * (peak + mean) / peak if peak else inf


def load_range_error(solution: Solution) -> float | None:
    """Return the relative error of the load at a given approach due to a range that was chosen for the grid.

    In the JKR limit the bodies do not attract each other across a gap, so that without contact the error is 1, all of
    the load. It is None for a range that is given, and infinite without a scene or a load.
    """
    adhesion = solution.adhesion
    if adhesion is None or not adhesion.regularised:
        return None
    if not solution.pressure.any():
        return 1.0
    if (errors := range_errors(solution)) is None:
        return inf
    load = abs(float(solution.net_pressure.sum()))
    norm = float(np.abs(solution.net_pressure).sum())
    return LOAD_BY_RANGE * errors.area * norm / load if load else inf


def range_warning(solution: Solution) -> tuple[str, ...]:
    """Return one sentence on the range of the attraction if it was chosen for the grid, else none."""
    adhesion = solution.adhesion
    if adhesion is None or not adhesion.regularised:
        return ()
    return (f"The range of the attraction, {readable(adhesion.range)}, is the shortest that this grid can hold.",)


def pull_off_error(solution: Solution, load: ErrorParts) -> ErrorParts:
    """Return the relative error of the pull-off load of `solution`, by the error of its `load` as of any solve.

    Images left out count as in that of the load. The cells add what they trap, and the residual is the distance between
    the last load in equilibrium and the first one without.
    """
    adhesion, pull_off = solution.adhesion, solution.load_per_length
    assert adhesion is not None
    assert adhesion.first_unstable_load is not None
    search: Any = solution.problem.adhesion
    trapped = POWER_OF_WORK * TRAPPED_WORK[type(search.solver.law)] / adhesion.cells_in_zone
    is_flat = adhesion.regularised and _is_pressed_flat(solution)
    by_range = inf if is_flat else _pull_off_range_error(solution, adhesion, pull_off)
    reason = PRESSED_FLAT if is_flat else load.reason or (NO_LONGER_RANGE if by_range == inf else "")
    return replace(
        load,
        discretisation=(load.discretisation or 0.0) + trapped,
        residual=abs(pull_off - adhesion.first_unstable_load) / abs(pull_off) if pull_off else inf,
        range=by_range,
        reason=reason if pull_off else ZERO_PULL_OFF,
    )


def root_of_pull_off(pull_off: ErrorParts | None) -> float:
    """Return the root of the relative error of the `pull_off` load, apart from its range; 0 where None is given.

    The load is stationary at pull-off, so that it changes by the square of what pressure and approach change by.
    """
    if pull_off is None:
        return 0.0
    return sqrt(sum(part or 0.0 for part in (pull_off.images, pull_off.discretisation, pull_off.residual)))


def _is_pressed_flat(solution: Solution) -> bool:
    """Return whether no part of a surface that is periodic both ways is free of attraction, under the preload."""
    problem = solution.problem
    posed = problem.description
    assert problem.paddings is not None
    if not isinstance(posed, PosedScene) or not all(padding.wraps for padding in problem.paddings):
        return False
    load: Any = posed.scene.load
    scene = posed.scene.under(load.preload)
    pressed = solve_contact(scene.problem(problem.grid, posed.padding), SolveOptions(ADHESIVE_TOLERANCE))
    assert solution.adhesion is not None
    least = min(float(pressed.gap.max()), float(solution.gap.max()))
    return least < FLAT_GAP * solution.adhesion.range


def _pull_off_range_error(solution: Solution, adhesion: AdhesiveTraction, pull_off: float) -> float | None:
    """Return the relative error of a `pull_off` load [N/m] due to a range chosen for the grid instead of the JKR limit.

    It is the change from cells of twice the size, whose range is longer. It is infinite where no pull-off load is found
    on these, and None for a range that is given.
    """
    problem = solution.problem
    posed = problem.description
    if not adhesion.regularised or not isinstance(posed, PosedScene):
        return None
    longer = solve_contact(
        posed.scene.problem(coarsened(problem.grid, 2), posed.padding), SolveOptions(ADHESIVE_TOLERANCE)
    )
    found = longer.status.has_converged and pull_off
    return abs(longer.load_per_length - pull_off) / abs(pull_off) if found else inf

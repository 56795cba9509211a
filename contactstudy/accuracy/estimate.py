"""Estimated errors of a solution, by cause: images left out, cells, the solver's residual, a range of attraction."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from contactstudy.accuracy.discretisation.cells import (
    around_contact,
    contact_area_error,
    discretisation_errors,
    relative_loss,
)
from contactstudy.accuracy.discretisation.coarser import (
    DiscretisationErrors,
    change_between_grids,
    coarse_solution,
    comparable,
    compare_grids,
)
from contactstudy.accuracy.discretisation.subcell import CONFIDENCE, SubgridEffect, SubgridHeights
from contactstudy.accuracy.image_errors import (
    L1_OVER_NARROWING,
    coupling_image_error,
    image_errors,
)
from contactstudy.accuracy.plausibility import beyond_strength, implausible
from contactstudy.accuracy.range_errors import (
    PEAK_WITHOUT_LIMIT,
    pull_off_error,
    range_errors,
    range_warning,
)
from contactstudy.accuracy.residual_errors import residual_errors
from contactstudy.domain.checks import InvalidInput, NotDefined
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import axis_first
from contactstudy.domain.reuse import ArrayCache, caching, current_cache
from contactstudy.domain.units import readable
from contactstudy.problem.problem import Problem
from contactstudy.scene.scene import PosedScene
from contactstudy.scene.solids.bodies import is_layered
from contactstudy.solvers.solution import Solution

SHARP_EDGE = "a sharp edge or corner"
NO_DATUM = (
    "No bound at a given approach: it counts from a place that depends on the images that the padding leaves out, give "
    "ExactPeriodicity."
)
NO_SLIP_OF_IMAGES = (
    "No bound where dissimilar bodies roll: their slip, and with it the traction, lacks that of the images that the "
    "padding leaves out, give ExactPeriodicity."
)
UNKNOWN_HEIGHTS = (
    "No bound for the discretisation error: Problem.source does not say the heights on other grids, so nothing is "
    "known of them between the cell centres; make the problem from a Scene."
)
PROTRUDING = (
    "No bound for the discretisation error: between the cell centres the surface protrudes further than "
    "the contact flattens it; give more cells, or the shape's `length_scales`."
)


@dataclass(frozen=True)
class EstimateConstants:
    """Constants of the error estimate.

    Attributes
    ----------
    smooth_ratio
        Ratio of the hidden fraction of the load to the error of smooth edges below which no coarser solution is needed.
    hidden_error
        Largest error in L1 over the hidden fraction of the load, and of the area over the fraction that may open.
    max_l1
        Largest L1 difference of two pressures of one load.
    load_error
        Error of the load at a given approach over the L1 error due to the edges or the hidden fraction of the load: at
        most 0.27 of the former on 288 smooth line contacts of 10 to 255 cells across the width, whose datum was half
        the width of the grid or more.
    negligible_attraction
        Fraction of the largest force up to which heights under an attraction do not count.
    sharp_rise
        Fraction of the peak pressure that a corner adds at each halving of the cells, from which it counts as sharp.
    gap_error
        Error of the mean gap over the L1 error, relative to the gap or to the rms variation of the displacement,
        whichever is larger.
    min_cells_across
        Least cells across the contact at the peak for its edges to follow their law.
    end_over_peak
        Pressure at a roller's end over the peak pressure, from which that end may have the peak.
    stiff_coating
        Stiffness of a coating over that of its substrate, above which the pressure rises at the edges over part of the
        thickness t.
    cells_in_coating
        Cells in the thickness of such a coating with which the grid resolves the rise.
    edge_rise
        Largest rise there over the pressure of a plate bent over the radius R, ``E t / R``, over the cube root of the
        ratio of stiffness.
    """

    smooth_ratio: float = 0.25
    hidden_error: float = 0.8
    max_l1: float = 2.0
    load_error: float = 0.3
    negligible_attraction: float = 1e-3
    sharp_rise: float = 1e-3
    gap_error: float = 0.12
    min_cells_across: int = 5
    end_over_peak: float = 0.5
    stiff_coating: float = 2.0
    cells_in_coating: int = 2
    edge_rise: float = 2 / 3


CONSTANTS = EstimateConstants()


def error_estimate(
    solution: Solution,
    *,
    coarse: Solution | None = None,
    heights: SubgridHeights | None = None,
    confidence: float = CONFIDENCE,
) -> ErrorEstimate:
    """Return the estimated errors of `solution`, by quantity and by cause.

    The causes are images that the padding leaves out (:mod:`~contactstudy.accuracy.image_errors`), the solver's residual
    (:mod:`~contactstudy.accuracy.residual_errors`), and the cells (:mod:`~contactstudy.accuracy.discretisation`), to
    which the edges of a stiff coating add. Adhesion in the JKR limit adds its range
    (:mod:`~contactstudy.accuracy.range_errors`).

    Under a given load, where heights and edges are smooth, the solution alone determines them. Otherwise, with adhesion
    and at a given approach, the same contact is solved once more on cells of twice the size, with its heights sampled
    again. Heights inside the cells are examined in all cases. The estimate takes up to twice the time of the solve on
    100 x 100 cells, and half of it on several hundred along each axis. An error is infinite, with the reason in
    ``warnings``, where no bound can be given: no solution, a contact cut off, the pressure at a sharp edge, heights
    finer than the cells, a given approach with images left out.

    Parameters
    ----------
    solution
        The solution.
    coarse
        The same contact on cells of twice the size, if at hand, see
        :func:`~contactstudy.accuracy.discretisation.coarser.coarse_solution`.
    heights
        The heights inside the cells, if at hand, such as those of an earlier instant on the same grid.
    confidence
        Probability, between 0 and 1, with which a feature over 3 % of a cell is found in a shape without
        ``length_scales``. It sets the number of points examined in each cell, unless `heights` are given.

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
        :func:`~contactstudy.accuracy.image_errors.image_errors`.
    """
    problem = solution.problem
    if not 0 < confidence < 1:
        raise InvalidInput(
            f"error_estimate.confidence is {confidence!r}: give a probability between 0 and 1, such as 0.95."
        )
    if problem.paddings is None:
        raise NotDefined(
            "Problem.paddings is None: give the paddings of the two axes, (across, along)."
        )
    if solution.status.is_failure:
        unknown = ErrorParts(residual=inf, reason=f"No bound: {solution.status}")
        return ErrorEstimate(unknown, unknown, unknown, unknown, warnings=(unknown.reason,))
    if not solution.pressure.any():
        unknown = ErrorParts(discretisation=inf, reason="No bound: the bodies do not touch.")
        return ErrorEstimate(unknown, unknown, unknown, unknown, warnings=(unknown.reason,))
    ends_along = problem.source is not None and problem.source.ends_along
    peak_images, l1_images = image_errors(
        solution.pressure, problem.grid, problem.paddings, ends_along=ends_along
    )
    if l1_images and (beta := _dundurs_of_shear(solution)):
        by_shear = coupling_image_error(
            solution.pressure, solution.shear[0], problem.grid, problem.paddings[1], beta
        )
        peak_images, l1_images = peak_images + by_shear, l1_images + by_shear
    change = 0.0
    if solution.adhesion is not None:
        from contactstudy.solvers.adhesion import (
            CONSTANTS as OUTER,
        )  # imported only where it is named

        # the change of the attraction that counts as much as this residual
        change = OUTER.change_in_tolerances * solution.residual
    residual = residual_errors(solution, change)
    # the heights on several grids have the same waves
    with caching(current_cache() or ArrayCache(problem.undeformed_gap.nbytes)):
        cells = _cells(solution, coarse, heights, confidence)
    rise_at_edge, width, reason = _edge_rise(solution)
    if reason:
        rise = max(rise_at_edge / float(solution.pressure.max()) - 1, 0.0)
        # one at either edge, in the mean over the length
        mean = float(solution.pressure.mean()) * problem.grid.extent[0]
        cells = replace(
            cells,
            peak_pressure=max(cells.peak_pressure, rise),
            l1=cells.l1 + 2 * rise_at_edge * width / mean,
            warnings=(*cells.warnings, reason),
        )
    l1 = ErrorParts(l1_images, cells.l1, residual.l1)
    peak = ErrorParts(peak_images, cells.peak_pressure, residual.peak_pressure)
    area = ErrorParts(l1_images, cells.contact_area, residual.contact_area)
    gap = ErrorParts(
        _gap_by_images(solution, l1_images),
        cells.mean_gap,
        change + residual.gap / abs(solution.mean_gap) if solution.mean_gap else inf,
    )
    load = ErrorParts(l1_images, cells.load, residual.l1) if cells.load is not None else None
    if l1_images and (reason := _needs_images(solution)):
        l1, peak, area, gap = (
            replace(parts, images=inf, reason=reason) for parts in (l1, peak, area, gap)
        )
        load = load and replace(load, images=inf, reason=reason)
        cells = replace(cells, warnings=(reason, *cells.warnings))
    if by_range := range_errors(solution):
        l1_by_range, area_by_range = by_range
        l1 = replace(l1, range=l1_by_range)
        peak = replace(peak, range=inf, reason=PEAK_WITHOUT_LIMIT)
        area = replace(area, range=area_by_range)
        gap = replace(gap, range=_gap_error(solution, l1_by_range, 0.0, 0.0))
    return ErrorEstimate(
        l1,
        peak,
        area,
        gap,
        load=load,
        pull_off=_at_pull_off(solution, cells),
        warnings=(
            *filter(None, (beyond_strength(solution),)),
            *cells.warnings,
            *filter(None, (implausible(solution),)),
        ),
    )


def _cells(
    solution: Solution, coarse: Solution | None, heights: SubgridHeights | None, confidence: float
) -> DiscretisationErrors:
    """Return the errors due to the cells."""
    problem = solution.problem
    pressure = solution.pressure[around_contact(solution.pressure)]
    assert problem.paddings is not None
    wraps = problem.paddings[0].wraps, problem.paddings[1].wraps
    load_is_result = problem.control.approach is not None or _is_pull_off(solution)
    no_load = inf if load_is_result else None
    if reason := _cut_off(solution) or _unresolved_length(problem):
        return DiscretisationErrors.unbounded(reason, no_load)
    heights = heights or SubgridHeights.from_problem(problem, confidence)
    if heights is None:
        return DiscretisationErrors.unbounded(UNKNOWN_HEIGHTS, no_load)
    force = _force(solution)
    inside = heights.effect_under(problem, force)
    if inside.protrudes:
        return DiscretisationErrors.unbounded(PROTRUDING, no_load)
    # the edges of a contact with adhesion follow another law
    adheres = solution.adhesion is not None
    peak, l1 = (0.0, 0.0) if adheres else discretisation_errors(pressure, wraps)
    area = 0.0 if adheres else contact_area_error(pressure, wraps)
    load = CONSTANTS.load_error * max(l1, inside.hidden_load)
    at_hardness = _at_hardness(solution)
    ends = problem.source is not None and problem.source.ends_along
    regular = (
        not (at_hardness or (ends and pressure[:, [0, -1]].any()))
        and _contact_width(pressure, wraps) >= CONSTANTS.min_cells_across
    )
    load_is_fixed = not adheres and problem.control.approach is None
    if not load_is_fixed:
        changes = compare_grids(solution, coarse)
    elif (
        regular
        and inside.hidden_load <= CONSTANTS.smooth_ratio * l1
        and inside.corner_rise <= CONSTANTS.sharp_rise
    ):
        changes = DiscretisationErrors(0.0, 0.0, 0.0, 0.0)
    else:
        coarse = comparable(coarse or coarse_solution(problem, solution.pressure))
        if coarse is None:
            reason = "No bound for the discretisation error: no solution on cells of twice the size to compare with."
            return DiscretisationErrors.unbounded(reason)
        changes = change_between_grids(solution, coarse)
    if changes.l1 == inf:
        return replace(changes, load=no_load)
    isolated = _has_isolated_cells(pressure)
    hidden_error = CONSTANTS.hidden_error * inside.hidden_load * float(force.sum())
    hidden_area = relative_loss(CONSTANTS.hidden_error * inside.area_loss)
    largest_l1 = CONSTANTS.max_l1 if load_is_fixed else inf
    l1 = max(l1, changes.l1, hidden_error / float(pressure.sum()))
    l1 = largest_l1 if isolated else min(largest_l1, l1)
    reason = ""
    if at_hardness:  # the peak pressure is the hardness
        peak = changes.peak_pressure
    elif reason := _no_peak(inside, isolated=isolated, sharp_end=_at_sharp_end(problem, pressure)):
        peak = inf
    else:
        peak = max(peak, changes.peak_pressure, inside.peak_rise) + inside.kink_rise
    gap = _gap_error(solution, l1, changes.mean_gap, inside.mean_height)
    if load_is_result:
        assert changes.load is not None
        load = max(load, changes.load) if l1 < inf else inf
        if adheres:
            net = abs(solution.load_per_length) * problem.grid.length / problem.grid.cell_area
            load = max(load, hidden_error / net) if net else inf
        if problem.control.approach is not None and gap < inf:
            # the load moves the mean surface, which on two periodic axes is at rest
            moved = load * abs(float(solution.displacement.mean()))
            gap = max(gap, moved / solution.mean_gap)
            load += inside.mean_height / solution.mean_gap
            if not adheres:  # the level of the pressure beside its shape, which its edges show
                l1, peak = l1 + load, peak + load
    errors = _with_reasons(
        DiscretisationErrors(
            l1,
            peak,
            max(area, changes.contact_area, hidden_area),
            gap,
            load if load_is_result else None,
            warnings=(reason,) if reason else (),
        )
    )
    return replace(errors, warnings=errors.warnings or range_warning(solution))


def _force(solution: Solution) -> Array:
    """Return pressure and attraction (x, y) [Pa] together, without the tail of the attraction far from contact."""
    if solution.adhesion is None:
        return solution.pressure
    force = solution.pressure + solution.adhesion.attraction
    return np.where(force > CONSTANTS.negligible_attraction * force.max(), force, 0.0)


def _edge_rise(solution: Solution) -> tuple[float, float, str]:
    """Return the pressure [Pa] at the edges of a contact on a coating of few cells, its width [m], and a sentence.

    Both are 0, and the sentence is empty, where no coating is much stiffer than its substrate or the cells resolve the
    rise.
    """
    pressure, width, reason, problem = 0.0, 0.0, "", solution.problem
    if not isinstance(problem.description, PosedScene):
        return pressure, width, reason
    scene = problem.description.scene
    for coating in filter(is_layered, scene.solids):
        stiffer = coating.substrate.compliance / coating.compliance
        cells = coating.thickness / problem.grid.cell_size[0]
        if stiffer > CONSTANTS.stiff_coating and cells < CONSTANTS.cells_in_coating:
            curvature = 1 / scene.hertz.radius if scene.hertz is not None else _curvature(solution)
            bending = coating.thickness * curvature / coating.compliance
            pressure = max(pressure, CONSTANTS.edge_rise * bending / stiffer ** (1 / 3))
            width = max(width, coating.thickness)
            reason = (
                f"The grid has {cells:.2g} cells in a coating {stiffer:.3g} times as stiff as its substrate, which do "
                "not resolve how the pressure rises at the edges: the peak there is at most about "
                f"{readable(pressure, 'Pa', 3)}."
            )
    return pressure, width, reason


def _curvature(solution: Solution) -> float:
    """Return the largest curvature of the undeformed gap across [1/m] in cells that touch and beside them."""
    grid, touching = solution.problem.grid, solution.pressure > 0
    bends = np.abs(np.diff(solution.problem.undeformed_gap, n=2, axis=0)) / grid.cell_size[0] ** 2
    beside = touching[:-2] | touching[1:-1] | touching[2:]
    return float(bends[beside].max(initial=0.0))


def _gap_error(solution: Solution, l1: float, change: float, hidden: float) -> float:
    """Return the relative error of the mean gap; infinite where the gap is of the size of the iteration's residual.

    Parameters
    ----------
    solution
        The solution.
    l1
        Discretisation error of the pressure in L1.
    change
        Relative change of the gap from cells of twice the size.
    hidden
        Mean of the heights inside the cells below that at their centres [m].
    """
    gap, active = solution.mean_gap, solution.problem.constraint.active(solution.pressure)
    residual = float((np.abs(solution.gap) * active).mean())
    if not gap > 2 * residual:
        return inf
    shift = CONSTANTS.gap_error * l1 * max(float(solution.displacement.std()), gap)
    return max(change, shift / gap) + hidden / gap


def _dundurs_of_shear(solution: Solution) -> float:
    """Return Dundurs' beta of the bodies of a solution with a tangential traction; 0 without one."""
    posed = solution.problem.description
    if solution.traction is None or not isinstance(posed, PosedScene):
        return 0.0
    from contactstudy.scene.friction.friction_law import dundurs  # imported only where it is named

    return dundurs(posed.scene.solids)


def _needs_images(solution: Solution) -> str:
    """Return why a contact has no bound where its padding leaves out images; an empty string where it has one."""
    if solution.problem.control.approach is not None:
        return NO_DATUM
    rolls = solution.traction is not None and hasattr(solution.traction, "creepage")
    return NO_SLIP_OF_IMAGES if rolls and _dundurs_of_shear(solution) else ""


def _gap_by_images(solution: Solution, l1: float) -> float:
    """Return the relative error of the mean gap where images left out change the pressure by `l1`.

    The contact is narrower by the fraction n that :func:`image_errors` finds, under the same load. The gap of a line
    contact is then larger by n times ``x dg/dx``, whose mean is n times the gap at the edges of the grid less its mean.
    """
    if not l1:
        return 0.0
    gap, mean = solution.gap, solution.mean_gap
    edges = max(float(line.mean()) for line in (gap[0], gap[-1], gap[:, 0], gap[:, -1]))
    return l1 / L1_OVER_NARROWING * max(edges / mean, 1.0) if mean > 0 else inf


def _is_pull_off(solution: Solution) -> bool:
    """Return whether the solution is the last stable state before pull-off."""
    return solution.adhesion is not None and solution.adhesion.first_unstable_load is not None


def _at_pull_off(solution: Solution, cells: DiscretisationErrors) -> ErrorParts | None:
    """Return the error of the pull-off load; None where it was not sought."""
    if cells.load is None or not _is_pull_off(solution):
        return None
    reason = cells.warnings[0] if cells.load == inf else ""
    return pull_off_error(solution, cells.load, reason)


def _cut_off(solution: Solution) -> str:
    """Return a sentence if contact or attraction is cut off at the edge of the grid, else an empty string."""
    problem, what = solution.problem, ""
    if problem.is_cut_off(solution.pressure):
        what = "contact"
    elif solution.adhesion is not None:
        from contactstudy.solvers.adhesion import is_cut_off  # imported only where it is named

        what = "attraction" if is_cut_off(problem, solution.adhesion.attraction) else ""
    if not what:
        return ""
    return f"No bound: the {what} is cut off at the edge of the grid, give Grid.extent a larger width or length."


def _unresolved_length(problem: Problem) -> str:
    """Return why the cells are too large for a length scale of a shape; an empty string where they are not."""
    shortest = problem.source.shortest_wavelengths if problem.source is not None else (inf, inf)
    for axis, (cell, length) in enumerate(zip(problem.grid.cell_size, shortest, strict=True)):
        if cell > length * (1 + 1e-9) and problem.grid.cells[axis] > 1:
            count = int(np.ceil(2 * problem.grid.extent[axis] / length))
            return (
                f"No bound for the discretisation error: Grid.cells[{axis}] is {problem.grid.cells[axis]}, "
                f"whose cells of {readable(cell)} do not resolve lengths of {readable(length)}, give {count} or more."
            )
    return ""


def _no_peak(inside: SubgridEffect, *, isolated: bool, sharp_end: bool) -> str:
    """Return why the peak pressure has no bound; an empty string where it has one.

    Parameters
    ----------
    inside
        Heights inside the cells.
    isolated
        Whether no two touching cells are neighbours.
    sharp_end
        Whether the roller has pressure up to its end.
    """
    reason = ""
    if inside.corner_rise > CONSTANTS.sharp_rise:
        reason = (
            f"it lies at {SHARP_EDGE}, where it is infinite: round the edge, close the seam of a measured surface, or "
            "ask for another quantity"
        )
    elif sharp_end:
        reason = "the roller carries pressure up to its sharp end, where it is infinite: give a profile that drops more"
    elif isolated:
        reason = "no two cells in contact are neighbours: give more cells"
    return f"No bound for the peak pressure: {reason}." if reason else ""


def _with_reasons(cells: DiscretisationErrors) -> DiscretisationErrors:
    """Return `cells`, with the reasons if the contact area or the mean gap has no bound."""
    reasons = list(cells.warnings)
    if cells.contact_area == inf:
        reasons.append(
            "No bound for the contact area: the contact is one or two cells wide, or may open in every cell, give more "
            "cells."
        )
    if cells.mean_gap == inf:
        reasons.append(
            "No bound for the mean gap: the bodies touch everywhere, and what is left of it is the solver's residual."
        )
    return replace(cells, warnings=tuple(reasons))


def _at_hardness(solution: Solution) -> bool:
    """Return whether the peak pressure is a limit of the constraint, which finer cells have too."""
    ix, iy = np.unravel_index(np.argmax(solution.pressure), solution.pressure.shape)
    active = solution.problem.constraint.active(solution.pressure[ix : ix + 1])
    return bool(active[0, iy] == 0)


def _at_sharp_end(problem: Problem, pressure: np.ndarray) -> bool:
    """Return whether an end of the roller has pressure of the order of the peak pressure.

    There it is infinite in the limit of small cells, though coarse cells may not show a rise.
    """
    if problem.source is None or not problem.source.ends_along:
        return False
    return bool(pressure[:, [0, -1]].max() > CONSTANTS.end_over_peak * pressure.max())


def _has_isolated_cells(pressure: np.ndarray) -> bool:
    """Return whether along an axis no two cells in contact are neighbours, so that their edges are unknown."""
    touching = pressure > 0
    return any(
        len(along) > 1 and not (along[1:] & along[:-1]).any() for along in (touching, touching.T)
    )


def _contact_width(pressure: np.ndarray, wraps: tuple[bool, bool]) -> int:
    """Return the number of adjacent cells in contact through the peak pressure, along the axis with the fewest."""
    peak = np.unravel_index(np.argmax(pressure), pressure.shape)
    fewest = pressure.size
    for axis, is_periodic in enumerate(wraps):
        line = axis_first(pressure, axis)[:, peak[1 - axis]] > 0
        if len(line) > 1 and not line.all():
            line = np.roll(line, len(line) // 2 - int(peak[axis])) if is_periodic else line
            middle = len(line) // 2 if is_periodic else int(peak[axis])
            gaps = np.flatnonzero(~line)
            before, after = gaps[gaps < middle], gaps[gaps > middle]
            first = before[-1] if before.size else -1
            last = after[0] if after.size else len(line)
            fewest = min(fewest, int(last - first - 1))
    return fewest

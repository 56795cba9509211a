"""Estimated errors of a solution, by cause: images left out, cells, the solver's residual, a range of attraction."""

from dataclasses import replace
from math import inf

import numpy as np

from contactstudy.accuracy.discretisation.bound import (
    discretisation_bound,
    gap_error,
    is_pull_off,
    over_net,
)
from contactstudy.accuracy.discretisation.coarser import (
    DiscretisationErrors,
    coarse_solution,
    comparable,
)
from contactstudy.accuracy.discretisation.hidden_heights import HiddenHeights
from contactstudy.accuracy.image_errors import (
    IMAGES_REMEDY,
    L1_OVER_NARROWING,
    coupling_image_error,
    image_errors,
)
from contactstudy.accuracy.plausibility import beyond_strength, implausible
from contactstudy.accuracy.range_errors import (
    load_range_error,
    peak_range_error,
    pull_off_error,
    range_errors,
    range_warning,
    root_of_pull_off,
)
from contactstudy.accuracy.residual_errors import residual_errors
from contactstudy.domain.checks import NotDefined
from contactstudy.domain.errors import MARGIN, ErrorEstimate, ErrorParts
from contactstudy.domain.reuse import cache_of, caching
from contactstudy.scene.scene import scene_of
from contactstudy.scene.shapes_source import left_out, standing_heights
from contactstudy.scene.solids.bodies import creeps
from contactstudy.solvers.friction.rolling_traction import RollingTraction
from contactstudy.solvers.solution import Solution

NO_DATUM = (
    "No bound at a given approach: it counts from a place that depends on the images that the padding leaves out, "
    f"{IMAGES_REMEDY}."
)
# Relative change of an attraction that its last outer iteration may leave at least, and the largest one from cells of
# twice the size with which either grid resolves it.
LEAST_CHANGE, RESOLVED_CHANGE = 1e-7, 0.5
NO_ATTRACTION = (
    "No bound for the attraction: it is cut off at the edge of the grid, or not resolved by its cells, give a wider "
    "grid or more cells."
)
NO_SLIP_OF_IMAGES = (
    "No bound: the slip of a rolling contact, and with it the traction, lacks that of the images that the padding "
    f"leaves out, {IMAGES_REMEDY}."
)
NO_RETARDED_IMAGES = (
    "No bound where a body creeps as it rolls: images that the padding leaves out are retarded and tilt the contact, "
    f"{IMAGES_REMEDY}."
)


# Error of the peak pressure over Dundurs' beta times the largest difference of the shear traction between neighbours at
# the stick-slip boundary, where the peak lies there: at most 0.42 in 32 contacts on 41 to 324 cells. As many cells away
# the error is half of that.
PEAK_BY_SHEAR, HALVED_AWAY = 0.6, 4.0


def error_estimate(
    solution: Solution,
    *,
    coarse: Solution | None = None,
    heights: HiddenHeights | None = None,
) -> ErrorEstimate:
    """Return the estimated errors of `solution`, by quantity and by cause.

    The causes are images that the padding leaves out (:mod:`~contactstudy.accuracy.image_errors`), the solver's residual
    (:mod:`~contactstudy.accuracy.residual_errors`), and the cells
    (:mod:`~contactstudy.accuracy.discretisation.bound`). Adhesion in the JKR limit adds its range
    (:mod:`~contactstudy.accuracy.range_errors`).

    Under a given load, where heights and edges are smooth, the solution alone determines them. Otherwise, with adhesion
    and at a given approach, the same contact is solved once more on cells of twice the size, with its heights sampled
    again. Heights inside the cells are examined in all cases. The estimate takes up to twice the time of the solve on
    100 x 100 cells, and half of it on several hundred along each axis. An error is infinite, with the reason in
    ``warnings``, where no bound can be given: no solution, a contact cut off, the pressure at a sharp edge, heights
    finer than the cells, and where images are left out a given approach, a body that creeps as it rolls, or dissimilar
    bodies in tractive rolling; the slip of tractive rolling has none there either, see ``slip_reason``.

    Parameters
    ----------
    solution
        The solution.
    coarse
        The same contact on cells of twice the size, if at hand, see
        :func:`~contactstudy.accuracy.discretisation.coarser.coarse_solution`.
    heights
        The heights inside the cells, if at hand, such as those of an earlier instant on the same grid.

    Returns
    -------
    ErrorEstimate
        Relative errors by cause.

    Raises
    ------
    NotDefined
        If the problem does not say its paddings, or no law is known for them, see
        :func:`~contactstudy.accuracy.image_errors.image_errors`.
    """
    problem, scene = solution.problem, scene_of(solution.problem)
    if problem.paddings is None:
        raise NotDefined("Problem.paddings is None: give the paddings of the two axes, (across, along).")
    unknown = None
    if solution.status.is_failure:
        unknown = ErrorParts(residual=inf, reason=f"No bound: {solution.status}")
    elif not solution.pressure.any():
        unknown = ErrorParts(discretisation=inf, reason="No bound: the bodies do not touch.")
    if unknown is not None:
        load = None if solution.adhesion is None else _attraction_error(solution, coarse)
        warnings = (unknown.reason,)
        return ErrorEstimate(unknown, unknown, unknown, unknown, load=load, warnings=warnings)
    ends_along = problem.source is not None and problem.source.ends_along
    peak_images, l1_images = image_errors(solution.pressure, problem.grid, problem.paddings, ends_along=ends_along)
    if l1_images and (beta := _dundurs_of_shear(solution)):
        by_shear = coupling_image_error(solution.pressure, solution.shear[0], problem.grid, problem.paddings[1], beta)
        peak_images, l1_images = peak_images + by_shear, l1_images + by_shear
    change = 0.0
    if solution.adhesion is not None:
        # imported only where it is named
        from contactstudy.solvers.adhesion import CONSTANTS as OUTER

        # the change of the attraction that counts as much as this residual
        change = OUTER.change_in_tolerances * solution.residual
    residual = residual_errors(solution, change)
    # the heights on several grids have the same waves
    with caching(cache_of(problem.undeformed_gap.nbytes)):
        cells = discretisation_bound(solution, coarse, heights)
    cells = replace(cells, warnings=cells.warnings or range_warning(solution))
    if at_boundary := _peak_by_shear(solution):
        cells = replace(cells, peak_pressure=cells.peak_pressure + at_boundary)
    of_net, peak_of_net = over_net(solution)
    l1 = ErrorParts(l1_images, cells.l1, residual.l1 * of_net)
    no_peak = cells.warnings[0] if cells.peak_pressure == inf and cells.warnings else ""
    peak = ErrorParts(peak_images, cells.peak_pressure, residual.peak_pressure * peak_of_net, reason=no_peak)
    area = ErrorParts(l1_images, cells.contact_area, residual.contact_area)
    gap = ErrorParts(
        _gap_by_images(solution, l1_images),
        cells.mean_gap,
        change + residual.gap / abs(solution.mean_gap) if solution.mean_gap else inf,
    )
    load = ErrorParts(l1_images, cells.load, residual.l1) if cells.load is not None else None
    slips = isinstance(solution.traction, RollingTraction)
    if l1_images and (reason := _needs_images(solution, slips=slips)):
        l1, peak, area, gap = (replace(parts, images=inf, reason=reason) for parts in (l1, peak, area, gap))
        load = load and replace(load, images=inf, reason=reason)
        cells = replace(cells, warnings=(reason, *cells.warnings))
    if by_range := range_errors(solution):
        l1 = replace(l1, range=by_range.l1)
        peak = replace(peak, range=peak_range_error(solution, by_range.area))
        area = replace(area, range=by_range.area)
        gap = replace(gap, range=gap_error(solution, by_range.l1, 0.0, 0.0))
        load = load and replace(load, range=load_range_error(solution))
    pull_off = _at_pull_off(solution, cells)
    if solution.adhesion is not None and (root := root_of_pull_off(pull_off)):
        highest = root * max(solution.pressure.max(), solution.adhesion.attraction.max())
        by_state = float(highest) / abs(solution.peak_pressure) if solution.peak_pressure else inf
        peak = replace(peak, discretisation=(peak.discretisation or 0.0) + by_state)
    return ErrorEstimate(
        l1,
        peak,
        area,
        gap,
        load=load,
        pull_off=pull_off,
        warnings=(
            *cells.warnings,  # the first is why a bound is infinite
            *filter(None, (beyond_strength(solution), implausible(solution))),
            *filter(None, (standing_heights(scene.shapes) if scene and scene.rolls else "",)),
            *left_out(scene.shapes if scene else (), solution.problem.grid),
        ),
        slip_reason=NO_SLIP_OF_IMAGES if slips and l1_images else "",
    )


def _attraction_error(solution: Solution, coarse: Solution | None) -> ErrorParts | None:
    """Return the error of the load of bodies that only attract each other; None where the load is given.

    It is that of a smooth function at the centres of cells, by its change from cells of twice the size.
    """
    from contactstudy.solvers.adhesion import CONSTANTS as OUTER  # imported only where it is named
    from contactstudy.solvers.adhesion import is_cut_off

    assert solution.adhesion is not None
    if solution.problem.control.approach is None or solution.status.is_failure:
        return None
    attraction, load, changed = solution.adhesion.attraction, solution.load_per_length, inf
    coarse = comparable(coarse or coarse_solution(solution.problem, None, attraction))
    if load and coarse is not None and not is_cut_off(solution.problem, attraction):
        changed = abs(coarse.load_per_length / load - 1)
    if changed > RESOLVED_CHANGE:
        return ErrorParts(discretisation=inf, reason=NO_ATTRACTION)
    left = max(OUTER.change_in_tolerances * solution.residual, LEAST_CHANGE)
    by_range = load_range_error(solution)
    return ErrorParts(discretisation=MARGIN * changed, residual=left, range=by_range)


def _dundurs_of_shear(solution: Solution) -> float:
    """Return Dundurs' beta of the bodies of a solution with a tangential traction; 0 without one."""
    scene = scene_of(solution.problem)
    if solution.traction is None or scene is None:
        return 0.0
    from contactstudy.scene.friction.friction_law import dundurs  # imported only where it is named

    return dundurs(scene.solids)


def _peak_by_shear(solution: Solution) -> float:
    """Return the relative error of the peak pressure by the shear of dissimilar bodies; 0 where it adds none.

    The shear rises steeply where slip begins, and the pressure with it.
    """
    traction, beta = solution.traction, _dundurs_of_shear(solution)
    if traction is None or not beta:
        return 0.0
    stick, largest = np.asarray(traction.stick, bool), 0.0
    peak = np.unravel_index(np.argmax(solution.pressure), stick.shape)
    for axis in (0, 1):
        rise = np.abs(np.diff(traction.shear, axis=axis + 1)).max(axis=0)
        boundary = np.diff(stick, axis=axis)
        for step in (-1, 0, 1):
            places = np.argwhere(np.roll(boundary, step, axis))
            away = np.abs(places - peak).max(axis=1)
            effects = rise[tuple(places.T)] / (1 + away / HALVED_AWAY)
            largest = max(largest, float(effects.max(initial=0.0)))
    return PEAK_BY_SHEAR * abs(beta) * largest / solution.peak_pressure


def _needs_images(solution: Solution, *, slips: bool) -> str:
    """Return why a contact has no bound where its padding leaves out images; an empty string where it has one."""
    if solution.problem.control.approach is not None:
        return NO_DATUM
    if slips and _dundurs_of_shear(solution):
        return NO_SLIP_OF_IMAGES
    scene = scene_of(solution.problem)
    creeping = scene is not None and scene.rolls and any(map(creeps, scene.solids))
    return NO_RETARDED_IMAGES if creeping else ""


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


def _at_pull_off(solution: Solution, cells: DiscretisationErrors) -> ErrorParts | None:
    """Return the error of the pull-off load; None where it was not sought."""
    if cells.load is None or not is_pull_off(solution):
        return None
    reason = cells.warnings[0] if cells.load == inf else ""
    return pull_off_error(solution, cells.load, reason)

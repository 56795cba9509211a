"""Estimated errors of a dry contact by quantity and by cause, and those of stresses below its surface.

`error_estimate` joins what the other modules of this folder know of one cause each, in the order in which the causes
are added: images that the padding leaves out, the cells, the residual of the solver, and with adhesion the range of the
attraction and the state at pull-off. Errors are relative to the number they belong to, and bounds as calibrated, not
proven. The net pressure is the pressure less the attraction; without adhesion it is the pressure. In the JKR limit
(Johnson, Kendall & Roberts 1971) the range of the attraction is zero; a grid then has a range of its own, the shortest
that its cells hold (`Solution.regularised`). Errors of films are estimated with the films.
"""

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from contactstudy.accuracy.bound import (
    acting_force,
    discretisation_bound,
    dundurs_of_shear,
    has_isolated_cells,
    is_pull_off,
    jump_of_shear,
    over_net,
)
from contactstudy.accuracy.coarser import coarse_solution, comparable
from contactstudy.accuracy.error_terms import (
    ENDS_MARGIN,
    IMAGES_REMEDY,
    L1_OVER_NARROWING,
    ResidualErrors,
    image_errors,
    load_range_error,
    peak_range_error,
    pull_off_error,
    range_errors,
    range_warning,
    residual_errors,
    root_of_pull_off,
)
from contactstudy.accuracy.hidden_heights import HiddenHeights
from contactstudy.accuracy.plausibility import beyond_strength, implausible
from contactstudy.domain.device import cache_of, caching
from contactstudy.domain.errors import MARGIN, NO_PEAK, NO_STRESS, ErrorEstimate, ErrorParts
from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.validation import NotDefined
from contactstudy.scene.scene import scene_of
from contactstudy.scene.shapes.shape import left_out, standing_heights
from contactstudy.scene.solids.bodies import creeps
from contactstudy.solvers.solution import RollingTraction, Solution, Status

# Approach over the largest height up to which it counts as rounding: some thousand times that of a double.
ROUNDING = 1e-12
# Error of the approach by a range that was chosen for the grid, over that range times the relative error of the area by
# it: at most 0.07 on 21 cylinders against the JKR limit; three times as much is taken.
APPROACH_BY_RANGE = 0.2
# Error of the mean gap by a range that was chosen for the grid, over that of the net pressure in L1 and the gap or the
# rms variation of the displacement, whichever is larger: at most 0.28 of the L1 error on 820 lines, spheres and waves.
GAP_BY_RANGE = 0.3
# L1 error of the net pressure at pull-off over the root of the relative error of the load: at most 0.39 on 17 grids for
# cylinders with 4 and more cells in the cohesive zone.
L1_AT_PULL_OFF = 0.5
# Error of the largest stress at the surface over the jump of a shear where slip begins: at most 0.8 on 37 to 740 cells,
# after reversals of the force.
STRESS_BY_JUMP = 0.8
# Error of the mean gap by the cells, over that of the pressure in L1 and the gap or the rms variation of the
# displacement, whichever is larger; of the approach, over both. It stands beside their changes between grids,
# which tell little of a gap that is nearly closed: on waves of 16 to 96 cells, under 0.9 to 0.99 of the load that
# closes them, the error was at most 0.1 of this measure, and under less load up to 0.2, which the changes show.
GAP_BY_L1 = 0.1
# Largest cell over the thickness of a coating with which the grid resolves the shear stress at its interface.
CELL_AT_INTERFACE = 0.5
# Relative change of an attraction from cells of twice the size above which two grids show no limit of it: its bound
# would be three quarters of it.
RESOLVED_CHANGE = 0.5
# Numbers whose errors, besides what the estimate says, are shown by their changes between grids; without adhesion the
# contact area too.
BY_GRIDS = "mean_gap", "approach"
NO_GAP = "No bound for the mean gap: the bodies touch everywhere, and what is left of it is the solver's residual."
NO_DATUM = (
    "No bound for the approach, or at a given approach: it counts from a place that depends on the images that the "
    f"padding leaves out, {IMAGES_REMEDY}."
)
ZERO_APPROACH = "No bound for the approach: it is zero, and its error is relative to it."
NO_ATTRACTION = (
    "No bound for the attraction: it is cut off at the edge of the grid, or not resolved by its cells, give a wider "
    "grid or more cells."
)
NO_SLIP_OF_IMAGES = (
    "No bound: the slip of a rolling contact, and with it the traction, lacks that of the images that the padding "
    f"leaves out, {IMAGES_REMEDY}."
)
NO_TILT_OF_IMAGES = (
    "No bound: images of the traction that the padding leaves out tilt the contact of dissimilar bodies, "
    f"{IMAGES_REMEDY}."
)
NO_RETARDED_IMAGES = (
    "No bound where a body creeps as it rolls: images that the padding leaves out are retarded and tilt the contact, "
    f"{IMAGES_REMEDY}."
)


def error_estimate(
    solution: Solution, *, coarse: Solution | None = None, heights: HiddenHeights | None = None
) -> ErrorEstimate:
    """Return the estimated errors of `solution`, by quantity and by cause.

    The causes are images that the padding leaves out (:func:`~contactstudy.accuracy.error_terms.image_errors`), the
    solver's residual (:func:`~contactstudy.accuracy.error_terms.residual_errors`), and the cells
    (:func:`~contactstudy.accuracy.bound.discretisation_bound`). Adhesion in the JKR limit adds its range
    (:func:`~contactstudy.accuracy.error_terms.range_errors`).

    Under a given load, where heights and edges are smooth, the solution alone determines them. Otherwise, with adhesion
    and at a given approach, the same contact is solved once more on cells of twice the size, with its heights sampled
    again. Heights inside the cells are examined in all cases. The estimate takes up to twice the time of the solve on
    100 x 100 cells, and half of it on several hundred along each axis. An error is infinite, with the reason in
    ``warnings``, where no bound can be given: no solution, a contact cut off, the pressure at a sharp edge, heights
    finer than the cells, and where images are left out a given approach, a body that creeps as it rolls, or dissimilar
    bodies under a traction; the slip of tractive rolling has none there either, see ``slip_reason``.

    Parameters
    ----------
    solution
        The solution.
    coarse
        The same contact on cells of twice the size, if at hand, see
        :func:`~contactstudy.accuracy.coarser.coarse_solution`.
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
        :func:`~contactstudy.accuracy.error_terms.image_errors`.
    """
    problem, scene = solution.problem, scene_of(solution.problem)
    if problem.paddings is None:
        raise NotDefined("Problem.paddings is None: give the paddings of the two axes, (across, along).")
    if solution.status.is_failure:
        return _without_pressure(solution, coarse, ErrorParts(residual=inf, reason=f"No bound: {solution.status}"))
    if not solution.pressure.any():
        apart = ErrorParts(discretisation=inf, reason="No bound: the bodies do not touch.")
        return _without_pressure(solution, coarse, apart)
    margin = ENDS_MARGIN if problem.source is not None and problem.source.ends_along else 1.0
    # without the tail of an attraction, which reaches the ends of any grid: there the acting force, the sum of pressure
    # and attraction, is cut to 0 as a small fraction of its maximum, but in tensile cells at an edge it is large
    bending = np.abs(solution.net_pressure) * (acting_force(solution) > 0)
    peak_images, images = image_errors(bending, problem.grid, problem.paddings, margin)
    residual = residual_errors(solution, _attraction_left(solution))
    # the heights on several grids have the same waves
    with caching(cache_of(problem.undeformed_gap.nbytes)):
        cells = discretisation_bound(solution, coarse, heights)
    warnings = cells.warnings or range_warning(solution)
    # residuals are relative to the pressure, errors to the net pressure, and that of the load to the net load
    of_net, peak_of_net = over_net(solution)
    no_bound = warnings[0] if warnings else ""
    no_peak, no_load = (no_bound if error == inf else "" for error in (cells.peak_pressure, cells.load))
    # a range of the attraction that was chosen for the grid
    by_range = range_errors(solution)
    l1_range, area_range = (None, None) if by_range is None else by_range
    peak_range = None if area_range is None else peak_range_error(solution, area_range)
    load = None
    if cells.load is not None:
        net = abs(float(solution.net_pressure.sum()))
        left = residual.l1 * float(solution.pressure.sum()) / net if net else inf
        load = ErrorParts(images, cells.load, left, range=load_range_error(solution), reason=no_load)
    l1 = ErrorParts(images, cells.l1, residual.l1 * of_net, range=l1_range)
    by_solver = residual.peak_pressure * peak_of_net
    estimate = ErrorEstimate(
        l1,
        ErrorParts(peak_images, cells.peak_pressure, by_solver, range=peak_range, reason=no_peak),
        ErrorParts(images, cells.contact_area, residual.contact_area, range=area_range),
        _gap_error(solution, l1, residual),
        load=load,
    )
    slips = isinstance(solution.traction, RollingTraction)
    if images and (reason := _reason_by_images(solution, slips=slips)):
        unbounded: dict[str, Any] = {name: replace(parts, images=inf, reason=reason) for name, parts in estimate}
        estimate = replace(estimate, **unbounded)
        warnings = (reason, *warnings)
    if estimate.load is not None and is_pull_off(solution):
        estimate = _at_pull_off(solution, estimate, pull_off_error(solution, estimate.load))
    of_heights = standing_heights(scene.shapes) if scene and scene.rolls else ""
    further = filter(None, (beyond_strength(solution), implausible(solution), of_heights))
    estimate = replace(
        estimate,
        # the first is why a bound is infinite
        warnings=(*warnings, *further, *left_out(scene.shapes if scene else (), problem.grid)),
        slip_reason=NO_SLIP_OF_IMAGES if slips and images else "",
        by_grids=BY_GRIDS if solution.adhesion else ("contact_area", *BY_GRIDS),
    )
    return replace(estimate, approach=_approach_error(solution, estimate))


def _without_pressure(solution: Solution, coarse: Solution | None, unknown: ErrorParts) -> ErrorEstimate:
    """Return the estimate of a `solution` without a pressure: `unknown` errors, and that of the load by an attraction.

    That load is the result of a given approach. Its error is that of a smooth function at the centres of cells, by its
    change from cells of twice the size, on which `coarse` is the solution if at hand.
    """
    load = None
    if solution.adhesion is not None and solution.problem.control.approach is not None:
        load = None if solution.status.is_failure else _attraction_error(solution, solution.adhesion.attraction, coarse)
    return ErrorEstimate(unknown, unknown, unknown, unknown, load=load, warnings=(unknown.reason,))


def _attraction_error(solution: Solution, attraction: Array, coarse: Solution | None) -> ErrorParts:
    """Return the relative error of the load by the `attraction` (x, y) [Pa] of bodies that do not touch.

    It is the change from the `coarse` solution, which is found if it is None.
    """
    from contactstudy.solvers.adhesion import is_cut_off  # without adhesion it is not loaded

    load, change = solution.load_per_length, inf
    coarse = comparable(coarse or coarse_solution(solution.problem, None, attraction))
    if load and coarse is not None and not is_cut_off(solution.problem, attraction):
        change = abs(coarse.load_per_length / load - 1)
    if change > RESOLVED_CHANGE:
        return ErrorParts(discretisation=inf, reason=NO_ATTRACTION)
    left, by_range = _attraction_left(solution), load_range_error(solution)
    return ErrorParts(discretisation=MARGIN * change, residual=left, range=by_range)


def _attraction_left(solution: Solution) -> float:
    """Return the relative change of an attraction that the iteration may have left; 0 without an attraction."""
    if solution.adhesion is None:
        return 0.0
    from contactstudy.solvers.adhesion import CHANGE_IN_TOLERANCES  # without adhesion it is not loaded

    return CHANGE_IN_TOLERANCES * solution.residual


def _reason_by_images(solution: Solution, *, slips: bool) -> str:
    """Return why a contact has no bound where its padding leaves out images; an empty string where it has one.

    It `slips` as it rolls under a traction.
    """
    if solution.problem.control.approach is not None:
        return NO_DATUM
    if dundurs_of_shear(solution):
        return NO_SLIP_OF_IMAGES if slips else NO_TILT_OF_IMAGES
    scene = scene_of(solution.problem)
    creeping = scene is not None and scene.rolls and any(map(creeps, scene.solids))
    return NO_RETARDED_IMAGES if creeping else ""


def _at_pull_off(solution: Solution, estimate: ErrorEstimate, pull_off: ErrorParts) -> ErrorEstimate:
    """Return an `estimate` at pull-off, where the root of the error of the load, `pull_off`, leaves the state open.

    The peak net pressure is known to that fraction of the larger of repulsion and attraction, which it is the difference
    of.
    """
    assert solution.adhesion is not None
    assert estimate.peak_pressure is not None
    root, peak = root_of_pull_off(pull_off), abs(solution.peak_pressure)
    highest = max(solution.pressure.max(), solution.adhesion.attraction.max())
    of_peak = root * float(highest) / peak if peak else inf if root else 0.0
    return replace(
        estimate,
        l1=_with_cells(estimate.l1, L1_AT_PULL_OFF * root),
        peak_pressure=_with_cells(estimate.peak_pressure, of_peak),
        load=pull_off,
        pull_off=pull_off,
    )


def _with_cells(parts: ErrorParts, added: float) -> ErrorParts:
    """Return the error `parts`, of which that by the cells is larger by what is `added`."""
    return replace(parts, discretisation=(parts.discretisation or 0.0) + added)


def _gap_error(solution: Solution, l1: ErrorParts, residual: ResidualErrors) -> ErrorParts:
    """Return the relative error of the mean gap, by the parts of that of the pressure in `l1`, and by the residual.

    The change of an attraction that the last iteration left adds to the residual. Where most of the mean gap is what the
    solver leaves on closed cells, it has no bound.
    """
    mean, active = solution.mean_gap, solution.problem.constraint.active(solution.pressure)
    is_residual = mean <= 2 * float((np.abs(solution.gap) * active).mean())
    by_l1 = max(float(solution.displacement.std()), mean) / mean if mean > 0 else inf
    return ErrorParts(
        _gap_by_images(solution, l1.images or 0.0),
        GAP_BY_L1 * (l1.discretisation or 0.0) * by_l1,
        inf if is_residual else _attraction_left(solution) + residual.gap / mean,
        range=None if l1.range is None else GAP_BY_RANGE * l1.range * by_l1,
        reason=NO_GAP if is_residual else "",
    )


def _gap_by_images(solution: Solution, l1: float) -> float:
    """Return a bound of the relative error of the mean gap where images left out change the pressure by `l1`.

    The contact is narrower by the fraction n that :func:`~contactstudy.accuracy.error_terms.image_errors` finds, under
    the same load. The gap g of a line contact is then larger by the mean of ``n x dg/dx``: n times the gap at the edges
    of the grid less its mean. The bound is n times the gap at the edges over its mean, at the highest of the four, as
    images may lie along y, and at least n.
    """
    if not l1:
        return 0.0
    gap, mean = solution.gap, solution.mean_gap
    edges = max(float(line.mean()) for line in (gap[0], gap[-1], gap[:, 0], gap[:, -1]))
    return l1 / L1_OVER_NARROWING * max(edges / mean, 1.0) if mean > 0 else inf


def _approach_error(solution: Solution, estimate: ErrorEstimate) -> ErrorParts:
    """Return the relative error of the approach that its change between grids does not show, by those in `estimate`.

    The error of the pressure by the cells adds `GAP_BY_L1` of that in L1; not with adhesion, where the changes show it.
    A range of attraction that was chosen for the grid adds `APPROACH_BY_RANGE`. The state at pull-off leaves open a
    fraction of the approach, or of the range if that is larger: the root of the error of the load. The error is
    infinite, with the reason, where images are left out or the approach is zero.
    """
    size, adhesion = abs(solution.approach), solution.adhesion
    if estimate.l1.images:
        return ErrorParts(images=inf, reason=NO_DATUM)
    if size <= ROUNDING * float(np.abs(solution.problem.undeformed_gap).max()):
        return ErrorParts(discretisation=inf, reason=ZERO_APPROACH)
    if estimate.l1.discretisation == inf:
        return ErrorParts(discretisation=inf, reason=next(iter(estimate.warnings), ""))
    varies = float(solution.displacement.std()) / size
    residual, by_l1 = (estimate.l1.residual or 0.0) * varies, GAP_BY_L1 * (estimate.l1.discretisation or 0.0) * varies
    if adhesion is None:
        return ErrorParts(discretisation=by_l1, residual=residual)
    of_state = root_of_pull_off(estimate.pull_off) * max(size, adhesion.range) / size
    moved = None if estimate.contact_area is None else estimate.contact_area.range
    by_range = None if moved is None else APPROACH_BY_RANGE * adhesion.range * moved / size
    return ErrorParts(discretisation=of_state, residual=residual, range=by_range)


TOO_FEW_CELLS = "No bound for the stress: too few cells in contact are neighbours, give more cells."
NO_STRESS_OF_IMAGES = f"No bound for the stress: that of the images that the padding leaves out lacks, {IMAGES_REMEDY}."
NO_STRESS_LIMIT = (
    "No bound for the stress: in the JKR limit it grows without limit towards the edges of the contact, give "
    "Adhesion.range."
)


def stress_error(solution: Solution, von_mises: Array, depths: Array, estimate: ErrorEstimate) -> ErrorParts:
    """Return the relative error of largest stresses that their changes between grids do not show.

    At the surface it is the error of the peak pressure, at most 100 %, and `STRESS_BY_JUMP` of the jump of a shear
    where slip begins. At the depth z it has fallen by ``(1 + k z) exp(-k z)``, as the stress of a pressure that
    alternates from cell to cell along the axis with the longer cells (Johnson 1985, sect. 13.2), where ``k = pi /
    longest cell``. It is infinite where too few cells in contact are neighbours, where the grid cuts the contact off,
    where images are left out, whose own stress lacks, and where the range of an attraction was chosen for the grid.

    Parameters
    ----------
    solution
        The solution.
    von_mises
        Von Mises stress (z, x, y) [Pa] below it.
    depths
        Depths (z,) [m], growing.
    estimate
        Errors of its pressure.
    """
    if has_isolated_cells(solution):
        return ErrorParts(discretisation=inf, reason=TOO_FEW_CELLS)
    if solution.status is Status.CONTACT_AT_EDGE:
        return ErrorParts(discretisation=inf, reason=next(iter(estimate.warnings), ""))
    if estimate.l1.images:
        return ErrorParts(images=inf, reason=NO_STRESS_OF_IMAGES)
    if solution.regularised:
        return ErrorParts(range=inf, reason=NO_STRESS_LIMIT)
    assert estimate.peak_pressure is not None
    largest, decay = von_mises.max(axis=(1, 2)), np.pi * depths / _longest_cell(solution.problem.grid)
    at_surface = largest * min(estimate.peak_pressure.total, 1.0) + STRESS_BY_JUMP * jump_of_shear(solution)
    at_depths = largest + at_surface * (1 + decay) * np.exp(-decay)
    return ErrorParts(discretisation=float(at_depths.max() / largest.max()) - 1)


def unbounded_by_peak(estimate: ErrorEstimate, depths: Array, grid: Grid) -> ErrorParts | None:
    """Return an infinite error of largest stresses, where of all in `estimate` the peak pressure alone is; else None.

    Where the pressure is infinite, as at a roller's sharp end, the stress below grows without limit towards the
    surface, and coarse cells may show the largest elsewhere. At given `depths` (z,) [m] of a cell and more it is
    finite.
    """
    peak = estimate.peak_pressure
    if peak is None or peak.discretisation != inf or estimate.l1.total == inf:
        return None
    if depths.min() >= _longest_cell(grid):
        return None
    return ErrorParts(discretisation=inf, reason=NO_STRESS + peak.reason.removeprefix(NO_PEAK))


def unresolved_interface(
    grid: Grid, thickness: float, name: str = "shear stress at the interface"
) -> ErrorParts | None:
    """Return an infinite error of a shear stress in a layer with the reason; None on a grid that resolves it.

    The reason calls it by its `name`. The stress lies beside an edge of the contact, over a length of the `thickness`
    [m] of the layer above, so that it has a bound on cells of up to half of that.
    """
    cell, largest = grid.cell_size[0], thickness * CELL_AT_INTERFACE
    if cell <= largest * (1 + 1e-9):
        return None
    reason = (
        f"No bound for the {name}: the grid has {thickness / cell:.2g} cells in the coating, "
        f"give {int(np.ceil(grid.extent[0] / largest))} cells across."
    )
    return ErrorParts(discretisation=inf, reason=reason)


def _longest_cell(grid: Grid) -> float:
    """Return the longer side [m] of a cell, along axes of several cells."""
    return max(size for size, count in zip(grid.cell_size, grid.cells, strict=True) if count > 1)

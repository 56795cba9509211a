"""Bound of the discretisation error of a solution: its edges, heights inside its cells, the change from larger ones.

`discretisation_bound` takes the largest of three: what the pressure shows of itself (edges, ends, peak), what heights
inside the cells may hide, and, where neither determines the error, the change from the same contact on cells of twice
the size. With adhesion the net pressure is the pressure less the attraction. The load is a result, with an error of its
own, at a given approach and at pull-off.
"""

from dataclasses import replace
from math import inf, sqrt

import numpy as np

from contactstudy.accuracy.coarser import (
    DiscretisationErrors,
    StraightEdges,
    around_contact,
    discretisation_errors,
    error_by_change,
    relative_loss,
    straight_edges,
    unseen_area_error,
    wraps_of,
)
from contactstudy.accuracy.hidden_heights import HiddenEffect, HiddenHeights
from contactstudy.domain.errors import NO_PEAK
from contactstudy.domain.grid import Array, axis_first
from contactstudy.problem.problem import Problem
from contactstudy.scene.scene import scene_of
from contactstudy.scene.shapes.shape import unresolved
from contactstudy.solvers.solution import Solution

# Least number of cells across in the thickness of a layer with which the edges of its contact follow the law of those
# of a half-space: on fewer, the places of an edge by two pairs of cells agreed by chance, both off by up to 0.2 cells.
CELLS_IN_LAYER = 3.0
# A peak pressure in one of the two cells at an edge belongs to that edge if the opposite one is this many times as far:
# for the second cell in contacts of eight cells and more, since in narrower ones a smooth maximum may lie there.
OPPOSITE = 4
SHARP_EDGE = "a sharp edge or corner"
UNKNOWN_HEIGHTS = (
    "No bound for the discretisation error: Problem.source does not say the heights on other grids, so nothing is "
    "known of them between the cell centres; make the problem from a Scene."
)
NO_AREA = (
    "No bound for the contact area: the contact is one or two cells wide, or may open in every cell, give more cells."
)
PROTRUDING = (
    "No bound for the discretisation error: between the cell centres the surface protrudes further than the contact "
    "flattens it; give more cells{}."
)


# Ratio of the hidden fraction of the load to the error of smooth edges below which no coarser solution is needed:
# hidden heights then add less than the edges, whose error by their law is several times the true one.
SMOOTH_RATIO = 0.25
# Largest error in L1 over the hidden fraction of the load, see :class:`HiddenEffect`: at most 0.66 in 180 rough line
# contacts on 32 to 128 cells in which that fraction is larger than the error of the edges.
HIDDEN_ERROR = 0.8
# Largest error of the area over the fraction of it that may open: at most 0.2 in 25 rough contacts, of which four times
# as much is taken, since openings are not bounded by anything else.
HIDDEN_AREA = 0.8
# Largest relative L1 difference of two pressures of one load, that of contacts without a common point.
MAX_L1 = 2.0
# Error of the load at a given approach over the L1 error due to the edges or the hidden fraction of the load: at most
# 0.27 of the former on 288 smooth line contacts of 10 to 255 cells across the width, whose approach counted from a
# point half the width of the grid away, or farther.
LOAD_ERROR = 0.3
# Fraction of the largest sum of pressure and attraction up to which heights below an attraction do not count: its tail
# covers most of the grid, where hidden heights change it little.
NEGLIGIBLE_ATTRACTION = 1e-3
# Fraction of the peak pressure that a corner adds at each halving of the cells, from which it counts as sharp: three
# halvings of such a corner change the peak by less than a half per cent.
SHARP_RISE = 1e-3
# Least number of neighbouring cells in contact, along each axis, for edges to follow their law, which uses the two or
# three cells next to each of them.
MIN_CELLS_ACROSS = 5
# Error of the peak pressure over Dundurs' beta times the jump of the shear where slip begins: at most 0.42 in 32
# contacts on 41 to 324 cells.
PEAK_BY_SHEAR = 0.6
# Pressure at a roller's end over the peak pressure, from which that end may have the peak: sharp rollers of 2.5 to 30
# half-widths have it there on 6 to 48 cells along; where a profile relieves the end, the pressure at it falls below a
# half as the cells become finer.
END_OVER_PEAK = 0.5
# Pressure at free faces over that in the next cell, up to which it counts as falling on finer cells too: at the ends of
# Lundberg profiles on 24 to 192 cells along it did; at those of one crown it rose from 0.85, at 0.6 of the peak.
FALLING_END = 0.9
# Errors in the end cells of a roller. END_RISE is the error over the rise of the end cells above the next ones, in cells
# as long as the half-width. END_LENGTH is the error over the pressure on the length by which the cells make an end too
# long or too short: 2, as that pressure lies elsewhere, and as much again for what it moves. With both, bounds were 1.9
# to 2.3 times the errors of 16 sharp rollers that fit their cells, and 1.1 to 10 times those of 41 that do not.
END_RISE, END_LENGTH = 0.5, 4.0


def discretisation_bound(
    solution: Solution, coarse: Solution | None, heights: HiddenHeights | None
) -> DiscretisationErrors:
    """Return the errors of `solution` due to its cells.

    Without adhesion the error of the area is only what no other grid shows; an answer adds its changes between grids
    (``ErrorEstimate.by_grids``). That of the load is None where the load is given. Parameters are those of
    :func:`~contactstudy.accuracy.estimate.error_estimate`.
    """
    problem = solution.problem
    pressure = solution.pressure[around_contact(solution.pressure)]
    load_is_result = problem.control.approach is not None or is_pull_off(solution)
    no_load = inf if load_is_result else None
    if reason := _cut_off(solution) or _unresolved_length(problem):
        return DiscretisationErrors.unbounded(reason, no_load)
    heights = heights or HiddenHeights.from_problem(problem)
    if heights is None:
        return DiscretisationErrors.unbounded(UNKNOWN_HEIGHTS, no_load)
    force = acting_force(solution)
    inside = heights.effect_under(problem, force)
    if inside.protrudes:
        scales_known = getattr(problem.source, "has_length_scales", False)
        reason = PROTRUDING.format("" if scales_known else ", or the shape's `length_scales`")
        return DiscretisationErrors.unbounded(reason, no_load)
    adheres, load_is_fixed = solution.adhesion is not None, _load_is_fixed(solution)
    at_end, at_hardness = end_error(solution), _at_hardness(solution)
    # where the grid chooses the range of an attraction, edges follow another law
    shown_peak, shown_l1 = (0.0, (0.0, 0.0)) if solution.regularised else shown_errors(solution)
    by_edges = sum(shown_l1)
    # the corners of a loaded end have an error of their own, `at_end`, which `by_edges` includes
    follows_law = (
        load_is_fixed
        and not at_hardness
        and _has_run_in_contact(pressure, MIN_CELLS_ACROSS)
        and inside.hidden_load <= SMOOTH_RATIO * by_edges
        and (at_end > 0 or inside.corner_rise <= SHARP_RISE)
    )
    changes = DiscretisationErrors(0.0, 0.0, 0.0, 0.0)
    if at_end or not follows_law:
        changes = error_by_change(solution, coarse)
    if changes.l1 == inf:
        return replace(changes, load=no_load)
    # the pressure in L1: by its law alone where it follows that, also at an end
    hidden_error = HIDDEN_ERROR * inside.hidden_load * float(force.sum())
    of_net, peak_of_net = over_net(solution)
    by_changes = 0.0 if follows_law else changes.l1
    largest_l1 = MAX_L1 if load_is_fixed else inf
    l1 = max(by_edges * of_net, by_changes, hidden_error / float(pressure.sum()) * of_net)
    l1 = min(largest_l1, l1) if _has_run_in_contact(pressure, 2) else largest_l1
    # the peak pressure, which may be the hardness
    no_peak = "" if at_hardness else _no_peak(solution, inside)
    peak = inf if no_peak else changes.peak_pressure
    if not at_hardness:
        peak = max(peak, max(shown_peak, inside.peak_rise) * peak_of_net) + _peak_by_shear(solution)
    # the load, where it is a result
    load = None
    if load_is_result:
        # the law of edges is of pressure alone: with adhesion the load has its change from larger cells
        by_law = LOAD_ERROR * max(0.0 if adheres else by_edges, inside.hidden_load)
        load = inf if l1 == inf else max(by_law, changes.load or 0.0)
        if adheres:
            net = abs(float(solution.net_pressure.sum()))
            load = max(load, hidden_error / net if net else inf)
        else:  # the level of the pressure, beside its shape that the edges show
            l1, peak = l1 + load, peak + load
    # the contact area
    unseen = 0.0 if adheres else unseen_area_error(solution.pressure, wraps_of(problem), lawful_edges(solution))
    area = max(unseen, relative_loss(HIDDEN_AREA * inside.area_loss), changes.contact_area if adheres else 0.0)
    if not adheres and not _has_run_in_contact(solution.pressure, 2):
        area = inf
    reasons = tuple(filter(None, (no_peak, NO_AREA if area == inf else "")))
    return DiscretisationErrors(l1, peak, area, load, reasons)


def lawful_edges(solution: Solution) -> StraightEdges | None:
    """Return the edges of a contact if they follow the law of straight ones, else None.

    They do not with adhesion, on a layer of few cells, and where a limit of the pressure makes a plateau.
    """
    scene = scene_of(solution.problem)
    bodies = () if scene is None else scene.solids
    layers = [bottom - top for body in bodies for *_, top, bottom in getattr(body, "parts", {}).values()]
    is_thin = min(layers, default=inf) < CELLS_IN_LAYER * solution.problem.grid.cell_size[0]
    has_other_law = is_thin or solution.adhesion is not None or _at_hardness(solution)
    return None if has_other_law else straight_edges(solution.pressure)


def is_highest_beside_edge(pressure: Array) -> bool:
    """Return whether a `pressure` (x, y) rises up to an edge, so that its curvature does not tell its maximum.

    Its highest cell is then one of the two at an edge, and `OPPOSITE` times as far from the opposite one.
    """
    highest = np.unravel_index(np.argmax(pressure), pressure.shape)
    for axis, place in enumerate(highest):
        line = axis_first(pressure, axis)[:, highest[1 - axis]]
        open_cells = np.flatnonzero(line == 0)
        before, after = open_cells[open_cells < place], open_cells[open_cells > place]
        if before.size and after.size:
            near, far = sorted((place - before[-1] - 0.5, after[0] - place - 0.5))
            if near < 2 and far >= OPPOSITE * near:
                return True
    return False


def dundurs_of_shear(solution: Solution) -> float:
    """Return Dundurs' parameter beta of the bodies of a solution with a tangential traction; 0 without one.

    It is 0 of similar bodies, in which a tangential traction does not displace the surface along its normal.
    """
    scene = scene_of(solution.problem)
    if solution.traction is None or scene is None:
        return 0.0
    from contactstudy.scene.friction import dundurs  # imported only where it is named

    return dundurs(scene.solids)


def _peak_by_shear(solution: Solution) -> float:
    """Return the relative error of the peak pressure by a shear of dissimilar bodies, which jumps where slip begins."""
    beta = dundurs_of_shear(solution)
    return PEAK_BY_SHEAR * abs(beta) * jump_of_shear(solution) / solution.peak_pressure if beta else 0.0


def jump_of_shear(solution: Solution) -> float:
    """Return the largest change [Pa] of a tangential traction between two cells where slip begins, or one cell away.

    It is 0 without a traction.
    """
    from scipy.ndimage import binary_dilation  # imported late, since it is slow

    traction, largest = solution.traction, 0.0
    if traction is None:
        return largest
    for axis in (0, 1):
        change = np.abs(np.diff(traction.shear, axis=axis + 1)).max(axis=0)
        near = binary_dilation(np.diff(np.asarray(traction.stick, bool), axis=axis))
        largest = max(largest, float(change[near].max(initial=0.0)))
    return largest


def shown_errors(solution: Solution) -> tuple[float, tuple[float, float]]:
    """Return the errors of the peak pressure and in L1 (across, along) that the pressure of the cells shows.

    Of a roller that ends within the grid, the rows of cells beyond its ends do not count.
    """
    pressure, covered = solution.pressure, solution.problem.covered_fractions
    if covered is not None:
        pressure = pressure[:, covered > 0]
    peak, (across, along) = discretisation_errors(pressure[around_contact(pressure)], wraps_of(solution.problem))
    return peak, (across, along + end_error(solution))


def end_error(solution: Solution) -> float:
    """Return the relative L1 error at the loaded ends of a roller; 0 without one.

    Towards a sharp end the pressure rises like the inverse square root of the distance from it, within about a
    half-width a: the line of end cells misses a part of its rise above the next one, which falls like
    ``(dy / a)^(1/2)``. Where an end divides cells, these make the roller too long or too short.
    """
    problem, pressure = solution.problem, solution.pressure
    if pressure.shape[1] == 1 or problem.source is None or not problem.source.ends_along:
        return 0.0
    covered = problem.covered_fractions  # of each line of cells, the fraction along y that the roller covers
    covered = np.ones(pressure.shape[1]) if covered is None else covered
    lines = np.flatnonzero(covered)
    misfit = abs(len(lines) - float(covered.sum())) / 2  # of the cells at each end, in cells
    error = 0.0
    for last, next_inward in (lines[:2], lines[:-3:-1]) if len(lines) > 1 else ():
        at_end = pressure[:, last]
        if cells := np.count_nonzero(at_end):
            half_width = cells * problem.grid.cell_size[0] / 2
            rise = float(np.abs(at_end - pressure[:, next_inward]).sum())
            error += END_RISE * sqrt(problem.grid.cell_size[1] / half_width) * rise
            error += END_LENGTH * misfit * float(at_end.sum())
    return error / float(pressure.sum())


def acting_force(solution: Solution) -> Array:
    """Return the sum of pressure and attraction (x, y) [Pa], below which heights count; 0 where it is negligible."""
    if solution.adhesion is None:
        return solution.pressure
    force = solution.pressure + solution.adhesion.attraction
    return np.where(force > NEGLIGIBLE_ATTRACTION * force.max(), force, 0.0)


def over_net(solution: Solution) -> tuple[float, float]:
    """Return the L1 norm of the pressure, and its peak, over those of the net pressure; both 1 without adhesion."""
    if solution.adhesion is None:
        return 1.0, 1.0
    pressure, peak = solution.pressure, abs(solution.peak_pressure)
    norm = float(pressure.sum()) / float(np.abs(solution.net_pressure).sum())
    return norm, float(pressure.max()) / peak if peak else inf


def is_pull_off(solution: Solution) -> bool:
    """Return whether the solution is the last stable state before pull-off."""
    return solution.adhesion is not None and solution.adhesion.first_unstable_load is not None


def _cut_off(solution: Solution) -> str:
    """Return a sentence if contact or attraction is cut off at the edge of the grid, else an empty string."""
    problem, cut_off = solution.problem, ""
    if problem.is_cut_off(solution.pressure):
        cut_off = "contact"
    elif solution.adhesion is not None:
        from contactstudy.solvers.adhesion import is_cut_off  # imported only where it is named

        cut_off = "attraction" if is_cut_off(problem, solution.adhesion.attraction) else ""
    if not cut_off:
        return ""
    return f"No bound: the {cut_off} is cut off at the edge of the grid, give Grid.extent a larger width or length."


def _unresolved_length(problem: Problem) -> str:
    """Return why the cells of `problem` are too large for a wave of its shapes; an empty string where they are not."""
    source = problem.source
    fault = "" if source is None else unresolved(source.shortest_wavelengths, problem.grid)
    return f"No bound for the discretisation error: {fault}" if fault else ""


def _no_peak(solution: Solution, inside: HiddenEffect) -> str:
    """Return why the peak pressure has no bound, beside heights inside the cells; an empty string where it has one."""
    reason = ""
    if inside.corner_rise > SHARP_RISE:
        reason = (
            f"it lies at {SHARP_EDGE}, where it is infinite: round the edge, close the seam of a measured surface, or "
            "ask for another quantity"
        )
    elif _at_sharp_end(solution.problem, solution.pressure):
        reason = "the roller carries pressure up to its sharp end, where it is infinite: give a profile that drops more"
    elif has_isolated_cells(solution):
        reason = "too few cells in contact are neighbours: give more cells"
    return f"{NO_PEAK}{reason}." if reason else ""


def _at_hardness(solution: Solution) -> bool:
    """Return whether the peak pressure is a hardness, which it is on finer cells too: its cell is then not active."""
    ix, iy = np.unravel_index(np.argmax(solution.pressure), solution.pressure.shape)
    active = solution.problem.constraint.active(solution.pressure[ix : ix + 1])
    return bool(active[0, iy] == 0)


def _at_sharp_end(problem: Problem, pressure: Array) -> bool:
    """Return whether an end of a roller has a `pressure` (x, y) of the order of the peak pressure; not without an end.

    There it is infinite in the limit of small cells, though coarse cells may not show a rise; at free faces it is only
    where it does not clearly fall, since their bodies are soft there. Ends within the grid, where the other body goes
    on, are sharp edges among the hidden heights.
    """
    if problem.source is None or not problem.source.ends_along:
        return False
    peaks, scene = pressure.max(axis=0), scene_of(problem)
    if scene is not None and scene.free_length < inf:
        ends = np.trim_zeros(peaks)
        if ends.size < 2:  # no row beside it tells whether the pressure falls to the end
            return bool(ends.size)
        return any(
            end > max(FALLING_END * before, END_OVER_PEAK * peaks.max()) for end, before in (ends[:2], ends[:-3:-1])
        )
    return bool(peaks[[0, -1]].max() > END_OVER_PEAK * peaks.max())


def has_isolated_cells(solution: Solution) -> bool:
    """Return whether fewer neighbouring cells are in contact than a bound of the peak pressure needs.

    It needs two along each axis, and three under a given load: the true peak above two cells may be any multiple of
    their pressure.
    """
    return not _has_run_in_contact(solution.pressure, 3 if _load_is_fixed(solution) else 2)


def _load_is_fixed(solution: Solution) -> bool:
    """Return whether the pressure carries a given load, and no attraction."""
    return solution.adhesion is None and solution.problem.control.approach is None


def _has_run_in_contact(pressure: Array, neighbours: int) -> bool:
    """Return whether somewhere in a `pressure` (x, y) as many `neighbours` along each axis are in contact.

    On an axis with fewer cells all of them are.
    """
    touching = pressure > 0
    runs = ((along, min(neighbours, len(along))) for along in (touching, touching.T))
    return all(
        bool(np.logical_and.reduce([along[k : len(along) + 1 - run + k] for k in range(run)]).any())
        for along, run in runs
    )

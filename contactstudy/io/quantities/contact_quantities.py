"""Quantities of a dry contact: those of friction, those of adhesion, and `contact_quantities`, which joins them.

A quantity is a number of an answer with its unit, its label and the bound of its error. One without a bound says why,
and is bounded later by its changes between grids where it can be. A solution has parts beside its pressure: a
tangential traction and an attraction. The net pressure is the pressure less the attraction. Totals are those of a
roller where the scene has one, and else per length.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf, isfinite
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from contactstudy.accuracy.coarser import StraightEdges, contact_area_in_cells, straight_edges, with_ends, wraps_of
from contactstudy.accuracy.error_terms import NO_LIMIT
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.grid import axis_first
from contactstudy.domain.validation import readable
from contactstudy.io.quantities.quantity import Quantity, bounded, per_length, roller_length, with_bound
from contactstudy.io.quantities.stress_quantities import largest_of, largest_place, stress_quantities
from contactstudy.problem.problem import Field
from contactstudy.scene.loads import DATUM_OVER_RADIUS
from contactstudy.scene.scene import scene_of
from contactstudy.scene.shapes.shape import curvature_of, standing_heights
from contactstudy.solvers.solution import (
    AdhesiveTraction,
    FrettingTraction,
    RollingTraction,
    Solution,
    TangentialTraction,
)

if TYPE_CHECKING:
    from contactstudy.evolution.steady_rolling import SteadyRolling

# ENERGY_ERROR / n^2 is the relative error of the energy of a cycle with n cells across the slip zone: at most 0.82 /
# n^2 in 190 smooth contacts against the closed form, and less in 16 rough ones. The largest slip grows as the width of
# the zone to the power of 3/2: a zone that is wider by SLIP_ZONE_MARGIN cells bounds it, where at most 1.1 were needed.
ENERGY_ERROR, SLIP_ZONE_MARGIN = 1.0, 1.25
# Slip over the rigid displacement up to which it is the residual of the solver: a hundred times its default tolerance.
SLIP_ROUNDING = 1e-6
NO_BOUND_OF_ONE_CELL = "No bound: the slip zone is at most one cell wide; solve again on cells of half the width."


def traction_quantities(
    solution: Solution, traction: TangentialTraction, estimate: ErrorEstimate, _: float | None
) -> dict[str, Quantity]:
    """Return the tangential force on the first body over the load, and the fraction of the contact that sticks.

    The ratio has a bound where it is known beforehand: from the given force where a part may stick, as the coefficient
    of friction in full sliding. It has none under a given tangential displacement, nor in full sliding with adhesion:
    friction goes with the repulsion, whose ratio to the load depends on the grid. The last argument is that of
    :data:`OF_PARTS`.
    """
    coefficient = Quantity(_force_over_load(solution, traction)[0], "1", "tangential force over load")
    friction = getattr(scene_of(solution.problem), "friction", None)
    if solution.adhesion is not None and not _sticks(friction):
        if solution.adhesion.regularised:
            coefficient = replace(coefficient, reason=NO_LIMIT)
    elif friction is not None and getattr(friction, "displacements", None) is None:
        pressed, load = float(solution.pressure.sum()), abs(_net_load(solution))
        error = ErrorParts(residual=solution.residual * (pressed / load if load else 1.0))
        # a load that is the result of an approach has an error of its own
        of_load = estimate.load if _sticks(friction) else None
        coefficient = with_bound(coefficient, of_load or error)
    return _of_force(solution, traction, estimate, {"traction_coefficient": coefficient})


def _sticks(friction: object) -> bool:
    """Return whether a part of the contact may stick under a `friction`, and not all of it slides."""
    return getattr(friction, "sticks", False)


def rolling_traction_quantities(
    solution: Solution, traction: RollingTraction, estimate: ErrorEstimate, length: float | None
) -> dict[str, Quantity]:
    """Return tangential and lateral force over the load, the fraction that sticks, creepage, and frictional power.

    Their bounds are the `errors` that the solver of the traction found by its own coarser grids, and that of the load.
    """
    pressed, load = float(solution.pressure.sum()), abs(_net_load(solution))
    by_cells = traction.errors.force * pressed / load if load else 0.0  # that of force over repulsion
    # at a given approach the load is a result
    of_load = solution.residual + (0.0 if estimate.load is None else estimate.load.total)
    names = ("traction_coefficient", "tangential"), ("lateral_traction_coefficient", "lateral")
    forces = {}
    for (name, direction), over_load in zip(names, _force_over_load(solution, traction), strict=True):
        force = Quantity(over_load, "1", f"{direction} force over load")
        forces[name] = _with_slip_bound(force, by_cells + of_load * abs(over_load), estimate)
    grid = solution.problem.grid
    total = float(traction.power.sum() * grid.cell_area)
    power = per_length(total, "W", "frictional power", length, grid.length)
    error = traction.errors.power if length is not None else traction.errors.power / grid.length
    # a cell outside has power by the mean of its traction and that of a neighbour: an error by the cells
    bound = traction.power_outside_contact * abs(power.value) + error
    creepage = Quantity(traction.creepage.longitudinal, "1", "longitudinal creepage")
    return _of_force(solution, traction, estimate, forces) | {
        "creepage": replace(creepage, bound=0.0, reason="")
        if traction.creepage_given
        else _with_slip_bound(creepage, traction.errors.creepage, estimate),
        "frictional_power": _with_slip_bound(power, bound, estimate),
    }


def _force_over_load(solution: Solution, traction: TangentialTraction) -> list[float]:
    """Return the tangential forces along x and y, of a `traction`, over the net load; 0 without a load."""
    load = _net_load(solution)
    return [float(force / load) if load else 0.0 for force in traction.shear.sum((1, 2))]


def _net_load(solution: Solution) -> float:
    """Return the sum of the pressure less that of the attraction [Pa]."""
    return float(solution.net_pressure.sum())


def _of_force(
    solution: Solution, traction: TangentialTraction, estimate: ErrorEstimate, forces: dict[str, Quantity]
) -> dict[str, Quantity]:
    """Return `forces` over the load, and the fraction of the contact that sticks, with its bound.

    Where bodies attract each other there is also the force over the repulsion. Under a pull, where the net load is not
    above 0, the forces over that load are left out.
    """
    pressed, touching = float(solution.pressure.sum()), int(np.count_nonzero(solution.pressure))
    sticking = float(np.count_nonzero(traction.stick) / touching) if touching else 0.0
    stick = Quantity(sticking, "1", "fraction of the contact that sticks", is_fraction=True)
    area = estimate.contact_area
    if area is not None and touching:
        at_boundary = np.count_nonzero(_at_stick_slip_boundary(solution, traction)) / touching
        of_area = area.total * stick.value if stick.value else 0.0  # the bound of the area may be infinite
        stick = _with_slip_bound(stick, at_boundary + of_area, estimate)
    if _net_load(solution) == pressed:
        return forces | {"stick_fraction": stick}
    over = float(traction.shear[0].sum()) / pressed if pressed else 0.0
    repulsive = Quantity(over, "1", "tangential force over repulsion")
    friction = getattr(scene_of(solution.problem), "friction", None)
    if friction is not None and not _sticks(friction):  # it is the coefficient of friction
        repulsive = replace(repulsive, bound=0.0, reason="")
    of_load = forces if _net_load(solution) > 0 else {}
    return of_load | {"stick_fraction": stick, "traction_over_repulsion": repulsive}


def fretting_quantities(
    solution: Solution, traction: FrettingTraction, estimate: ErrorEstimate, length: float | None
) -> dict[str, Quantity]:
    """Return force and stick, energy and largest slip of the last whole cycle, and the largest shear of all steps.

    Before a cycle is whole, energy and slip are those so far. The stick-slip boundary is uncertain by one cell. Slip
    starts there with zero slope, so that for a zone n cells wide the relative error of the energy is about 1 / n^2. The
    largest slip is bounded by that of a slightly wider zone. The width n is the number of slipping cells over that of
    those at the boundary.
    """
    grid = solution.problem.grid
    energy = float(traction.energy.sum() * grid.cell_area)
    name, counted, within = "energy_per_cycle", "per cycle", "in a cycle"
    if traction.cycle is None:
        name, counted, within = "friction_energy", "to friction", "so far"
    dissipated = per_length(energy, "J", f"energy lost {counted}", length, grid.length)
    slid = float(traction.slip_distance.max())
    largest_slip = Quantity(slid, "m", f"largest distance slipped {within}")
    slipping = traction.slip_distance > SLIP_ROUNDING * np.abs(traction.rigid_displacement).max()
    sticking = replace(traction, stick=(solution.pressure > 0) & ~slipping)
    boundary = int(np.count_nonzero(_at_stick_slip_boundary(solution, sticking) & slipping))
    slip_zone_cells = np.count_nonzero(slipping) / boundary if boundary else 0.0
    energy_error = ENERGY_ERROR / slip_zone_cells**2 if slip_zone_cells > 1 else inf
    slip_error = (1 + SLIP_ZONE_MARGIN / slip_zone_cells) ** 1.5 - 1 if slip_zone_cells > 1 else inf
    reason = estimate.l1.reason or ("" if slip_zone_cells > 1 else NO_BOUND_OF_ONE_CELL)
    dissipated = with_bound(dissipated, replace(estimate.l1, discretisation=energy_error, reason=reason))
    largest_slip = with_bound(largest_slip, replace(estimate.l1, discretisation=slip_error, reason=reason))
    shear = np.hypot(traction.shears[:, 0], traction.shears[:, 1]).max(axis=0, initial=0.0)
    return traction_quantities(solution, traction, estimate, length) | {
        name: dissipated,
        "largest_slip": largest_slip,
        "largest_shear": largest_of(shear, "Pa", "largest tangential traction of all steps"),
    }


def _at_stick_slip_boundary(solution: Solution, traction: TangentialTraction) -> NDArray[np.bool_]:
    """Return the touching cells (x, y) at the stick-slip boundary, the uncertainty of which is one row of cells.

    They stick beside one that slips, or slip beside one that sticks. Where all of a rolling contact slips, a zone of
    stick may hide in the cells at its leading edge, and those at either edge across are returned. Where no cell slips
    under a traction, a zone of slip may hide in those at any edge.
    """
    touching, stick = solution.pressure > 0, np.asarray(traction.stick, bool)
    if isinstance(traction, RollingTraction) and not stick.any():
        padded = np.pad(touching, ((1, 1), (0, 0)))
        return touching & ~(padded[2:] & padded[:-2])
    counted = touching  # neighbours that count
    if stick[touching].all() and traction.shear.any():
        stick, counted = touching, np.ones_like(touching)
    at_boundary = np.zeros_like(touching)
    for axis, wraps in enumerate(wraps_of(solution.problem)):
        for step in (1, -1):
            differs = np.roll(counted, step, axis) & (np.roll(stick, step, axis) != stick)
            if not wraps:
                axis_first(differs, axis)[0 if step == 1 else -1] = False
            at_boundary |= touching & differs
    return at_boundary


def _with_slip_bound(quantity: Quantity, bound: float, estimate: ErrorEstimate) -> Quantity:
    """Return a quantity with its absolute `bound`, if that is finite and slip and pressure have one in `estimate`.

    Else it has the reason why there is none.
    """
    if estimate.slip_reason:
        return replace(quantity, reason=estimate.slip_reason)
    if not isfinite(estimate.l1.total):
        reasons = (estimate.l1.reason, *estimate.warnings, quantity.reason)
        return replace(quantity, reason=next(filter(None, reasons)))
    return replace(quantity, bound=bound, reason="") if isfinite(bound) else quantity


def adhesion_quantities(
    solution: Solution, adhesion: AdhesiveTraction, estimate: ErrorEstimate, length: float | None
) -> dict[str, Quantity]:
    """Return quantities of the attraction, by name; with the pull-off load of bodies that are pulled apart.

    In contact the repulsive part of the pressure is the net pressure plus the strength of the attraction, so that the
    peaks of both have the same error. A regularised attraction has a range chosen for the grid, in place of the limit
    of short ranges, and no bounds. Loads are per `length` [m] of a roller, or of the grid if that is None.
    """
    grid = solution.problem.grid
    on_length = grid.length / (length or grid.length)
    touching, total = bool(solution.pressure.any()), float(adhesion.attraction.sum())
    attraction = float(adhesion.attraction.sum() * grid.cell_area / grid.length) * on_length
    label = "peak of the repulsive part"
    peak = bounded(solution.peak_pressure, "Pa", label, estimate.peak_pressure, estimate.warnings)
    repulsive = replace(peak, value=float(solution.pressure.max()))
    error = estimate.load or estimate.l1
    if adhesion.regularised:
        error = ErrorParts(range=inf, reason=NO_LIMIT)
        repulsive = replace(repulsive, bound=inf, reason=NO_LIMIT)
    elif touching and total:
        moved = moved_force(solution, estimate) / total
        error = ErrorParts(discretisation=moved, reason=estimate.l1.reason)
    quantities = {
        "peak_repulsive_pressure": repulsive,
        "attraction": bounded(attraction, "N m-1", "adhesive force per length", error, estimate.warnings),
        "energy": per_length(adhesion.energy, "J", "energy", length, grid.length),
        "attraction_range": Quantity(adhesion.range, "m", "range of the attraction", 0.0, ""),
        "cells_in_zone": Quantity(adhesion.cells_in_zone, "1", "cells in the cohesive zone", 0.0, ""),
        "detached": Quantity(float(not touching), "1", "1 if the bodies do not touch", 0.0, ""),
    }  # fmt: skip
    if adhesion.tabor is not None:
        quantities["tabor_parameter"] = Quantity(adhesion.tabor, "1", "Tabor parameter", 0.0, "")
    if adhesion.first_unstable_load is not None:
        load = -solution.load_per_length * on_length
        pull_off = bounded(load, "N m-1", "pull-off load", estimate.pull_off, estimate.warnings)
        quantities = {"pull_off": pull_off} | quantities
    return quantities


def moved_force(solution: Solution, estimate: ErrorEstimate) -> float:
    """Return the error [Pa] of a sum over cells, of the attraction or of the net pressure where bodies touch.

    By the errors in `estimate`, it is the error of the net pressure in L1, plus the largest attraction times the cells
    by which the contact may be larger or smaller. Times the area of a cell it is a force.
    """
    norm, touching = float(np.abs(solution.net_pressure).sum()), np.count_nonzero(solution.pressure)
    assert solution.adhesion is not None
    area = inf if estimate.contact_area is None else estimate.contact_area.total
    return estimate.l1.total * norm + area * touching * float(solution.adhesion.attraction.max())


# For the type of each part of a solution, the function that returns its quantities by name. Its arguments are the
# solution, the part, the errors of the solution, and the length [m] of a roller, None for others.
OF_PARTS: Mapping[type, Callable[..., dict[str, Quantity]]] = {
    TangentialTraction: traction_quantities,
    RollingTraction: rolling_traction_quantities,
    FrettingTraction: fretting_quantities,
    AdhesiveTraction: adhesion_quantities,
}


def contact_quantities(
    solution: Solution, estimate: ErrorEstimate, derived: Mapping[str, Field], rolling: "SteadyRolling | None" = None
) -> dict[str, Quantity]:
    """Return the quantities of a dry contact and of the effects that its scene names; none without a finite pressure.

    Areas, energies and powers are per length where the scene has no length of its own. Numbers that are bounded by their
    changes between grids have no bound yet (`_shown_error`).

    Parameters
    ----------
    solution
        The contact.
    estimate
        Estimate of its errors.
    derived
        Fields of the outputs that the scene names, such as the von Mises stress.
    rolling
        The steadily rolling contact that it belongs to, or None.
    """
    pressure, grid = solution.net_pressure, solution.problem.grid
    if not np.isfinite(pressure).all():
        return {}
    scene, touching, warnings = scene_of(solution.problem), solution.pressure > 0, estimate.warnings
    length = roller_length(solution.problem.description)
    wraps, adheres = wraps_of(solution.problem), solution.adhesion is not None
    # an attraction makes edges steep, and nothing is known of where in their cells they lie
    edges = None if adheres else straight_edges(solution.pressure)
    in_cells = np.count_nonzero(touching) if adheres else contact_area_in_cells(solution.pressure, wraps, edges)
    area = in_cells * grid.cell_area
    total = float(pressure[touching].sum() * grid.cell_area)
    pressed = np.where(touching, pressure, -inf) if touching.any() else np.zeros(grid.cells)
    peak, place = largest_place(pressed, {"x": grid.x, "y": grid.y})
    area_error = _shown_error(estimate, "contact_area")
    half_width, half_length = (
        _half_size(solution, axis, smooth, area_error, warnings) for axis, smooth in enumerate((edges, None))
    )
    is_point = scene is not None and scene.ellipse is not None
    width_note = "" if wraps[0] else f", over the grid's width of {readable(grid.extent[0], 'm')}"
    label = f"peak {'net ' if adheres else ''}pressure"
    quantities = {"peak_pressure": bounded(peak, "Pa", label, estimate.peak_pressure, warnings, position=place)}
    quantities |= stress_quantities(scene, derived, grid, estimate, solution.problem.paddings)
    if rolling is not None:
        quantities |= _of_rolling(rolling)
    for part in solution.parts:
        quantities |= OF_PARTS[type(part)](solution, part, estimate, length)
    in_contact = per_length(area, "m2", "contact area", length, grid.length)
    mean, mean_error = total / area if area else 0.0, area_error
    if adheres and mean and area_error is not None:
        moved = moved_force(solution, estimate) * grid.cell_area + area_error.total * abs(total)
        mean_error = ErrorParts(discretisation=moved / abs(total), reason=area_error.reason)
    if mean_error is not None and estimate.load is not None:  # at a given approach the load has an error too
        both = mean_error.total + estimate.load.total
        mean_error = ErrorParts(discretisation=both, reason=mean_error.reason)
    # a full contact has no gap but rounding
    apart = 0.0 if solution.pressure.all() else solution.mean_gap
    quantities |= {
        "contact_area": with_bound(in_contact, area_error, warnings),
        "half_width": half_width,
        **({"half_length": half_length} if is_point else {}),
        "mean_pressure": bounded(mean, "Pa", "mean pressure in contact", mean_error, warnings),
        "mean_gap": bounded(apart, "m", "mean gap", _shown_error(estimate, "mean_gap"), warnings, detail=width_note),
        "approach": _approach(solution, estimate),
    }
    if scene is not None and not scene.has_approach:
        del quantities["approach"]
    if scene is not None and scene.radius is None and wraps[0]:
        # contact of flats may reach across the whole period, so that it has no edges and no width
        fraction, label = in_cells / solution.pressure.size, "fraction of the nominal area in contact"
        quantities["contact_fraction"] = bounded(fraction, "1", label, area_error, warnings)
        if touching[0].any() and touching[-1].any():
            del quantities["half_width"]
    if scene is not None and scene.hardness < inf:
        quantities["yielded_depth"] = largest_of(solution.dent, "m", "largest plastic indentation")
    load, load_error = float(pressure.sum()) * grid.cell_area, estimate.load or ErrorParts(residual=solution.residual)
    if not is_point:
        per_metre = load / (length or grid.length)
        quantities["load_per_length"] = bounded(per_metre, "N m-1", "load per length", load_error)
    if length is not None:
        quantities["total_load"] = bounded(load, "N", "load", load_error)
    return quantities


def _approach(solution: Solution, estimate: ErrorEstimate) -> Quantity:
    """Return the approach, which is exact where it is given, with the point from which it counts in its label."""
    detail = datum_text(solution)
    if solution.problem.control.approach is not None:
        return Quantity(solution.approach, "m", "approach", 0.0, "", detail=detail)
    approach = Quantity(solution.approach, "m", "approach", detail=detail)
    return with_bound(approach, _shown_error(estimate, "approach"), estimate.warnings)


def _shown_error(estimate: ErrorEstimate, name: str) -> ErrorParts | None:
    """Return the error of the number `name` in `estimate`; None where its changes between grids bound it.

    An infinite one is returned even then, for its reason.
    """
    parts: ErrorParts | None = getattr(estimate, name)
    return None if name in estimate.by_grids and parts is not None and isfinite(parts.total) else parts


def approach_datum(solution: Solution) -> float | None:
    """Return the distance [m] from the axis at which the surface does not move; None where there is none.

    Along an endless contact, with images along y alone, the approach grows with the logarithm of this distance (Johnson
    1985, eq. 2.20). Under other paddings, or without a scene, there is none.
    """
    problem, scene = solution.problem, scene_of(solution.problem)
    if scene is None or problem.paddings is None:
        return None
    across, along = problem.paddings
    if along.window is not None or across.window is None:
        return None
    return scene.datum(problem.grid)


def datum_text(solution: Solution) -> str:
    """Return from where an approach counts, as the end of a label; empty where no distance matters.

    Of a pair that conforms it says too that this is twice the equivalent radius, which is far.
    """
    if not (datum := approach_datum(solution)):
        return ""
    scene = scene_of(solution.problem)
    why = ""
    if scene is not None and scene.radius is not None and any(curvature_of(shape) < 0 for shape in scene.shapes):
        why = " (twice the equivalent radius)" if datum == DATUM_OVER_RADIUS * scene.radius else ""
    return f", from a point {readable(datum)} away{why}"


def _of_rolling(rolling: "SteadyRolling") -> dict[str, Quantity]:
    """Return the coefficient of rolling resistance, and the distance [m] of the pressure's centroid ahead of the axis.

    Heights that stand still while a body slides past them make the resistance one to sliding.
    """
    scene = scene_of(rolling.solution.problem)
    slides = scene is not None and standing_heights(scene.shapes)
    label = f"coefficient of {'hysteretic sliding friction' if slides else 'rolling resistance'}"
    resistance = Quantity(rolling.resistance_coefficient, "1", label)
    if not rolling.loses_energy:
        resistance = replace(resistance, bound=0.0, reason="")
    return {
        "rolling_resistance": resistance,
        "pressure_shift": Quantity(rolling.shift, "m", "pressure centroid ahead of the axis"),
    }


def _half_size(
    solution: Solution,
    axis: int,
    edges: StraightEdges | None,
    area_error: ErrorParts | None,
    fallback_reasons: Sequence[str],
) -> Quantity:
    """Return half the distance between the outermost edges in contact along an axis: half-width or half-length.

    Straight smooth `edges` lie inside their cells; their places count in cells outward from the middle of the grid.
    Elsewhere the outer faces of the outermost cells count, and may each be half a cell off, or lie where the surface
    protrudes beyond them. With adhesion, where `area_error` is known, the bound is a cell, or the relative error of the
    area if that is more. The `fallback_reasons` are those of :func:`~contactstudy.io.quantities.quantity.with_bound`.
    """
    cell = solution.problem.grid.cell_size[axis]
    size = counted = _half_extent(solution.pressure > 0, axis, cell)
    unseen = _half_extent(_may_touch(solution), axis, cell) - counted
    if edges is not None:
        size = sum(float(edge.max()) for edge in edges.places) * cell / 2
    else:
        unseen += cell / 2
    name = ("half-width", "half-length")[axis]
    # a rival, (value, depth), is what the value may be as well: the bound reaches to it
    half = Quantity(size, "m", f"{name} (outermost edges)", rivals=((size + unseen, 0.0),))
    if area_error is None or not isfinite(area_error.total):
        return with_bound(half, area_error, fallback_reasons)
    return replace(half, bound=max(cell, area_error.total * size), reason="")


def _may_touch(solution: Solution) -> NDArray[np.bool_]:
    """Return the cells (x, y) in contact, and those of a lowest gap that may close between the cell centres.

    It may where the means of the neighbours along each axis exceed the gap, together, by more than the gap itself.
    """
    gap = solution.gap
    is_lowest, rise = np.ones(gap.shape, bool), np.zeros(gap.shape)
    for axis, wraps in enumerate(wraps_of(solution.problem)):
        if gap.shape[axis] > 1:
            padded = with_ends(axis_first(gap, axis), 1, wraps=wraps)
            before, after = (axis_first(beside, axis) for beside in (padded[:-2], padded[2:]))
            is_lowest &= gap <= np.minimum(before, after)
            rise += (before + after) / 2 - gap
    return (solution.pressure > 0) | (is_lowest & (gap < rise))


def _half_extent(cells: NDArray[np.bool_], axis: int, size: float) -> float:
    """Return half the distance [m] between the outer edges of the outermost of some `cells` (x, y) along an axis.

    The cells have this `size` [m] along it; without any it is 0.
    """
    at = np.flatnonzero(cells.any(axis=1 - axis))
    return float((at[-1] - at[0] + 1) * size / 2) if len(at) else 0.0

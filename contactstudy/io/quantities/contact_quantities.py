"""Quantities of a dry contact and of its effects."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf, isfinite
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from contactstudy.accuracy.discretisation.cells import contact_area_in_cells, with_ends
from contactstudy.accuracy.discretisation.contact_edge import resolved_edges
from contactstudy.accuracy.range_errors import NO_LIMIT
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import readable
from contactstudy.io.quantities.quantity import Quantity, per_length, roller_length, with_bound
from contactstudy.io.quantities.stress_quantities import largest_place, stress_quantities
from contactstudy.problem.problem import Field
from contactstudy.scene.scene import PosedScene, scene_of
from contactstudy.scene.shapes_source import standing_heights
from contactstudy.solvers.friction.fretting_traction import FrettingTraction
from contactstudy.solvers.friction.rolling_traction import RollingTraction
from contactstudy.solvers.solution import AdhesiveTraction, Solution, TangentialTraction

if TYPE_CHECKING:
    from contactstudy.evolution.rolling.steady_rolling import SteadyRolling


# Relative error of the energy of a cycle, times the square of the cells n across the slip zone: at most 0.82 in 190
# smooth contacts against the closed form, and less in 16 rough ones. Cells by which the zone may be wider for its
# largest slip, which grows as the width to the power of 3/2: at most 1.1.
ENERGY_ERROR, SLIP_ZONE_MARGIN = 1.0, 1.25
NO_BOUND_OF_ONE_CELL = (
    "No bound: the slip zone is at most one cell wide; solve again on cells of half the width."
)


def contact_quantities(
    solution: Solution,
    estimate: ErrorEstimate,
    derived: Mapping[str, Field],
    rolling: "SteadyRolling | None" = None,
) -> dict[str, Quantity]:
    """Return the quantities of a dry contact and of the effects that its scene names; none without a finite pressure.

    Areas, energies and powers are per length where the scene has no length of its own.

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
    scene, touching, fallback_reasons = (
        scene_of(solution.problem),
        solution.pressure > 0,
        estimate.warnings,
    )
    posed = solution.problem.description
    length = roller_length(posed if isinstance(posed, PosedScene) else None)
    paddings = solution.problem.paddings
    wraps = (False, False) if paddings is None else (paddings[0].wraps, paddings[1].wraps)
    # an attraction makes edges steep, and nothing is known of where in their cells they lie
    adheres = solution.adhesion is not None
    count = np.count_nonzero(touching)
    area = (count if adheres else contact_area_in_cells(solution.pressure, wraps)) * grid.cell_area
    total = float(pressure[touching].sum() * grid.cell_area)
    pressed = np.where(touching, pressure, -inf) if touching.any() else np.zeros(grid.cells)
    peak, place = largest_place(pressed, {"x": grid.x, "y": grid.y})
    area_error = estimate.contact_area
    half_width, half_length = (
        _half_size(solution, axis, area_error, fallback_reasons) for axis in (0, 1)
    )
    is_point = scene is not None and scene.ellipse is not None
    solved = ErrorParts(residual=solution.residual)
    width_note = "" if wraps[0] else f", over the grid's width of {readable(grid.extent[0], 'm')}"
    mirrored = _mirrored(pressure, grid.y, place)
    label = "peak pressure" if solution.adhesion is None else "peak net pressure"
    highest = Quantity(peak, "Pa", label, position=place, detail=mirrored)
    highest = with_bound(highest, estimate.peak_pressure, fallback_reasons)
    quantities = {"peak_pressure": highest}
    quantities |= stress_quantities(scene, derived, grid, estimate)
    if rolling is not None:
        quantities |= _of_rolling(rolling, estimate)
    if solution.traction is not None:
        quantities |= _of_traction(solution, solution.traction, estimate)
        if isinstance(solution.traction, RollingTraction):
            quantities |= _of_creepage(solution.traction, estimate, grid, length)
        if isinstance(solution.traction, FrettingTraction):
            quantities |= _of_cycle(solution, solution.traction, estimate, length)
    if solution.adhesion is not None:
        quantities |= _of_adhesion(solution, solution.adhesion, estimate, highest, length)
    in_contact = per_length(area, "m2", "contact area", length, grid.length)
    mean = Quantity(total / area if area else 0.0, "Pa", "mean pressure in contact")
    mean_error = area_error
    if solution.adhesion is not None and mean.value and area_error is not None:
        moved = _moved_force(solution, estimate) * grid.cell_area + area_error.total * abs(total)
        mean_error = ErrorParts(discretisation=moved / abs(total), reason=area_error.reason)
    if mean_error is not None and estimate.load is not None:  # at a given approach
        both = mean_error.total + estimate.load.total
        mean_error = ErrorParts(discretisation=both, reason=mean_error.reason)
    mean_gap = Quantity(solution.mean_gap, "m", "mean gap", detail=width_note)
    quantities |= {
        "contact_area": with_bound(in_contact, area_error, fallback_reasons),
        "half_width": half_width,
        **({"half_length": half_length} if is_point else {}),
        "mean_pressure": with_bound(mean, mean_error, fallback_reasons),
        "mean_gap": with_bound(mean_gap, estimate.mean_gap, fallback_reasons),
        "approach": _approach(solution, estimate),
    }
    if scene is not None and not scene.has_approach:
        del quantities["approach"]
    if scene is not None and scene.hardness < inf:
        depth = float(solution.dent.max())
        quantities["yielded_depth"] = Quantity(depth, "m", "largest plastic indentation")
    load, load_parts = float(solution.net_pressure.sum()) * grid.cell_area, estimate.load or solved
    if not is_point:
        quantities["load_per_length"] = with_bound(
            Quantity(load / (length or grid.length), "N m-1", "load per length"), load_parts
        )
    if length is not None:
        quantities["total_load"] = with_bound(Quantity(load, "N", "load"), load_parts)
    return quantities


def _approach(solution: Solution, estimate: ErrorEstimate) -> Quantity:
    """Return the approach, which is exact where it is given, and the point that it is counted from."""
    datum = approach_datum(solution)
    detail = f", from a point {readable(datum)} away" if datum else ""
    if solution.problem.control.approach is not None:
        return Quantity(solution.approach, "m", "approach", 0.0, "", detail=detail)
    approach = Quantity(solution.approach, "m", "approach", detail=detail)
    return with_bound(approach, estimate.approach, estimate.warnings)


def approach_datum(solution: Solution) -> float | None:
    """Return the distance [m] from the axis at which the surface does not move; None where the padding fixes it.

    Along an endless contact the approach grows with the logarithm of this distance (Johnson 1985, eq. 2.20).
    """
    problem, scene = solution.problem, scene_of(solution.problem)
    if scene is None or problem.paddings is None:
        return None
    across, along = problem.paddings
    if along.window is not None or across.window is None:
        return None
    return scene.datum(problem.grid)


def _of_adhesion(
    solution: Solution,
    adhesion: AdhesiveTraction,
    estimate: ErrorEstimate,
    peak: Quantity,
    length: float | None,
) -> dict[str, Quantity]:
    """Return pull-off load, attraction, its energy and range, cells in its zone, Tabor parameter, 1 if detached.

    In contact the repulsive part of the pressure is the strength above the net one, whose `peak` has the same error.
    """
    grid = solution.problem.grid
    on_length = grid.length / (length or grid.length)
    attraction = float(adhesion.attraction.sum() * grid.cell_area / grid.length) * on_length
    touching, total = bool(solution.pressure.any()), float(adhesion.attraction.sum())
    repulsive = Quantity(
        float(solution.pressure.max()), "Pa", "peak of the repulsive part", peak.bound, peak.reason
    )
    error = estimate.load or estimate.l1
    if adhesion.regularised:
        error = ErrorParts(range=inf, reason=NO_LIMIT)
        repulsive = replace(repulsive, bound=inf, reason=NO_LIMIT)
    elif touching and total:
        moved = _moved_force(solution, estimate) / total
        error = ErrorParts(discretisation=moved, reason=estimate.l1.reason)
    quantities = {
        "peak_repulsive_pressure": repulsive,
        "attraction": with_bound(
            Quantity(attraction, "N m-1", "adhesive force per length"), error, estimate.warnings
        ),
        "energy": per_length(adhesion.energy, "J", "energy", length, grid.length),
        "attraction_range": Quantity(adhesion.range, "m", "range of the attraction", 0.0, ""),
        "cells_in_zone": Quantity(adhesion.cells_in_zone, "1", "cells in the cohesive zone", 0.0, ""),
        "detached": Quantity(float(not touching), "1", "1 if the bodies do not touch", 0.0, ""),
    }  # fmt: skip
    if adhesion.tabor is not None:
        quantities["tabor_parameter"] = Quantity(adhesion.tabor, "1", "Tabor parameter", 0.0, "")
    if adhesion.first_unstable_load is not None:
        pull_off = Quantity(-solution.load_per_length * on_length, "N m-1", "pull-off load")
        quantities = {
            "pull_off": with_bound(pull_off, estimate.pull_off, estimate.warnings)
        } | quantities
    return quantities


def _moved_force(solution: Solution, estimate: ErrorEstimate) -> float:
    """Return the error of the sum of the attraction [Pa], and of the net pressure in contact.

    It is that of the net pressure, and the strength where the contact may be larger or smaller.
    """
    norm, touching = float(np.abs(solution.net_pressure).sum()), np.count_nonzero(solution.pressure)
    assert solution.adhesion is not None
    area = inf if estimate.contact_area is None else estimate.contact_area.total
    return estimate.l1.total * norm + area * touching * float(solution.adhesion.attraction.max())


def _of_traction(
    solution: Solution, traction: TangentialTraction, estimate: ErrorEstimate
) -> dict[str, Quantity]:
    """Return the tangential force on the first body over the load, and the part of the contact that sticks."""
    pressure = solution.pressure
    pressed, touching = float(pressure.sum()), int(np.count_nonzero(pressure))
    attracted = 0.0 if solution.adhesion is None else float(solution.adhesion.attraction.sum())
    load = pressed - attracted
    along_x, along_y = (
        float(force / load) if load else 0.0 for force in traction.shear.sum((1, 2))
    )
    coefficient = Quantity(along_x, "1", "tangential force over load")
    lateral_force: dict[str, Quantity] = {}
    # at a given approach the load is a result
    load_error = 0.0 if estimate.load is None else estimate.load.total
    if isinstance(traction, RollingTraction):
        by_cells = traction.errors.force * pressed / abs(load) if load else 0.0
        across = Quantity(along_y, "1", "lateral force over load")
        coefficient, lateral = (
            _with_slip_bound(
                q, by_cells + (solution.residual + load_error) * abs(q.value), estimate
            )
            for q in (coefficient, across)
        )
        lateral_force = {"lateral_traction_coefficient": lateral}
    friction = getattr(scene_of(solution.problem), "friction", None)
    displacement_given = getattr(friction, "displacements", None) is not None
    if not (isinstance(traction, RollingTraction) or friction is None or displacement_given):
        # the force is given, or in full sliding that over the load
        force_is_given = getattr(friction, "sticks", False)
        parts = estimate.load if force_is_given else None
        of_load = solution.residual * (pressed / abs(load) if load else 1.0)
        coefficient = with_bound(coefficient, parts or ErrorParts(residual=of_load))
    sticking = float(np.count_nonzero(traction.stick) / touching) if touching else 0.0
    stick = Quantity(sticking, "1", "fraction of the contact that sticks")
    area = estimate.contact_area
    if area is not None and touching:
        at_boundary = np.count_nonzero(_at_stick_slip_boundary(solution, traction)) / touching
        stick = _with_slip_bound(stick, at_boundary + area.total * stick.value, estimate)
    quantities = {"traction_coefficient": coefficient, **lateral_force, "stick_fraction": stick}
    if solution.adhesion is None:
        return quantities
    if load <= 0:  # a pull, over which a tangential force means nothing
        quantities = {"stick_fraction": stick}
    over = float(traction.shear[0].sum()) / pressed if pressed else 0.0
    repulsive = Quantity(over, "1", "tangential force over repulsion")
    return quantities | {"traction_over_repulsion": repulsive}


def _at_stick_slip_boundary(solution: Solution, traction: TangentialTraction) -> NDArray[np.bool_]:
    """Return the touching cells (x, y) at the stick-slip boundary, the uncertainty of which is one row of cells.

    Where all of a rolling contact slips, a zone of stick may hide in the cells at its leading edge; where no cell slips
    under a traction, a zone of slip in those at any edge.
    """
    touching, stick = solution.pressure > 0, np.asarray(traction.stick, bool)
    if isinstance(traction, RollingTraction) and not stick.any():
        padded = np.pad(touching, ((1, 1), (0, 0)))
        return touching & ~(padded[2:] & padded[:-2])
    paddings = solution.problem.paddings
    may_slip_at_edge = bool(stick[touching].all() and np.any(traction.shear))
    within = touching
    if may_slip_at_edge:
        stick, within = touching, np.ones_like(touching)
    beside = np.zeros_like(touching)
    for axis in (0, 1):
        for step in (1, -1):
            edge = np.roll(within, step, axis) & (np.roll(stick, step, axis) != stick)
            if paddings is None or not paddings[axis].wraps:
                edge[(slice(None),) * axis + (0 if step == 1 else -1,)] = False
            beside |= touching & edge
    return beside


def _of_cycle(
    solution: Solution, traction: FrettingTraction, estimate: ErrorEstimate, length: float | None
) -> dict[str, Quantity]:
    """Return energy and largest slip of the last whole cycle of a fretting contact, else of all, and its largest shear.

    The stick-slip boundary is uncertain by one cell. Slip starts there with zero slope, so that for a zone n cells
    wide the relative error of the energy is about 1 / n^2. The largest slip is bounded by that of a slightly wider zone.
    """
    grid = solution.problem.grid
    energy = float(traction.energy.sum() * grid.cell_area)
    name, counted, within = "energy_per_cycle", "per cycle", "in a cycle"
    if traction.cycle is None:
        name, counted, within = "friction_energy", "to friction", "so far"
    dissipated = per_length(energy, "J", f"energy lost {counted}", length, grid.length)
    slid = float(traction.slip_distance.max())
    largest_slip = Quantity(slid, "m", f"largest distance slipped {within}")
    slipping = (solution.pressure > 0) & ~np.asarray(traction.stick, bool)
    boundary = int(np.count_nonzero(_at_stick_slip_boundary(solution, traction) & slipping))
    slip_zone_cells = np.count_nonzero(slipping) / boundary if boundary else 0.0
    energy_error = ENERGY_ERROR / slip_zone_cells**2 if slip_zone_cells > 1 else inf
    slip_error = (1 + SLIP_ZONE_MARGIN / slip_zone_cells) ** 1.5 - 1 if slip_zone_cells > 1 else inf
    reason = estimate.l1.reason or ("" if slip_zone_cells > 1 else NO_BOUND_OF_ONE_CELL)
    if traction.cycle is not None and traction.cycle[1] == len(traction.shears):
        # of other forces the slip zone is that of the last one
        dissipated, largest_slip = (
            with_bound(number, replace(estimate.l1, discretisation=relative, reason=reason))
            for number, relative in ((dissipated, energy_error), (largest_slip, slip_error))
        )
    return {
        name: dissipated,
        "largest_slip": largest_slip,
        "largest_shear": Quantity(
            traction.largest_shear, "Pa", "largest tangential traction of all steps"
        ),
    }


def _of_creepage(
    traction: RollingTraction, estimate: ErrorEstimate, grid: Grid, length: float | None
) -> dict[str, Quantity]:
    """Return what tractive rolling adds to the numbers of a traction: creepage, and power with its bound."""
    total = float(traction.power.sum() * grid.cell_area)
    power = per_length(total, "W", "frictional power", length, grid.length)
    over_length = 1.0 if length is not None else 1 / grid.length
    outside = traction.power_outside_contact * abs(power.value)
    bound = outside + traction.errors.power * over_length
    creepage = Quantity(traction.creepage.longitudinal, "1", "longitudinal creepage")
    return {
        "creepage": replace(creepage, bound=0.0, reason="")
        if traction.creepage_given
        else _with_slip_bound(creepage, traction.errors.creepage, estimate),
        "frictional_power": _with_slip_bound(power, bound, estimate),
    }


def _with_slip_bound(quantity: Quantity, bound: float, estimate: ErrorEstimate) -> Quantity:
    """Return a quantity with its `bound` if that is finite, and slip and pressure have one."""
    if estimate.slip_reason:
        return replace(quantity, reason=estimate.slip_reason)
    if not isfinite(estimate.l1.total):
        reasons = (estimate.l1.reason, *estimate.warnings, quantity.reason)
        return replace(quantity, reason=next(filter(None, reasons)))
    return replace(quantity, bound=bound, reason="") if isfinite(bound) else quantity


def _of_rolling(rolling: "SteadyRolling", estimate: ErrorEstimate) -> dict[str, Quantity]:
    """Return the coefficient of rolling resistance, and the distance of the pressure's centroid from the axis."""
    scene = scene_of(rolling.solution.problem)
    slides = scene is not None and standing_heights(scene.shapes)
    label = f"coefficient of {'hysteretic sliding friction' if slides else 'rolling resistance'}"
    resistance = Quantity(rolling.resistance_coefficient, "1", label)
    return {
        "rolling_resistance": with_bound(
            resistance, estimate.rolling_resistance, estimate.warnings
        ),
        "pressure_shift": Quantity(rolling.shift, "m", "pressure centroid ahead of the axis"),
    }


def _half_size(
    solution: Solution,
    axis: int,
    area_error: ErrorParts | None,
    fallback_reasons: Sequence[str],
) -> Quantity:
    """Return half the distance between the outermost edges in contact along an axis, with its bound.

    Straight smooth edges lie inside their cells, with the error of the area, and where they bend along the length with
    what they do so between two cells. Elsewhere the outer faces of the outermost cells count. On cells of any size,
    contact reaches at least to where a touching cell has another beside it, and at most to where the gap is no larger
    than heights inside a cell, which the second difference of the gap shows.
    """
    touching, grid = solution.pressure > 0, solution.problem.grid
    cell = grid.cell_size[axis]
    resolved: tuple[Array, Array] | None = None
    if axis == 0 and solution.adhesion is None:
        resolved = resolved_edges(solution.pressure)
    size = _half_extent(touching, axis, cell)
    if resolved is not None:
        size = sum(float(edge.max()) for edge in resolved) * cell / 2
    name = ("half-width", "half-length")[axis]
    half = Quantity(size, "m", f"{name} (outermost edges)")
    if area_error is None or not isfinite(area_error.total):
        return with_bound(half, area_error, fallback_reasons)
    if resolved is not None:
        bends = (np.roll(edge, 1) + np.roll(edge, -1) - 2 * edge for edge in resolved)
        bent = sum(float(np.abs(bend).max()) for bend in bends) * cell / 2
        return replace(half, bound=area_error.total * size + bent, reason="")
    beside, hidden = np.zeros_like(touching), np.zeros_like(solution.gap)
    for across in (0, 1):
        if grid.cells[across] > 1:
            beside |= np.roll(touching, 1, across) | np.roll(touching, -1, across)
            gap = with_ends(np.swapaxes(solution.gap, 0, across), 1, wraps=False)
            hidden += np.abs(np.swapaxes(np.diff(gap, 2, axis=0), 0, across)) / 8
    within = touching & beside
    least = _half_extent(within, axis, cell)
    most = _half_extent(touching | (solution.gap <= hidden), axis, cell)
    # the outermost cells beside what the other causes change of the area
    other_causes = area_error.total - (area_error.discretisation or 0.0)
    bound = max(size - least, most - size) + cell + other_causes * size
    return replace(half, bound=bound, reason="")


def _half_extent(cells: NDArray[np.bool_], axis: int, size: float) -> float:
    """Return half the distance between the outer edges of the outermost of some cells (x, y) along an axis [m]."""
    at = np.flatnonzero(cells.any(axis=1 - axis))
    return float((at[-1] - at[0] + 1) * size / 2) if len(at) else 0.0


def _mirrored(values: Array, y: Array, position: Mapping[str, float]) -> str:
    """Return the mirrored place along the length as text, empty unless the value there is as large to a thousandth."""
    if abs(at := position.get("y", 0.0)) <= 0.1 * float(np.ptp(y)):
        return ""
    mirrored = values[:, int(np.abs(y + at).argmin())].max()
    return f", as high at y = {readable(-at, 'm', 3)}" if mirrored > 0.999 * values.max() else ""

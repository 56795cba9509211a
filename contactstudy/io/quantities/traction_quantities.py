"""Quantities of a contact with friction: in sliding, fretting and tractive rolling."""

from dataclasses import replace
from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from contactstudy.accuracy.error_terms import NO_LIMIT
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.io.quantities.quantity import Quantity, per_length, with_bound
from contactstudy.io.quantities.stress_quantities import largest_of
from contactstudy.scene.scene import scene_of
from contactstudy.solvers.friction.traction import FrettingTraction, RollingTraction
from contactstudy.solvers.solution import Solution, TangentialTraction

# ENERGY_ERROR / n^2 is the relative error of the energy of a cycle with n cells across the slip zone: at most 0.82 / n^2
# in 190 smooth contacts against the closed form, and less in 16 rough ones. The largest slip grows as the width of the
# zone to the power of 3/2: a zone that is wider by SLIP_ZONE_MARGIN cells bounds it, where at most 1.1 were needed.
ENERGY_ERROR, SLIP_ZONE_MARGIN = 1.0, 1.25
# Slip over the rigid displacement up to which it is the residual of the solver.
SLIP_ROUNDING = 1e-6
NO_BOUND_OF_ONE_CELL = "No bound: the slip zone is at most one cell wide; solve again on cells of half the width."


def traction_quantities(
    solution: Solution, traction: TangentialTraction, estimate: ErrorEstimate, _: float | None
) -> dict[str, Quantity]:
    """Return the tangential force on the first body over the load, and the part of the contact that sticks."""
    coefficient = Quantity(_force_over_load(solution, traction)[0], "1", "tangential force over load")
    friction = getattr(scene_of(solution.problem), "friction", None)
    sticks = getattr(friction, "sticks", False)
    if solution.adhesion is not None and not sticks:
        # full sliding over the load, which the grid changes with the repulsion
        if solution.adhesion.regularised:
            coefficient = replace(coefficient, reason=NO_LIMIT)
    elif not (friction is None or getattr(friction, "displacements", None) is not None):
        pressed, load = float(solution.pressure.sum()), abs(_net_load(solution))
        error = ErrorParts(residual=solution.residual * (pressed / load if load else 1.0))
        # where the contact sticks the force is given, else in full sliding that over the load
        if sticks and estimate.load is not None:
            error = estimate.load
        coefficient = with_bound(coefficient, error)
    return _of_force(solution, traction, estimate, {"traction_coefficient": coefficient})


def rolling_traction_quantities(
    solution: Solution, traction: RollingTraction, estimate: ErrorEstimate, length: float | None
) -> dict[str, Quantity]:
    """Return both forces over the load, the part of the contact that sticks, creepage, and power."""
    pressed, load = float(solution.pressure.sum()), abs(_net_load(solution))
    by_cells = traction.errors.force * pressed / load if load else 0.0
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
    over_length = 1.0 if length is not None else 1 / grid.length
    bound = traction.power_outside_contact * abs(power.value) + traction.errors.power * over_length
    creepage = Quantity(traction.creepage.longitudinal, "1", "longitudinal creepage")
    return _of_force(solution, traction, estimate, forces) | {
        "creepage": replace(creepage, bound=0.0, reason="")
        if traction.creepage_given
        else _with_slip_bound(creepage, traction.errors.creepage, estimate),
        "frictional_power": _with_slip_bound(power, bound, estimate),
    }


def _force_over_load(solution: Solution, traction: TangentialTraction) -> list[float]:
    """Return the tangential force along x and y over the net load; 0 without a load."""
    load = _net_load(solution)
    return [float(force / load) if load else 0.0 for force in traction.shear.sum((1, 2))]


def _net_load(solution: Solution) -> float:
    """Return the sum of the pressure less that of the attraction [Pa]."""
    return float(solution.net_pressure.sum())


def _of_force(
    solution: Solution, traction: TangentialTraction, estimate: ErrorEstimate, forces: dict[str, Quantity]
) -> dict[str, Quantity]:
    """Return `forces` over the load, and the part of the contact that sticks, with its bound.

    Where bodies attract each other there is also the force over the repulsion, which alone means something under a pull.
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
    if friction is not None and not getattr(friction, "sticks", False):
        repulsive = replace(repulsive, bound=0.0, reason="")  # where it slips, the coefficient of friction
    of_load = forces if _net_load(solution) > 0 else {}
    return of_load | {"stick_fraction": stick, "traction_over_repulsion": repulsive}


def fretting_quantities(
    solution: Solution, traction: FrettingTraction, estimate: ErrorEstimate, length: float | None
) -> dict[str, Quantity]:
    """Return force and stick, energy and largest slip of the last whole cycle, else of all, and the largest shear.

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
    slipping = traction.slip_distance > SLIP_ROUNDING * np.abs(traction.rigid_displacement).max()
    sticking = replace(traction, stick=(solution.pressure > 0) & ~slipping)
    boundary = int(np.count_nonzero(_at_stick_slip_boundary(solution, sticking) & slipping))
    slip_zone_cells = np.count_nonzero(slipping) / boundary if boundary else 0.0
    energy_error = ENERGY_ERROR / slip_zone_cells**2 if slip_zone_cells > 1 else inf
    slip_error = (1 + SLIP_ZONE_MARGIN / slip_zone_cells) ** 1.5 - 1 if slip_zone_cells > 1 else inf
    reason = estimate.l1.reason or ("" if slip_zone_cells > 1 else NO_BOUND_OF_ONE_CELL)
    dissipated, largest_slip = (
        with_bound(number, replace(estimate.l1, discretisation=relative, reason=reason))
        for number, relative in ((dissipated, energy_error), (largest_slip, slip_error))
    )
    shear = np.hypot(traction.shears[:, 0], traction.shears[:, 1]).max(axis=0, initial=0.0)
    return traction_quantities(solution, traction, estimate, length) | {
        name: dissipated,
        "largest_slip": largest_slip,
        "largest_shear": largest_of(shear, "Pa", "largest tangential traction of all steps"),
    }


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


def _with_slip_bound(quantity: Quantity, bound: float, estimate: ErrorEstimate) -> Quantity:
    """Return a quantity with its `bound` if that is finite, and slip and pressure have one."""
    if estimate.slip_reason:
        return replace(quantity, reason=estimate.slip_reason)
    if not isfinite(estimate.l1.total):
        reasons = (estimate.l1.reason, *estimate.warnings, quantity.reason)
        return replace(quantity, reason=next(filter(None, reasons)))
    return replace(quantity, bound=bound, reason="") if isfinite(bound) else quantity

"""Plans: the grid and padding that a scene needs, found by solutions on coarse grids."""

from dataclasses import replace
from math import inf, isclose, prod
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from contactstudy.accuracy.half_space import beyond_half_space
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import ONE_THREAD, Device, available_bytes, checked
from contactstudy.domain.errors import DEFAULT_ERROR, Request, pressure_request
from contactstudy.domain.grid import ExactPeriodicity, Grid, Padding, Paddings
from contactstudy.domain.units import Metres, readable
from contactstudy.domain.validation import checked_errors, valid
from contactstudy.planning.cost import MEMORY_FRACTION, memory, within_memory
from contactstudy.planning.grid_requirements import CONSTANTS as GRID
from contactstudy.planning.grid_requirements import (
    flat_grid,
    grid_requirements,
    measured_length_scales,
    period_fault,
    with_random_extents,
)
from contactstudy.planning.planned import Plan
from contactstudy.planning.refinement import MOST_CELLS, FirstGrids, first_grids, with_width
from contactstudy.scene import methods
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.shape import LengthScales
from contactstudy.scene.shapes_source import left_out

if TYPE_CHECKING:
    from contactstudy.evolution.time_steps import TimeSteps
    from contactstudy.planning.transient_requirements import TransientRequirements


def plan_grid(
    scene: Scene,
    *,
    error: Request | str | None = None,
    period: float | None = None,
    grid: Grid | None = None,
    padding: Padding | Paddings | None = None,
    times: "ArrayLike | TimeSteps | None" = None,
    device: Device = ONE_THREAD,
) -> Plan:
    """Return the plan as :func:`~contactstudy.plan` does, for the same arguments, without a forecast.

    Its error and seconds are infinite. A dry scene without a grid is solved on coarse grids, to find the cells.
    """
    checked(device, "plan.device")
    if error is not None:
        error = pressure_request(checked_errors("plan.error", error))
    if grid is not None and period is not None and not isclose(period, grid.length):
        raise InvalidInput(f"plan.period is {period!r}: leave it out, since the grid has its own.")
    if times is not None and not scene.method.takes_times:
        raise InvalidInput(
            "plan.times is given, and nothing of the scene changes in time: leave it out, in a file [time_steps]."
        )
    scales = measured_length_scales(scene)
    if scales is None and grid is not None and scene.adhesion is None:
        scales = LengthScales()  # a flat on the grid that is given
    if scene.hertz is None and scales is not None and scene.lubrication is None:
        planned = _plan_of_flat(scene, scales, error, period, grid, padding, device)
        follows_adhesion = scene.adhesion is not None and scene.method is not methods.TIME_DEPENDENT
        if follows_adhesion or scene.method is methods.STATIC:
            return planned
        # imported only for scenes that change in time or roll
        from contactstudy.planning.transient_requirements import transient_requirements

        # the cells are the points of the surface under any load
        transient = transient_requirements(scene, _time_steps(times).last)
        return _with_states(planned, replace(transient, reasons=(), warnings=()))
    if scene.lubrication is not None:
        # imported only for lubricated scenes
        from contactstudy.planning.film_plan import plan_of_film

        return plan_of_film(scene, error, period, grid, padding)
    if scene.adhesion is not None:
        # imported only for scenes with adhesion
        from contactstudy.planning.adhesive_plan import plan_of_adhesion

        request = error or DEFAULT_ERROR, period, grid, padding
        if scene.method is not methods.TIME_DEPENDENT:
            return plan_of_adhesion(scene, *request)
        from contactstudy.planning.transient_requirements import transient_requirements

        transient = transient_requirements(scene, _time_steps(times).last)
        return _with_states(plan_of_adhesion(scene, *request, transient=transient), transient)
    if scene.method is not methods.STATIC:
        return _plan_time_dependent(scene, error, period, grid, padding, _time_steps(times))
    return _plan_static(scene, error, period, grid, padding, device)


def _time_steps(times: "ArrayLike | TimeSteps | None") -> "TimeSteps":
    """Return `times` as time steps."""
    from contactstudy.evolution.time_steps import TimeSteps  # imported only for scenes in time

    return TimeSteps.of(times)


def _plan_of_flat(
    scene: Scene,
    scales: LengthScales,
    error: float | None,
    period: float | None,
    grid: Grid | None,
    padding: Padding | Paddings | None,
    device: Device,
) -> Plan:
    """Plan a flat with a measured surface: its points are the cells and both axes periodic, if no others are given."""
    if period is not None:
        valid("plan.period", period, Metres)
    warnings = []
    if error is not None:
        warnings.append(
            f"plan.error is {error:.2g}: no shape is curved, so that the error is not predicted, solve, and read "
            "answer.error."
        )
    reason = "the grid is the one given"
    if grid is None:
        grid, reason = flat_grid(scales, period), "the points of the measured surface are the cells"
    padding = padding or (ExactPeriodicity(), ExactPeriodicity())
    if fault := period_fault(grid.length, (scales,)):
        warnings.append(fault)
    return Plan(
        scene=scene,
        grid=grid,
        padding=padding,
        error=inf,
        seconds=inf,
        bytes=memory(grid, padding),
        period_check=fault or f"The surface repeats over the length {readable(grid.length)}.",
        reasons=(
            f"points: no shape is curved, so that {reason}, with padding {padding!r}; the solve estimates the error.",
        ),
        warnings=tuple(warnings),
        device=device,
    )


def _plan_static(
    scene: Scene,
    error: float | None,
    period: float | None,
    grid: Grid | None,
    padding: Padding | Paddings | None,
    device: Device,
    width: float = 0.0,
) -> Plan:
    """Plan a scene that neither changes in time nor rolls, on a grid of at least this `width` [m]."""
    requirements = grid_requirements(scene, padding)
    if grid is None:  # a random surface keeps the extent of the first grid on narrower ones
        scene = with_random_extents(scene, requirements.extent(period))
        requirements = grid_requirements(scene, padding)
    padding = requirements.padding()
    limit = MEMORY_FRACTION * min(available_bytes(), device.available_bytes)
    reasons: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    first: FirstGrids | None = None
    if grid is None and error is None and requirements.point_spacing is not None:
        grid = requirements.grid_on_measured_points(period)
        reasons = (
            "points: the measured surface is solved on its own points; give an error for cells that resolve what is "
            "interpolated between them.",
        )
    if grid is None:
        error = error or DEFAULT_ERROR
        first = first_grids(scene, requirements, error, period)
        grid = within_memory(first.grid, padding, limit)
        reasons = first.reasons
        if prod(grid.cells) < 0.99 * first.required < inf:
            warnings = (_of_most_cells(error, first.required, grid, memory(grid, padding), limit),)
        if width > grid.extent[0]:
            grid = with_width(grid, requirements.width(width))
    needed = memory(grid, padding)
    if needed > limit:
        warnings = (
            f"Grid.cells is {grid.cells}: a solve needs {needed / 1e9:.3g} GB, and {_may_take(limit)}, give fewer "
            "cells.",
        )
    return Plan(
        scene=scene,
        grid=grid,
        padding=padding,
        error=inf,
        seconds=inf,
        first_grids=first,
        bytes=needed,
        period_check=requirements.period_check(grid.length),
        reasons=(*requirements.reasons(grid), *reasons),
        warnings=(
            *(requirements.warnings(grid) or filter(None, (beyond_half_space(scene),))),
            *left_out(scene.shapes, grid),
            *warnings,
        ),
        device=device,
    )


def _may_take(limit: float) -> str:
    """Return a sentence on the bytes of which a plan takes at most `limit`."""
    free = limit / MEMORY_FRACTION / 1e9
    return f"a plan may take {MEMORY_FRACTION:.0%} of the {free:.3g} GB that are free"


def _of_most_cells(
    error: float, required: float, grid: Grid, bytes_of_grid: int, limit: float
) -> str:
    """Return a sentence on an error that takes more cells than there may be."""
    needed = bytes_of_grid * required / prod(grid.cells)
    takes = f"plan.error is {error:.2g}, which takes about {required:.2g} cells"
    if needed > limit:
        return f"{takes} and {needed / 1e9:.3g} GB, and {_may_take(limit)}: give a larger error."
    return (
        f"{takes}, and at most {MOST_CELLS:,} are taken: give a larger error, and see whether the radii and the "
        "wavelengths are those that are meant."
    )


def _plan_time_dependent(
    scene: Scene,
    error: float | None,
    period: float | None,
    grid: Grid | None,
    padding: Padding | Paddings | None,
    times: "TimeSteps",
) -> Plan:
    """Plan a scene that changes in time: wide enough for its widest contact, fine enough for its narrowest."""
    # imported only for scenes that change in time
    from contactstudy.planning.transient_requirements import transient_requirements

    transient = transient_requirements(scene, times.last)
    plastic = None if scene.rolls else transient.plastic
    error_factor = plastic.error_factor if plastic else 1.0
    fraction = 1.0 if scene.rolls else GRID.cell_fraction
    discretisation_error = fraction * (error or DEFAULT_ERROR) / error_factor
    narrow_plan = _plan_static(
        transient.narrow, discretisation_error, period, grid, padding, ONE_THREAD, transient.width
    )
    return _with_states(replace(narrow_plan, scene=scene, first_grids=None), transient)


def _with_states(planned: Plan, transient: "TransientRequirements") -> Plan:
    """Return a plan with the bytes of what a contact keeps in time, and what is said of it."""
    grid, plastic = planned.grid, transient.plastic
    bytes_of_states = 8 * transient.fields * prod(grid.cells)
    reasons, warnings = transient.reasons, transient.warnings
    if plastic is not None:
        bytes_of_states += plastic.bytes(grid)
        reasons = (*reasons, plastic.reason(grid))
    if transient.least_width > grid.extent[0] * (1 + 1e-9):
        warnings = (
            *warnings,
            f"Grid.extent[0] is {readable(grid.extent[0])}: the contact, as it grows or rolls, or its plastic zone "
            f"may need {readable(transient.least_width)}, give a grid or a measured surface of that width.",
        )
    return replace(
        planned,
        bytes=planned.bytes + bytes_of_states,
        reasons=(*planned.reasons, *reasons),
        warnings=(*planned.warnings, *warnings),
    )

"""Errors of a steady film, from films on further grids."""

from dataclasses import replace
from math import inf
from operator import attrgetter

import numpy as np

from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Padding, Paddings, across_and_along, edge_fraction
from contactstudy.lubrication.lubricated_contact import FilmSolution, rise_beside_lowest
from contactstudy.lubrication.newton.pseudo_time import FilmControls
from contactstudy.lubrication.posed_film import interpolated, lubricated_scales
from contactstudy.lubrication.steady_film import solve_on
from contactstudy.scene.lubrication.lubricant import Eyring, LimitingShear, Newtonian
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.roughness import Roughness
from contactstudy.solvers.solution import Status

# The error by the inlet falls with its length^-2: it is this part of the change to twice the length. A constriction of
# few cells hides this fraction of the rise of the film beside it.
INLET_ERROR_OVER_CHANGE, HIDDEN_RISE = 4 / 3, 0.2
# Error of the least film of a roller over its change from half the cells: it lies anywhere in a cell along, near an end.
LEAST_ALONG_ROLLER = 2.0
# Least change from half the cells to all, over that from a quarter to half: it may vanish by chance.
NEXT_CHANGE = 1 / 3
# Numbers whose errors by the cells are this multiple of their change, as of numbers of any answer, by their attributes.
OTHERS = {name: name for name in ("power_loss", "rolling_resistance", "meniscus")} | {
    "thermal_reduction": "temperatures.reduction"
}
OTHER_MARGIN = 1.5
# Cells of the coarsest grid of an estimate, at least.
MIN_CELLS = 8
# A second peak of pressure is a spike if it rises from the valley before it by more than SPIKE of the highest pressure.
# Friction has no estimate where a spike adds more than SPIKE_DRAG of it, and SPIKE_GROWTH times as much as on half the
# cells.
SPIKE, SPIKE_DRAG, SPIKE_GROWTH = 0.02, 0.01, 1.5
OF_SPIKE = (
    "The peak pressure has no estimate: it may be that of the spike before the outlet, which grows with the number of "
    "cells."
)
# Where the pressure falls from one cell to the next by more than this fraction of the highest, it may hide a spike: with
# Barus' law at M = 5, L = 9 the highest pressure grows from 1.1 to 2.4 p_H on 64 to 1280 cells, all of them steeper.
STEEP_FALL = 0.3


def with_error(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    controls: FilmControls,
    start: FilmSolution | None,
) -> FilmSolution:
    """Return the contact on ``grid`` with an error estimate; each of its grids starts from a coarser one."""
    if (reason := _without_estimate(scene, grid, padding)) is not None:
        return replace(solve_on(scene, grid, padding, controls, start), estimate=_unknown(reason))
    scene = _same_surface(scene, grid)
    quarter, half, longer = _grids_of_estimate(grid)
    coarsest = solve_on(scene, quarter, padding, controls, start)
    coarse = solve_on(scene, half, padding, controls, coarsest)
    contact = solve_on(scene, grid, padding, controls, coarse)
    long = solve_on(scene, longer, padding, controls, coarse)
    return replace(contact, estimate=_compared(contact, coarsest, coarse, long))


def film_error(contact: FilmSolution) -> ErrorEstimate:
    """Return an estimate of the errors of ``contact``, from solutions on three further grids.

    These have half the cells along both axes, a quarter, and half the cells over twice the width.

    1. The error by the cells is the difference to half as many, as the observed order is 1 to 2.3. It is at least a
       third of the difference between half and a quarter, since the error may change its sign; that of the minimum film
       is at least a fifth of the rise from the lowest cell to the next.
    2. The error by the inlet is 4/3 of the change by twice its length, as it falls with the square of that.

    No estimate is finite where the film, or one on the grids with half the cells, has not converged, is not resolved, or
    is one of several. A film on a quarter of the cells that is such takes no part.
    The peak pressure has none beside a spike, whose height depends on the cells. Friction has none where a Newtonian
    stress under the spike adds ever more to it, or where the stress is above the largest known limit of a lubricant; see
    ``FilmSolution.friction_reason``.
    """
    if (reason := _without_estimate(contact.scene, contact.grid, contact.padding)) is not None:
        return _unknown(reason)
    if contact.status is Status.FILM_NOT_CONVERGED:
        return _unknown(f"The error is unknown: {contact.status}")
    controls, scene = FilmControls(), _same_surface(contact.scene, contact.grid)
    return _compared(
        contact,
        *(
            solve_on(scene, grid, contact.padding, controls, contact)
            for grid in _grids_of_estimate(contact.grid)
        ),
    )


def _same_surface(scene: Scene, grid: Grid) -> Scene:
    """Return the scene with random surfaces of the extent of ``grid``, so that they are the same on a wider grid."""
    shapes = tuple(
        replace(shape, extent=grid.extent)
        if isinstance(shape, Roughness) and shape.extent is None
        else shape
        for shape in scene.shapes
    )
    return replace(scene, shapes=shapes)


def _without_estimate(scene: Scene, grid: Grid, padding: Padding | Paddings) -> str | None:
    """Return why there is no error estimate: omitted images, or too few cells in a quarter of them; else None."""
    if across_and_along(padding)[1].window is not None:
        return (
            f"The error is unknown: padding is {padding!r}, and the error of a film by the images that it leaves out is "
            "not estimated. Give ExactPeriodicity()."
        )
    scales = lubricated_scales(scene)
    cells = grid.cells[0] // 4
    if (
        cells >= MIN_CELLS
        and grid.extent[0] / cells <= scales.relative_half_width * scales.hertz.half_width
    ):
        return None
    return (
        f"The error is unknown: its estimate needs a quarter of the {grid.cells[0]} cells across, and {cells} do not "
        "resolve the film. Give more cells across."
    )


def _unknown(reason: str) -> ErrorEstimate:
    """Return an estimate without bounds, with the ``reason``."""
    parts = ErrorParts(discretisation=inf, inlet=inf, residual=inf, reason=reason)
    return _estimate(parts, parts, parts, parts, parts)


def _estimate(
    l1: ErrorParts,
    peak_pressure: ErrorParts,
    central_film: ErrorParts,
    minimum_film: ErrorParts,
    friction: ErrorParts,
) -> ErrorEstimate:
    """Return the estimate of a film; its warnings are the reasons of its parts, each once."""
    parts = l1, peak_pressure, central_film, minimum_film, friction
    return ErrorEstimate(
        l1,
        peak_pressure,
        central_film=central_film,
        minimum_film=minimum_film,
        friction_coefficient=friction,
        warnings=tuple(dict.fromkeys(part.reason for part in parts if part.reason)),
    )


def _grids_of_estimate(grid: Grid) -> tuple[Grid, Grid, Grid]:
    """Return grids with a quarter of the cells along each axis, with half, and of those cells over twice the width."""
    (nx, ny), (width, period) = grid.cells, grid.extent
    half, along = nx // 2, max(ny // 2, 1)
    return (
        Grid((half // 2, max(along // 2, 1)), (width, period)),
        Grid((half, along), (width, period)),
        Grid((2 * half, along), (2 * width, period)),
    )


def _compared(
    contact: FilmSolution,
    coarsest: FilmSolution,
    coarse: FilmSolution,
    longer: FilmSolution,
) -> ErrorEstimate:
    """Return the errors of a contact from those on the grids of the estimate."""
    unresolved = (
        Status.FILM_NOT_CONVERGED,
        Status.FILM_BELOW_CELL,
        Status.SEVERAL_FILMS,
        Status.CONTACT_AT_EDGE,
    )
    failed = [film for film in (contact, coarse, longer) if film.status in unresolved]
    is_too_coarse = any(film.status is Status.FILM_BELOW_CELL for film in failed)
    is_other = any(film.status is not Status.FILM_BELOW_CELL for film in failed)
    residual = inf if is_other else contact.residual
    reason = ""
    if failed:
        cells = failed[0].grid.cells[0]
        reason = (
            f"With {cells} cells across a film of the estimate is no answer: {failed[0].status}"
        )

    def parts(name: str, margin: float = 1.0) -> ErrorParts:
        fine, half, quarter, long_inlet = (
            float(attrgetter(name)(film)) for film in (contact, coarse, coarsest, longer)
        )
        scale = abs(fine) or 1.0
        change = abs(fine - half)
        if coarsest.status not in unresolved:
            change = max(change, NEXT_CHANGE * abs(half - quarter))
        return ErrorParts(
            discretisation=inf if is_too_coarse else margin * change / scale,
            inlet=INLET_ERROR_OVER_CHANGE * abs(half - long_inlet) / scale,
            residual=residual,
            reason=reason,
        )

    on_coarse, on_longer = (_pressure_at(contact.grid, film) for film in (coarse, longer))
    pressure = ErrorParts(
        discretisation=inf if is_too_coarse else _l1(contact.pressure, on_coarse),
        inlet=INLET_ERROR_OVER_CHANGE * _l1(on_coarse, on_longer),
        residual=residual,
        reason=reason,
    )
    peak = parts("peak_pressure")
    if has_spike(contact.pressure) or _falls_within_a_cell(contact.pressure):
        peak = replace(peak, discretisation=inf, reason=reason or OF_SPIKE)
    friction = parts("friction")
    drag, coarse_drag = _drag_of_spike(contact), _drag_of_spike(coarse)
    # the drag of ever narrower spikes converges if the stress is limited or grows with the logarithm of the viscosity
    shear = contact.scales.lubrication.lubricant.shear
    limited = isinstance(shear, Eyring | LimitingShear)
    of_spike = abs(drag - coarse_drag) if limited else drag
    friction = replace(friction, discretisation=max(friction.by_cause["discretisation"], of_spike))
    if isinstance(shear, Newtonian) and drag > max(SPIKE_DRAG, SPIKE_GROWTH * coarse_drag):
        growing = (
            f"Friction has no estimate: the spike before the outlet adds {100 * drag:.0f} % to it, of a stress that "
            "grows with the viscosity. Give a shear law that thins, such as Eyring(), or LimitingShear()."
        )
        friction = replace(friction, discretisation=inf, reason=growing)
    if contact.friction_reason:
        friction = replace(friction, discretisation=inf, reason=contact.friction_reason)
    temperatures = contact.temperatures
    if temperatures is not None and temperatures.reason:
        friction = replace(friction, discretisation=inf, reason=temperatures.reason)
    minimum = parts("minimum_film")
    hidden = HIDDEN_RISE * rise_beside_lowest(contact.film)
    along = LEAST_ALONG_ROLLER if contact.scene.roller_length is not None else 1.0
    minimum = replace(
        minimum, discretisation=max(along * minimum.by_cause["discretisation"], hidden)
    )
    further = {
        name: parts(attribute, OTHER_MARGIN)
        for name, attribute in OTHERS.items()
        if name != "thermal_reduction" or temperatures is not None
    }
    estimate = _estimate(pressure, peak, parts("central_film"), minimum, friction)
    estimate = replace(estimate, numbers=further)
    if temperatures is not None:
        flash, mean = (
            replace(parts(name), discretisation=inf, reason=temperatures.reason)
            if temperatures.reason
            else parts(name)
            for name in ("flash_temperature", "film_temperature")
        )
        estimate = replace(estimate, flash_temperature=flash, film_temperature=mean)
    if contact.contact_pressure is None:
        return estimate
    load, area = parts("contact_load_fraction"), parts("contact_area_fraction")
    counted = max(area.by_cause["discretisation"], edge_fraction(contact.contact_pressure > 0))
    area = replace(area, discretisation=counted)
    boundary = contact.scales.lubrication.boundary
    assert boundary is not None
    lowest = contact.minimum_film * (1 - minimum.total)
    if not contact.contact_pressure.any() and lowest <= boundary.film:
        untouched = (
            "The fractions of asperities have no estimate: no cell touches, and the minimum film is within its error of "
            "the boundary film. Give more cells."
        )
        load, area = (
            replace(one, discretisation=inf, reason=reason or untouched) for one in (load, area)
        )
    return replace(estimate, contact_load_fraction=load, contact_area_fraction=area)


def has_spike(pressure: Array) -> bool:
    """Return whether the mean pressure over the length (x, y) has a second peak downstream of a valley."""
    return _valley(pressure)[1] > SPIKE * float(pressure.mean(axis=1).max())


def _falls_within_a_cell(pressure: Array) -> bool:
    """Return whether the pressure (x, y) falls so steeply between cells that it may hide a spike."""
    return bool((pressure[:-1] - pressure[1:]).max() > STEEP_FALL * pressure.max())


def _valley(pressure: Array) -> tuple[int, float]:
    """Return the index across of the deepest valley of the pressure, averaged over the length, and its depth."""
    mean = pressure.mean(axis=1)
    falls = np.maximum.accumulate(mean) - mean
    rises = np.maximum.accumulate(mean[::-1])[::-1] - mean
    depth = np.minimum(falls, rises)
    return int(depth.argmax()), float(depth.max())


def _drag_of_spike(contact: FilmSolution) -> float:
    """Return the part of the friction that the shear stress of a spike adds: what exceeds that in the valley."""
    stress = np.abs(contact.shear.mean(axis=1))
    if not (has_spike(contact.pressure) and stress.any()):
        return 0.0
    after = stress[_valley(contact.pressure)[0] :]
    return float(np.clip(after - after[0], 0, None).sum() / stress.sum())


def _pressure_at(grid: Grid, contact: FilmSolution) -> Array:
    """Return the pressure of ``contact`` (x, y) at the cells of another grid, linear between its own."""
    return interpolated(contact.pressure, contact.grid, grid.x, grid.y)


def _l1(pressure: Array, reference: Array) -> float:
    return float(np.abs(pressure - reference).sum() / np.abs(pressure).sum())

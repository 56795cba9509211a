"""Errors of a steady film by the rule of all numbers: their changes to fewer cells, and to twice the width."""

from dataclasses import replace
from itertools import pairwise
from math import inf
from operator import attrgetter
from typing import Any

import numpy as np

from contactstudy.domain.errors import AREA_FLOOR, FLOOR, INLET, MARGIN, ErrorEstimate, ErrorParts, largest_change
from contactstudy.domain.grid import Array, Grid, Padding, Paddings, across_and_along, edge_fraction
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.newton.pseudo_time import FilmControls
from contactstudy.lubrication.posed_film import interpolated, lubricated_scales
from contactstudy.lubrication.steady_film import solve_on
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.shape import shortest_wavelengths, unresolved, with_extent_of
from contactstudy.solvers.solution import Status

# Numbers of every film.
NUMBERS = (
    "peak_pressure",
    "central_film",
    "minimum_film",
    "friction_coefficient",
    "power_loss",
    "rolling_resistance",
    "meniscus",
)
# Numbers of a film with temperatures.
OF_HEAT = "flash_temperature", "film_temperature", "thermal_reduction", "heated_film"
# Numbers that are no fields of ErrorEstimate.
FURTHER = "power_loss", "rolling_resistance", "meniscus", "thermal_reduction", "heated_film"
# Attributes of a film for numbers of other names.
ATTRIBUTES = {"friction_coefficient": "friction", "thermal_reduction": "temperatures.reduction"}
# A number that changes by more than this from half the cells, and by more than from a quarter to half, may grow with the
# cells, as does the friction of a Newtonian stress under a spike. It takes a film on a quarter of the cells to tell.
NOTICEABLE = 0.02
GROWS = (
    "No bound: from half the cells it changes by {:.2g} %, more than from a quarter to half, so that it may grow with "
    "them, as below a spike of the pressure. Give more cells, or a shear law that thins, such as Eyring()."
)
# Outcomes without a film to compare with.
NO_FILM = (Status.FILM_NOT_CONVERGED, Status.FILM_BELOW_CELL, Status.SEVERAL_FILMS, Status.CONTACT_AT_EDGE)
# Cells of the coarsest grid of an estimate, at least.
MIN_CELLS = 8
# A second peak of pressure is a spike if it rises from the valley before it by more than SPIKE of the highest pressure.
SPIKE = 0.02
OF_SPIKE = (
    "The peak pressure has no estimate: it may be that of the spike before the outlet, which grows with the number of "
    "cells."
)
# Where the pressure falls from one cell to the next by more than this fraction of the highest, it may hide a spike: with
# Barus' law at M = 5, L = 9 the highest pressure grows from 1.1 to 2.4 p_H on 64 to 1280 cells, all of them steeper.
STEEP_FALL = 0.3


def film_error(contact: FilmSolution, controls: FilmControls = FilmControls()) -> ErrorEstimate:  # noqa: B008 (frozen)
    """Return an estimate of the errors of ``contact``, from solutions on three further grids.

    These have half the cells along both axes, a quarter, and half the cells over twice the width. The error of each
    number by the cells follows from its changes by the rule of all numbers (:mod:`contactstudy.domain.errors`); that by
    the inlet is 4/3 of the change by twice its length, as it falls with the square of that.

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
    scene = replace(contact.scene, shapes=with_extent_of(contact.scene.shapes, contact.grid))
    films = (solve_on(scene, grid, contact.padding, controls, contact) for grid in _grids_of_estimate(contact.grid))
    return _compared(contact, *films)


def _without_estimate(scene: Scene, grid: Grid, padding: Padding | Paddings) -> str | None:
    """Return why there is no error estimate: omitted images, or too few cells; else None."""
    if across_and_along(padding)[1].window is not None:
        return (
            f"The error is unknown: padding is {padding!r}, and the error of a film by the images that it leaves out is "
            "not estimated. Give ExactPeriodicity()."
        )
    if fault := unresolved(shortest_wavelengths(scene.shapes), grid):
        return f"The error is unknown: {fault}"
    scales = lubricated_scales(scene)
    cells = grid.cells[0] // 4
    if cells >= MIN_CELLS and grid.extent[0] / cells <= scales.relative_half_width * scales.hertz.half_width:
        return None
    return (
        f"The error is unknown: its estimate needs a quarter of the {grid.cells[0]} cells across, and {cells} do not "
        "resolve the film. Give more cells across."
    )


def _unknown(reason: str) -> ErrorEstimate:
    """Return an estimate without bounds, with the ``reason``."""
    parts = ErrorParts(discretisation=inf, inlet=inf, residual=inf, reason=reason)
    every: Any = {name: parts for name in NUMBERS if name not in FURTHER}
    return ErrorEstimate(parts, **every, warnings=(reason,))


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
    contact: FilmSolution, coarsest: FilmSolution, coarse: FilmSolution, longer: FilmSolution
) -> ErrorEstimate:
    """Return the errors of a contact from those on the grids of the estimate."""
    failed = [film for film in (contact, coarse, longer) if film.status in NO_FILM]
    is_too_coarse = any(film.status is Status.FILM_BELOW_CELL for film in failed)
    is_other = any(film.status is not Status.FILM_BELOW_CELL for film in failed)
    reason = ""
    if failed:
        cells = failed[0].grid.cells[0]
        reason = f"With {cells} cells across a film of the estimate is no answer: {failed[0].status}"
    nested = [contact, coarse] if coarsest.status in NO_FILM else [contact, coarse, coarsest]

    def parts(cells: float, inlet: float, why: str = "") -> ErrorParts:
        """Return the error by changes to fewer cells and to a longer inlet; infinite where there is a reason `why`."""
        return ErrorParts(
            discretisation=inf if is_too_coarse or why else MARGIN * cells,
            inlet=INLET * inlet,
            residual=inf if is_other else contact.residual,
            reason=reason or why,
        )

    x, y = contact.grid.x, contact.grid.y
    pressures = [interpolated(film.pressure, film.grid, x, y) for film in (*nested, longer)]
    of_pressure = largest_change([_l1(*pair) for pair in pairwise(pressures[:-1])])
    l1 = parts(of_pressure, _l1(pressures[1], pressures[-1]))

    def of_number(name: str, why: str = "", least: float = 0.0) -> ErrorParts:
        """Return the error of a number by its relative changes, the change to fewer cells `least` at the least."""
        value = attrgetter(ATTRIBUTES.get(name, name))
        values = [float(value(film)) for film in nested]
        scale = abs(values[0]) or 1.0
        changes = [abs(fine - half) / scale for fine, half in pairwise(values)]
        if not why and changes[0] > max(NOTICEABLE, changes[-1]):
            why = GROWS.format(100 * changes[0])
        inlet = abs(values[1] - float(value(longer))) / scale
        floor = FLOOR * of_pressure if values[0] else 0.0
        return parts(max(largest_change(changes), floor, least), inlet, why)

    reasons = _reasons(contact)
    names = [*NUMBERS, *(OF_HEAT if contact.temperatures is not None else ())]
    errors = {name: of_number(name, reasons.get(name, "")) for name in names}
    if contact.contact_pressure is not None:
        untouched = _untouched_reason(contact, errors["minimum_film"])
        edge = AREA_FLOOR * edge_fraction(contact.contact_pressure > 0)
        errors["contact_load_fraction"] = of_number("contact_load_fraction", untouched)
        errors["contact_area_ratio"] = of_number("contact_area_ratio", untouched, edge)
    said = dict.fromkeys(part.reason for part in (l1, *errors.values()) if part.reason)
    numbers = {name: errors.pop(name) for name in names if name in FURTHER}
    fields: Any = errors
    return ErrorEstimate(l1, **fields, numbers=numbers, warnings=tuple(said))


def _reasons(contact: FilmSolution) -> dict[str, str]:
    """Return why numbers have no estimate, by name; empty where they have one."""
    of_heat = "" if contact.temperatures is None else contact.temperatures.reason
    of_friction = of_heat or contact.friction_reason
    of_spike = has_spike(contact.pressure) or _falls_within_a_cell(contact.pressure)
    return {
        "peak_pressure": OF_SPIKE if of_spike else "",
        "friction_coefficient": of_friction,
        "power_loss": of_friction if contact.scales.lubrication.slide_roll_ratio else "",
        **dict.fromkeys(OF_HEAT, of_heat),
    }


def _untouched_reason(contact: FilmSolution, minimum_film: ErrorParts) -> str:
    """Return why the fractions of asperities have no estimate; empty where they have one."""
    boundary = contact.scales.lubrication.boundary
    assert boundary is not None
    assert contact.contact_pressure is not None
    lowest = contact.minimum_film * (1 - minimum_film.total)
    if contact.contact_pressure.any() or lowest > boundary.film:
        return ""
    return (
        "The fractions of asperities have no estimate: no cell touches, and the minimum film is within its error of "
        "the boundary film. Give more cells."
    )


def has_spike(pressure: Array) -> bool:
    """Return whether the mean pressure over the length (x, y) has a second peak downstream of a valley."""
    mean = pressure.mean(axis=1)
    falls = np.maximum.accumulate(mean) - mean
    rises = np.maximum.accumulate(mean[::-1])[::-1] - mean
    return bool(np.minimum(falls, rises).max() > SPIKE * mean.max())


def _falls_within_a_cell(pressure: Array) -> bool:
    """Return whether the pressure (x, y) falls so steeply between cells that it may hide a spike."""
    return bool((pressure[:-1] - pressure[1:]).max() > STEEP_FALL * pressure.max())


def _l1(pressure: Array, other: Array) -> float:
    """Return the L1 norm of the difference of two pressures (x, y) over that of the first."""
    return float(np.abs(pressure - other).sum() / np.abs(pressure).sum())

"""Quantities recorded of every contact of a sweep."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf, isinf, pi, prod

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.coarser import contact_perimeter, touching_fraction
from contactstudy.io.dataset import known_or_nan, labelled
from contactstudy.stiffness import contact_stiffness
from studies.advice.reference_error import pressure_error
from studies.model.case import Answer, Case, dimensionless, error_estimates
from studies.model.plain_text import one_line

# Quantities that a sweep varies as an axis.
NAMED_BY_AXES = ("load_per_length", "total_load")


def measures(case: Case, answer: Answer) -> Mapping[str, xr.Variable]:
    """Return the quantities of an answer with their bounds, its error estimates, and further ones of a dry contact."""
    if answer.status.is_failure:  # a failure has no numbers
        raise cs.NotDefined(f"{answer.status.name}: {answer.status}")
    measured: dict[str, xr.Variable] = {}
    recorded = {name: number for name, number in answer.quantities.items() if name not in NAMED_BY_AXES}
    for name, quantity in recorded.items():
        unit, label = quantity.unit, quantity.label
        measured[name] = labelled((), quantity.value, unit, label)
        if quantity.is_formula:
            continue
        label = f"bound of the error: {label}"
        measured[f"{name}_bound"] = labelled((), known_or_nan(quantity.bound), unit, label)
    reasons = (
        f"{name}: {number.reason}" for name, number in recorded.items() if isinf(number.bound) and not number.is_formula
    )
    about = {"long_name": "numbers without a bound, and why"}
    measured["without_bound"] = xr.Variable((), one_line(" ".join(reasons)), about)
    about = {"long_name": "warnings that are no reason of a number without a bound"}
    measured["warnings"] = xr.Variable((), one_line(" ".join(answer.warnings)), about)
    if answer.met is not None:
        missed = (name for name, number in answer.judged.items() if 1 < number.ratio < inf)
        about = {"long_name": "numbers whose bounds are above the requested accuracy"}
        measured["above_request"] = xr.Variable((), " ".join(missed), about)
        description = "1 if the bound meets the requested accuracy"
        measured["accuracy_met"] = dimensionless(float(answer.met), description)
        if not answer.met:
            about = {"long_name": "requested and reached accuracy, and what limits it"}
            measured["accuracy_missed"] = xr.Variable((), one_line(answer.accuracy), about)
    if isinstance(answer, cs.Contact):
        measured |= _of_contact(case, answer)
    return measured | error_estimates(answer.error) | dict(pressure_error(case, answer))


def _of_contact(case: Case, contact: cs.Contact) -> dict[str, xr.Variable]:
    """Return load, area over Hertz's, perimeter and stiffness of a dry contact."""
    grid, scene = contact.grid, case.scene
    touching = contact.pressure > 0
    area_error = contact.quantities["contact_area"].relative_bound
    fraction = touching_fraction(contact)
    area = fraction * float(np.prod(grid.extent))
    perimeter = contact_perimeter(touching, grid, contact.problem.paddings)
    quantity = contact.quantities.get("load_per_length") or contact.quantities["total_load"]
    load = quantity.value
    is_given = contact.problem.control.approach is not None
    # a roller carries it on its own length, whatever that of the grid
    length = contact.loaded_length
    measured = {
        "load": labelled((), load, quantity.unit, quantity.label),
        "contact_fraction": dimensionless(fraction, "fraction of the grid in contact"),
        "contact_perimeter": labelled(
            (), perimeter, "m", "contact perimeter on the grid", description="edges of cells at which contact ends"
        ),
    }  # fmt: skip
    if (hertz := scene.hertz) is not None:
        # that of a scene whose approach is given is under an estimated load
        hertz = replace(hertz, load_per_length=load) if is_given and load > 0 else hertz
        ratio = area / (2 * hertz.half_width * length)
        if scene.ellipse is not None:
            ratio = area / (pi * prod(scene.ellipse.semi_axes))
        measured["contact_area_over_hertz"] = dimensionless(ratio, "contact area over Hertz's")
    errors = dict.fromkeys(("contact_fraction", "contact_area_over_hertz"), area_error)
    if contact.pressure.any() or contact.adhesion is not None:
        tangent_stiffness = contact_stiffness(contact)
        what = {"description": f"d load / d approach{tangent_stiffness.detail}"}
        measured["stiffness"] = labelled(
            (), tangent_stiffness.value, tangent_stiffness.unit, tangent_stiffness.label, **what
        )
        errors["stiffness"] = tangent_stiffness.relative_bound
    for name, error in errors.items():
        if (value := measured.get(name)) is not None:
            label = f"bound of the error: {value.attrs['long_name']}"
            bound = known_or_nan(error * float(value) if error < inf else inf)
            measured[f"{name}_bound"] = labelled((), bound, value.attrs["units"], label)
    return measured

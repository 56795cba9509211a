"""Quantities recorded of every contact of a sweep."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf, isinf, pi, prod
from typing import Any

import numpy as np
import xarray as xr
from scipy.sparse.linalg import LinearOperator, minres

import contactstudy as cs
from contactstudy.accuracy.discretisation.cells import contact_perimeter
from contactstudy.accuracy.discretisation.coarser import touching_fraction
from contactstudy.domain.fields import Array, inner
from contactstudy.io.dataset import known_or_nan, labelled
from contactstudy.solvers.conjugate_gradients import conjugate_gradients
from studies.advice.reference_error import pressure_error
from studies.model.case import Answer, Case, dimensionless, error_estimates
from studies.model.plain_text import one_line

# Relative residual, of whose square the error of the stiffness is a fraction, and the largest number of operator
# applications.
RTOL, MAXITER = 3e-2, 60
# The same with adhesion, relative to the norm of the indefinite operator.
ADHESIVE_RTOL, ADHESIVE_MAXITER = 1e-10, 1000
# Factor on a range that was chosen for the grid: its cohesive zone then has 24 cells.
LONGER_RANGE = 2.0
# Bound of a stiffness over the error that the law of a line contact gives for its area: by 60 contacts at random,
# smooth, wavy, rough, coated or as hard as their peak, the largest true error was 0.99 of that.
STIFFNESS_MARGIN = 1.25
# Quantities that a sweep varies as an axis.
NAMED_BY_AXES = ("load_per_length", "total_load")


def normal_stiffness(solution: cs.Contact) -> float:
    """Return the normal stiffness d load / d approach [N/m per m of length], with the cells in contact fixed.

    It is the inverse of the energy of the pressure increment that carries a unit of load and displaces all cells in
    contact equally. The increment follows from conjugate gradients among pressures without a load, to which a
    constant added to the displacement does not matter. Cells at the hardness carry no increment. The result is nan if
    no cell carries one. With adhesion see :func:`_adhesive_stiffness`.
    """
    problem = solution.problem
    active = (problem.constraint.active(solution.pressure) > 0).astype(np.float64)
    if solution.adhesion is not None:
        return _adhesive_stiffness(solution, active)
    count = np.count_nonzero(active)
    if not count:
        return float("nan")
    extension = problem.operator.approximate_inverse().extension(active)

    def deviation(field: Array) -> Array:
        """Return a field less its mean over the active set, and zero elsewhere."""
        return np.asarray((field - inner(field, active) / count) * active)

    uniform = active / count
    displacement = problem.operator(uniform)
    increment = uniform + conjugate_gradients(
        lambda pressure: deviation(problem.operator(pressure)),
        lambda residual: deviation(extension.pressure(extension(residual))),
        inner, -deviation(displacement), RTOL, MAXITER,
    )  # fmt: skip
    # the energy of a unit of load [m per unit of summed pressure]: the residual is orthogonal to the correction
    compliance = inner(increment, displacement)
    return float(problem.grid.cell_area / problem.grid.length / compliance)


def _adhesive_stiffness(contact: cs.Contact, active: Array) -> float:
    """Return the normal stiffness [N/m per m of length] of an adhesive contact, whose `active` cells (x, y) stay it.

    Beside the contact the attraction rises by s = -d attraction / d gap as the gap closes: the increment q of the net
    pressure under a unit of approach fulfils ``K q = 1`` in contact and ``K q - q / s = 1`` beside it. It is symmetric
    in ``q / root(s)``, and indefinite: at pull-off the stiffness is zero, and where a given approach loses stability it
    is infinite. Where the grid chose the range, six cells in the cohesive zone hold the edge between two cells for a
    while, where the stiffness is up to a sixth too high: the contact is solved once more with a longer range.
    """
    if contact.regularised:
        contact = _with_longer_range(contact)
    problem, traction = contact.problem, contact.adhesion
    assert traction is not None
    assert contact.scene is not None
    assert contact.scene.adhesion is not None
    solver: Any = problem.adhesion
    law = getattr(solver, "solver", solver).law  # a search for the pull-off load has a solver
    slope = np.where(
        contact.pressure > 0, active / problem.operator.self_compliance, law.slope(contact.gap)
    )
    root, count = np.sqrt(slope), slope.size

    def difference(values: Array) -> Array:
        scaled = values.reshape(root.shape)
        return np.asarray(
            root * problem.operator(root * scaled) - (contact.pressure == 0) * scaled
        ).ravel()

    matrix = LinearOperator((count, count), difference, dtype=np.float64)
    increment, failed = minres(matrix, root.ravel(), rtol=ADHESIVE_RTOL, maxiter=ADHESIVE_MAXITER)
    total = float("nan") if failed else float(root.ravel() @ increment)
    return total * problem.grid.cell_area / problem.grid.length


def _with_longer_range(contact: cs.Contact) -> cs.Contact:
    """Return an adhesive contact with a multiple of its range, or as it is where there is no such state."""
    scene, traction = contact.scene, contact.adhesion
    assert scene is not None
    assert scene.adhesion is not None
    assert traction is not None
    assert contact.padding is not None
    if isinstance(scene.load, cs.PullOff):
        return contact
    adhesion = replace(scene.adhesion, range=LONGER_RANGE * traction.range)
    longer = replace(scene, adhesion=adhesion).problem(contact.grid, contact.padding)
    found = cs.solve(longer, start=contact)
    return found if found.status.has_converged else contact


def _stiffness_error(contact: cs.Contact, stiffness: float) -> float:
    """Return the bound of the relative error of a normal stiffness k, by the cells at the border of the contact.

    Of a line contact ``d ln k / d ln a`` is ``2 k / (pi E*)``, where a is the half-width; elsewhere 1 at most. Cells at
    the hardness, which carry no increment, have a border of their own. With adhesion none is known.
    """
    assert contact.scene is not None
    touching = np.count_nonzero(contact.pressure)
    active = np.count_nonzero(contact.problem.constraint.active(contact.pressure))
    if not active or contact.adhesion is not None:
        return inf
    borders = 2 * touching / active - 1
    growth = max(2 * stiffness / (pi * contact.scene.contact_modulus), 1.0)
    touching_cells = contact.pressure > 0
    perimeter = contact_perimeter(touching_cells, contact.grid, contact.problem.paddings)
    # the stiffness is that of whole cells, of which half may lie beyond an edge
    of_cells = perimeter * contact.grid.cell_size[0] / 2 / (touching * contact.grid.cell_area)
    area_error = contact.quantities["contact_area"].relative_bound + of_cells
    return STIFFNESS_MARGIN * growth * borders * area_error


def measures(case: Case, answer: Answer) -> Mapping[str, xr.Variable]:
    """Return the quantities of an answer with their bounds, its error estimates, and further ones of a dry contact."""
    if answer.status.is_failure:  # which has no numbers
        raise cs.NotDefined(f"{answer.status.name}: {answer.status}")
    measured: dict[str, xr.Variable] = {}
    recorded = {name: one for name, one in answer.quantities.items() if name not in NAMED_BY_AXES}
    for name, quantity in recorded.items():
        unit, label = quantity.unit, quantity.label
        measured[name] = labelled((), quantity.value, unit, label)
        if quantity.is_formula:
            continue
        label = f"bound of the error: {label}"
        measured[f"{name}_bound"] = labelled((), known_or_nan(quantity.bound), unit, label)
    reasons = (
        f"{name}: {one.reason}"
        for name, one in recorded.items()
        if isinf(one.bound) and not one.is_formula
    )
    about = {"long_name": "numbers without a bound, and why"}
    measured["without_bound"] = xr.Variable((), one_line(" ".join(reasons)), about)
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
        is_point = scene.ellipse is not None
        stiffness = normal_stiffness(contact) * grid.length / (1.0 if is_point else length)
        what = {"description": "d load / d approach"}
        measured["stiffness"] = labelled(
            (), stiffness, "N m-1" if is_point else "N m-2", "normal stiffness", **what
        )
        errors["stiffness"] = _stiffness_error(contact, stiffness)
    for name, error in errors.items():
        if (value := measured.get(name)) is not None:
            label = f"bound of the error: {value.attrs['long_name']}"
            bound = known_or_nan(error * float(value) if error < inf else inf)
            measured[f"{name}_bound"] = labelled((), bound, value.attrs["units"], label)
    return measured

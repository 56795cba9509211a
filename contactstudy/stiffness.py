"""Normal stiffness of a dry contact, and the bound of its error; approach and stiffness between distant points.

The stiffness is that of the contact as it was solved, under a small change of the load. Both are computed on demand
alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import exp, inf, isclose, log, pi
from typing import Annotated, Any, cast

import numpy as np
from scipy.sparse.linalg import LinearOperator, minres

from contactstudy.accuracy.coarser import contact_perimeter
from contactstudy.answers.contact import Contact
from contactstudy.domain.grid import Array, inner, is_free
from contactstudy.domain.validation import CURVED, InvalidInput, Metres, NotDefined, readable, valid
from contactstudy.io.quantities.contact_quantities import approach_datum, datum_text
from contactstudy.io.quantities.quantity import Quantity
from contactstudy.scene.loads import PullOff
from contactstudy.scene.solids.bodies import Body
from contactstudy.scene.solids.coated import CoatedHalfSpace
from contactstudy.solvers.conjugate_gradients import contact_tangent
from contactstudy.solving import solve

# Relative residual with adhesion, over the norm of the indefinite operator, and the most applications of that. With
# 1e-8 the error is up to 0.8 % near pull-off, and fewer than 100 applications were needed.
ADHESIVE_RTOL, ADHESIVE_MAXITER = 1e-10, 1000
# Factor on a range that was chosen for the grid: the zone grows with the square of the range, to 2^2 x 6 cells.
LONGER_RANGE = 2.0
# Bound of a stiffness over the error that the law of a line contact gives for its area. Of 60 random contacts, smooth,
# wavy, rough, coated or as hard as their peak, the largest true error was 0.99 of that.
STIFFNESS_MARGIN = 1.25


def normal_stiffness(solution: Contact) -> float:
    """Return the normal stiffness d load / d approach [N/m per m of length], with the cells in contact fixed.

    It is the inverse of the energy of the pressure increment that carries a unit of load and displaces all cells in
    contact equally. That is a uniform one less the tangent operator of its displacement. Cells at the hardness carry no
    increment. The result is nan if no cell carries one. With adhesion see :func:`_adhesive_stiffness`.
    """
    if solution.adhesion is not None:
        return _adhesive_stiffness(solution)
    problem = solution.problem
    active = (problem.constraint.active(solution.pressure) > 0).astype(np.float64)
    if not active.any():
        return float("nan")
    uniform = active / np.count_nonzero(active)
    displacement = problem.operator(uniform)
    increment = uniform - contact_tangent(solution)(displacement)
    # the energy of a unit of load [m per unit of summed pressure]: the residual is orthogonal to the correction
    compliance = inner(increment, displacement)
    return float(problem.grid.cell_area / problem.grid.length / compliance)


def _adhesive_stiffness(contact: Contact) -> float:
    """Return the normal stiffness [N/m per m of length] of an adhesive contact, with the cells in contact fixed.

    Beside the contact the attraction rises by s = -d attraction / d gap as the gap closes. With the operator K from
    pressure to displacement, the increment q of the net pressure under a unit of approach fulfils ``K q = 1`` in
    contact and ``K q - q / s = 1`` beside it. The system is symmetric in ``q / root(s)``, and indefinite: at pull-off
    the stiffness is zero, and where a given approach loses stability it is infinite. Where the range was chosen for the
    grid, with six cells in the cohesive zone, the edge stays trapped between two cells as the load changes. The
    stiffness would be up to a sixth too high: the contact is solved once more with a longer range.
    """
    scene: Any = contact.scene
    traction: Any = contact.adhesion
    if traction.regularised and not isinstance(scene.load, PullOff):
        adhesion = replace(scene.adhesion, range=LONGER_RANGE * traction.range)
        problem = replace(scene, adhesion=adhesion).problem(contact.grid, contact.padding)
        answer = cast(Contact, solve(problem, start=contact))
        contact = answer if answer.status.has_converged else contact
    problem = contact.problem
    solver: Any = problem.adhesion
    law = getattr(solver, "solver", solver).law  # a search for the pull-off load has a solver
    # in contact any value gives K q = 1: it only scales the unknown; the slope of a law is at least 0
    in_contact = problem.constraint.active(contact.pressure) / problem.operator.self_compliance
    slope = np.where(contact.pressure > 0, in_contact, law.slope(contact.gap))
    root, count = np.sqrt(slope), slope.size

    def difference(values: Array) -> Array:
        """Return the left side of the system for the unknown ``q / root(s)``, both (cells,)."""
        scaled = values.reshape(root.shape)
        return np.asarray(root * problem.operator(root * scaled) - (contact.pressure == 0) * scaled).ravel()

    matrix = LinearOperator((count, count), difference, dtype=np.float64)
    increment, failed = minres(matrix, root.ravel(), rtol=ADHESIVE_RTOL, maxiter=ADHESIVE_MAXITER)
    total = float("nan") if failed else float(root.ravel() @ increment)
    return total * problem.grid.cell_area / problem.grid.length


def stiffness_error(contact: Contact, stiffness: float) -> float:
    """Return the bound of the relative error of a normal stiffness k, by the cells at the border of the contact.

    Of a line contact ``1 / k = 2 ln(c D / a) / (pi E*)``, with the half-width a, the distance D of the datum from which
    the approach counts, a number c and the contact modulus E*. Hence ``d ln k / d ln a = 2 k / (pi E*)``; elsewhere it
    is 1 at most. Cells at the hardness, which carry no increment, have a border of their own. With adhesion none is
    known.
    """
    assert contact.scene is not None
    touching = np.count_nonzero(contact.pressure)
    active = np.count_nonzero(contact.problem.constraint.active(contact.pressure))
    if not active or contact.adhesion is not None:
        return inf
    # 1, and twice the cells at the hardness over the others: they have a border too
    borders = 2 * touching / active - 1
    growth = max(2 * stiffness / (pi * contact.scene.contact_modulus), 1.0)
    perimeter = contact_perimeter(contact.pressure > 0, contact.grid, contact.problem.paddings)
    # the stiffness is that of whole cells, of which half may lie beyond an edge
    of_cells = perimeter * contact.grid.cell_size[0] / 2 / (touching * contact.grid.cell_area)
    area_error = contact.quantities["contact_area"].relative_bound + of_cells
    return STIFFNESS_MARGIN * growth * borders * area_error


def contact_stiffness(contact: Contact) -> Quantity:
    """Return the normal stiffness d load / d approach of a dry contact with its bound: [N/m], of a line contact [N/m^2].

    It counts from where the approach does, which the label says; see :func:`distant_approach` for that between the axes
    of cylinders. It is computed with the cells in contact fixed.

    Raises :class:`~contactstudy.NotDefined` for a contact without a scene, and of bodies that do not touch.
    """
    scene = contact.scene
    if scene is None or not (contact.pressure.any() or contact.adhesion is not None):
        raise NotDefined("The stiffness is not defined: the contact has no scene, or bears no load.")
    is_point = scene.ellipse is not None
    # a roller carries its load on its own length, whatever that of the grid
    per_grid = normal_stiffness(contact)
    value = per_grid * contact.grid.length / (1.0 if is_point else contact.loaded_length)
    detail = datum_text(contact)
    error = stiffness_error(contact, per_grid)
    reason = "" if error < inf else "No bound: none is known with adhesion, or where no cell carries more."
    unit = "N m-1" if is_point else "N m-2"
    return Quantity(value, unit, "normal stiffness", error * abs(value) if error < inf else inf, reason, detail=detail)


@dataclass(frozen=True)
class DistantApproach:
    """Approach [m] of two points, one in each body of a line contact, and the stiffness [N/m per m] between them."""

    approach: Quantity
    stiffness: Quantity


def distant_approach(
    contact: Contact, radii: tuple[float | str, float | str], depth: float | str | None = None
) -> DistantApproach:
    """Return approach and stiffness of a line contact between the axes of its cylinders, or a point below a flat body.

    The compression of a body is ``c P / pi`` times a factor (Johnson 1985, sect. 5.6), with its plane-strain compliance
    c. The factor is ``2 ln(4 R / a) - 1`` of a cylinder down to its axis, if it is loaded opposite to the contact, and
    ``2 ln(2 d / a) - nu / (1 - nu)`` of a flat body down to a depth d. Both differ from the approach of half-spaces by
    a constant times the load, whatever the surfaces are like. Here P is the load per length, R the radius, a the
    half-width and nu Poisson's ratio. On a roller that ends, the constant is that of its pressure, at mid-length. In a
    coated body c changes with the distance; the change is part of the bound.

    Parameters
    ----------
    contact
        A line contact at rest.
    radii
        Radius of each body [m] across the contact; infinite or negative of a flat or a hollow one.
    depth
        Depth [m] of the point in a flat or hollow body.

    Raises
    ------
    InvalidInput
        For radii that are not those of the scene, and a flat body without a depth.
    NotDefined
        For a point contact, and for one with images across.
    """
    scene, grid = contact.scene, contact.grid
    curved = Annotated[Metres, CURVED]
    given = valid("radii", radii, tuple[curved, curved])
    datum = approach_datum(contact)
    paddings = contact.problem.paddings
    if scene is None or scene.ellipse is not None or paddings is None or not is_free(paddings[0]):
        raise NotDefined("The approach of axes is not defined: the contact is no line contact that is free across.")
    if not datum and not is_free(paddings[1]):
        raise NotDefined(
            "The approach of axes is not defined: images are left out, give ExactPeriodicity along the length."
        )
    curvature = sum(1 / radius for radius in given)
    if scene.radius and not isclose(curvature, 1 / scene.radius, rel_tol=1e-6):
        raise InvalidInput(
            f"radii are {radii!r}, which make an equivalent radius of {readable(1 / curvature) if curvature else inf}, "
            f"and the scene has {readable(scene.radius)}: give the radii of both bodies across, such as (0.01, inf)."
        )
    per_length = float(contact.net_pressure.sum()) * grid.cell_area / contact.loaded_length
    # by how much the approach is less than that of half-spaces, over the load per length [1/Pa], and the bound of that
    shift, shift_bound, places = 0.0, 0.0, []
    for number, (solid, radius) in enumerate(zip(scene.solids, given, strict=True)):
        material: Any = getattr(solid, "substrate", solid)
        # the distance D on the surface from which the approach of a half-space, 2 ln(2 D / a) + 1, equals the body's
        if 0 < radius < inf:
            distance = 2 * radius / exp(1)
            places.append("the axis")
        elif depth is None:
            raise InvalidInput(
                f"radii[{number}] is {radius!r}, of a body without an axis: give the depth of a point in it."
            )
        else:
            below = valid("depth", depth, Metres)
            distance = below * exp(-1 / (2 * (1 - material.poisson_ratio)))
            places.append(f"a depth of {readable(below)}")
        of_body, change = _distant_displacement(contact, solid, distance, datum)
        shift, shift_bound = shift + of_body, shift_bound + change
    detail = f", between {' and '.join(places)}"
    near, stiffness = contact.quantities["approach"], contact_stiffness(contact)
    at_axes = near.bound + shift_bound * abs(per_length)
    approach = replace(near, value=near.value - shift * per_length, bound=at_axes, detail=detail)
    value = 1 / (1 / stiffness.value - shift)
    bound = stiffness.bound * (value / stiffness.value) ** 2 + shift_bound * value**2
    return DistantApproach(approach, replace(stiffness, value=value, bound=bound, detail=detail))


def _distant_displacement(contact: Contact, solid: Body, distance: float, datum: float | None) -> tuple[float, float]:
    """Return the displacement of a surface at a `distance` [m] across from the middle of a line contact, over the load.

    Both the displacement over the load per length [1/Pa], and by how much a coating changes it, are returned. The load
    is taken on the axis of the contact, which is narrow beside the distance. The displacement counts from the `datum`
    [m]; without one it is that by the cells of the grid, whose load ends.
    """
    material: Any = getattr(solid, "substrate", solid)
    grid, along = contact.grid, contact.grid.y - contact.grid.y.mean()
    per_length = float(contact.net_pressure.sum()) * grid.cell_area / contact.loaded_length

    def by_cells(coefficients: Array) -> float:
        """Return the sum over all cells of the net pressure times `coefficients` (x, y), over the load per length."""
        return float((contact.net_pressure * coefficients).sum()) / per_length

    if datum:
        uncoated = 2 * material.compliance / pi * log(datum / distance)
    else:
        uncoated = material.compliance / pi * by_cells(grid.cell_area / np.hypot(distance, along))
    if not isinstance(solid, CoatedHalfSpace):
        return uncoated, 0.0
    if datum:
        coated = _of_line(solid, datum) - _of_line(solid, distance)
    else:
        offset = np.array([[distance]]), along[None]
        kinds = solid.response(distance).items()
        coated = sum(weight * by_cells(kind.cell(*offset, *grid.cell_size)) for kind, weight in kinds)
    return coated, abs(coated - uncoated)


def _of_line(body: CoatedHalfSpace, datum: float) -> float:
    """Return the rigid displacement that keeps a surface at rest at a `datum` [m] from a line load, over that [1/Pa]."""
    response: Mapping[Any, float] = body.response(datum)
    return float(sum(weight * kind.rigid_shift(1.0) for kind, weight in response.items()))

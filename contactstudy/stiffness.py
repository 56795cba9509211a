"""Normal stiffness of a dry contact, and the bound of its error."""

from dataclasses import replace
from math import inf, pi
from typing import Any

import numpy as np
from scipy.sparse.linalg import LinearOperator, minres

from contactstudy.accuracy.discretisation.cells import contact_perimeter
from contactstudy.answers.contact import Contact
from contactstudy.domain.fields import Array, inner
from contactstudy.scene.loads.resulting_load import PullOff
from contactstudy.solvers.conjugate_gradients import conjugate_gradients
from contactstudy.solving import solve

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


def normal_stiffness(solution: Contact) -> float:
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


def _adhesive_stiffness(contact: Contact, active: Array) -> float:
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


def _with_longer_range(contact: Contact) -> Contact:
    """Return an adhesive contact with a multiple of its range, or as it is where there is no such state."""
    scene, traction = contact.scene, contact.adhesion
    assert scene is not None
    assert scene.adhesion is not None
    assert traction is not None
    assert contact.padding is not None
    if isinstance(scene.load, PullOff):
        return contact
    adhesion = replace(scene.adhesion, range=LONGER_RANGE * traction.range)
    longer = replace(scene, adhesion=adhesion).problem(contact.grid, contact.padding)
    found = solve(longer, start=contact)
    return found if found.status.has_converged else contact


def stiffness_error(contact: Contact, stiffness: float) -> float:
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

"""One step of partial slip: the tangential traction after a change of the tangential force or displacement.

A step from the traction r to q on the first body slips by ``s = A (q - r) - d``, the slip of the first against the
second body, with the displacement ``A q`` under traction and the rigid one d of the second against the first body.
Coulomb's law, ``|q| <= mu p`` with s opposed to q where they are equal and ``s = 0`` elsewhere, makes q the traction of
least complementary energy ``1/2 (q - r) A (q - r)`` among those with the resultant that is asked for, or less ``d
sum(q)`` under a given d.

Source: Kalker (1990), ch. 4; Mindlin & Deresiewicz (1953).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import readable
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.solvers.friction.coulomb_newton import CoulombNewton
from contactstudy.solvers.friction.slip import QuasiStaticSlip
from contactstudy.solvers.solution import Status

# Fraction by which a force may exceed what friction transmits: the load of a solution is exact to rounding.
ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class SlipStep:
    """Tangential traction at the end of a step, and the slip in it.

    Parameters
    ----------
    shear
        Traction (component, x, y) [Pa] on the first body.
    slip
        Slip (component, x, y) [m] of the first against the second body in this step, zero outside the contact.
    rigid
        Rigid displacement (2,) [m] of the second against the first body in this step: a positive one makes a positive
        traction.
    stick
        Cells (x, y) in contact that stick.
    residual
        Root mean square of the change by one projection, over the largest traction, or over a fraction of that before
        the step where that is larger.
    applications
        Number of applications of the response to traction.
    """

    shear: Array
    slip: Array
    rigid: Array
    stick: NDArray[np.bool_]
    residual: float
    applications: int


def transmission_status(force: float, limit: Array, grid: Grid) -> Status:
    """Return whether a tangential `force` along x [N/m] of the length of `grid` acts: it does not on bodies apart.

    `limit` (x, y) [Pa] is the coefficient of friction times the pressure. Raises InvalidInput for a force above it.
    """
    largest = float(limit.sum()) * grid.cell_area / grid.length
    if force and not largest:
        return Status.DETACHED
    if abs(force) > (1 + ROUNDING) * largest:
        raise InvalidInput(
            f"The tangential force of Scene.friction is {readable(force, 'N m-1')}: friction transmits less than "
            f"{readable(largest, 'N m-1')} under the pressure of this contact, give a smaller force."
        )
    return Status.CONVERGED


def slip_step(
    response: ShearResponse,
    limit: Array,
    reference: Array,
    tolerance: float,
    max_applications: int,
    *,
    total: Array | None = None,
    rigid: Array | None = None,
    stretch: Array | None = None,
) -> SlipStep:
    """Return the tangential traction after a step from a `reference`, under a given resultant or rigid displacement.

    Parameters
    ----------
    response
        Displacement under traction, A.
    limit
        Largest traction (x, y) [Pa] at the end of the step, the coefficient of friction times the pressure.
    reference
        Traction (component, x, y) [Pa] before the step, and its part that is locked in by a rising pressure, see
        :func:`locked_shear`. It may exceed the limit: what is cut off moves the surface back.
    tolerance
        Largest residual.
    max_applications
        Number of applications of the response after which the step ends.
    total
        Sum of the traction (2,) [Pa] over all cells, smaller in magnitude than that of the limits. Exactly one of
        `total` and `rigid` is given.
    rigid
        Rigid displacement (2,) [m] of the second against the first body in this step. Above a limit the contact
        slides fully.
    stretch
        Displacement along x (x, 1) [m] of the first against the second body by bulk strain in this step; None for none.
    """
    if not limit.any():
        zeros, displacement = np.zeros_like(reference), np.zeros(2) if rigid is None else rigid
        return SlipStep(zeros, zeros, displacement, np.zeros(limit.shape, dtype=bool), 0.0, 0)
    newton = CoulombNewton(QuasiStaticSlip(response), limit, total)
    free_slip = -response(reference)
    if rigid is not None:
        free_slip -= rigid[:, None, None]
    if stretch is not None:
        free_slip[0] += stretch
    shear, slip, displacement, residual = newton.solve(
        free_slip, newton.gathered(reference), tolerance, max_applications - 1
    )
    if rigid is None:
        rigid, slip = displacement, slip - displacement[:, None]
    shear = newton.project(shear)
    return SlipStep(
        newton.field(shear),
        newton.field(slip),
        rigid,
        newton.sticks(shear, slip),
        residual,
        newton.applications + 1,
    )


def locked_shear(shear: Array, before: Array, after: Array, slope: float) -> Array:
    """Return the tangential traction (component, x, y) [Pa] that a step under a rising pressure is counted from.

    Every increment of pressure from `before` to `after` (x, y) [Pa] takes a traction of `slope` times itself into the
    contact without slip. The slope is the change of the tangential force over that of the load, within plus or minus the
    coefficient of friction, and 0 for a falling load. This is exact in plane strain and for a Poisson's ratio of 0, of
    bodies that are not coated. Source: Jaeger (1998), J. Tribol. 120, 677.
    """
    reference = shear.copy()
    reference[0] += slope * (after - before)
    return reference

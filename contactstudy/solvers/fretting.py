"""Fretting and partial slip: tangential traction under one or more tangential forces, each step from the one before.

In a step from the traction r to q on the first body, that body slips against the second by ``s = A (q - r) - d``. Here
``A q`` is the displacement under traction, and d the rigid one of the second against the first body. Coulomb's law is
``|q| <= mu p``, with s opposed to q where both sides are equal and ``s = 0`` elsewhere. It makes q, among tractions
with the given resultant, that of least complementary energy ``1/2 (q - r) A (q - r)``, minus ``d sum(q)`` where d is
given. Source: Kalker (1990), ch. 4.

Under a constant pressure a step from one reversal of the force to the next is exact in plane strain, as slip does not
reverse within it. Source: Mindlin & Deresiewicz (1953), J. Appl. Mech. 20, 327.

The limit of the traction is ``mu p`` (x, y), and the reference r. Steps in time, under pressures that change, are those
of :class:`~contactstudy.evolution.states.state_variables.FrettingState`, by :func:`slip_step` too.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.validation import InvalidInput, readable
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.problem.problem import Problem
from contactstudy.solvers.coulomb import CoulombNewton, ElasticSlip, SlipStep, shear_status
from contactstudy.solvers.solution import FrettingTraction, Solution, Status, TangentialTraction, worst
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Fraction by which a force may exceed what friction transmits, as a load summed over cells is rounded.
ROUNDING = 1e-6


def transmission_status(force: float, limit: Array, grid: Grid) -> Status:
    """Return the status of a tangential `force` along x [N/m] of the length of `grid`: detached on bodies apart.

    `limit` (x, y) [Pa] is the coefficient of friction times the pressure. Raises InvalidInput for a force above its sum.
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
        Traction (component, x, y) [Pa] before the step, plus what a rising pressure locks in, see
        :func:`locked_shear`. It may exceed the limit: what is cut off moves the surface back.
    tolerance
        Largest residual.
    max_applications
        Number of applications of the response after which the step ends.
    total
        Sum of the traction (2,) [Pa] over all cells, smaller in magnitude than that of the limits. Exactly one of
        `total` and `rigid` is given.
    rigid
        Rigid displacement (2,) [m] of the second against the first body in this step. Beyond some magnitude the
        contact slides fully.
    stretch
        Displacement along x (x, 1) [m] of the first against the second body by bulk strain in this step; None for none.
    """
    if not limit.any():
        zeros, displacement = np.zeros_like(reference), np.zeros(2) if rigid is None else rigid
        return SlipStep(zeros, zeros, displacement, np.zeros(limit.shape, dtype=bool), 0.0, 0)
    free_slip = -response(reference)
    if rigid is not None:
        free_slip -= rigid[:, None, None]
    if stretch is not None:
        free_slip[0] += stretch
    newton = CoulombNewton(ElasticSlip(response), limit, total)
    step = newton.solve(free_slip, reference, tolerance, max_applications - 1)
    return replace(step, rigid=step.rigid if rigid is None else rigid, applications=step.applications + 1)


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


# Difference of two forces, or bulk stresses, over the largest one within which they count as the same: above rounding.
SAME_FORCE = 1e-9
# Parts into which a drawn loop is divided between two forces. Tolerance and most applications of the response at their
# ends, finer than a line is drawn.
LOOP_PARTS, LOOP_TOLERANCE, LOOP_APPLICATIONS = 8, 1e-6, 1000
# Factor on friction with which a contact of up to 2000 cells along x sticks all over: the traction at an edge that
# sticks, over ``mu p``, grows like half that number.
STICKING = 1e3


@dataclass(frozen=True, eq=False)
class FrettingShear:
    """Tangential traction under successive tangential forces, added to the pressure of a frictionless contact.

    Parameters
    ----------
    coefficient
        Coefficient of friction mu.
    forces_per_length
        Tangential forces along x [N/m], from a contact without one, each less than friction transmits.
    response
        Displacement under tangential traction.
    bulk_stresses
        Bulk stresses [Pa] along x of one body that act with the forces, tension positive; none if empty. The strain
        along y is prevented.
    bulk_body
        Index of that body.
    bulk_compliance
        Strain of that body along x over the bulk stress [1/Pa], ``(1 - nu^2) / E``.
    """

    coefficient: float
    forces_per_length: tuple[float, ...]
    response: ShearResponse
    bulk_stresses: tuple[float, ...] = ()
    bulk_body: int = 0
    bulk_compliance: float = 0.0

    @property
    def _stresses(self) -> tuple[float, ...]:
        """Bulk stress [Pa] at the start, 0, and with each force."""
        return (0.0, *(self.bulk_stresses or (0.0,) * len(self.forces_per_length)))

    def _stretch(self, grid: Grid, before: float, after: float) -> Array | None:
        """Return the displacement (x, 1) [m] of the first against the second body as the bulk stress [Pa] changes.

        It is None where the stress stays the same.
        """
        strain = (1 - 2 * self.bulk_body) * self.bulk_compliance * (after - before)
        return None if before == after else strain * grid.x[:, None]

    def solve(self, problem: Problem, options: SolveOptions, start: Array | None, device: Device) -> Solution:
        """Return the normal contact with the tangential traction after the last force, and the history of slip."""
        normal = solve_contact(problem, options, start, device)
        limit = self.coefficient * normal.pressure
        shear = np.zeros((2, *limit.shape))
        statuses = [transmission_status(force, limit, problem.grid) for force in self.forces_per_length]
        stopping = options.tolerance, options.max_iterations
        # without a load there is no tangential force
        forces = self.forces_per_length if limit.any() else ()
        stresses = self._stresses
        steps: list[SlipStep] = []
        for number, force in enumerate(forces):
            stretch = self._stretch(problem.grid, *stresses[number : number + 2])
            total = np.array([force * problem.grid.length / problem.grid.cell_area, 0.0])
            step = slip_step(self.response, limit, shear, *stopping, total=total, stretch=stretch)
            shear = step.shear
            steps.append(step)
        statuses += [shear_status(step.residual, step.applications, *stopping) for step in steps]
        residual = max((step.residual for step in steps), default=0.0)
        applications = sum(step.applications for step in steps)
        cycle = _last_cycle([0.0, *forces], stresses)
        in_cycle = steps[slice(*cycle or (None,))]
        slip_distance = sum((np.hypot(*step.slip) for step in in_cycle), start=np.zeros_like(limit))
        traction = FrettingTraction(
            shear=shear,
            stick=steps[-1].stick if steps else normal.pressure > 0,
            method="fretting, Newton",
            iterations=applications,
            forces=np.array([0.0, *forces]) * problem.grid.length,
            rigid_displacement=np.cumsum([0.0, *(step.rigid[0] for step in steps)]),
            shears=np.reshape([step.shear for step in steps], (len(steps), 2, *limit.shape)),
            slip_distance=slip_distance,
            energy=limit * slip_distance,
            cycle=cycle,
            bulk=(0.0, stresses[-1]) if self.bulk_body else (stresses[-1], 0.0),
        )
        # an application of the response takes a convolution for each component of the traction
        return normal.with_traction(traction, worst(statuses), residual, applications, 2.0 * applications)

    def loop(self, solution: Solution) -> tuple[Array, Array, Array]:
        """Return forces along x [N], rigid displacements [m] and slip [m] along the last whole cycle, or the history.

        Each point between two forces is solved from the traction after the first of them, while a bulk stress changes
        in proportion. The slip is the displacement less that of a contact which sticks all over under the force. Under
        a constant bulk stress the area of either loop, over displacement or over slip, is the energy lost.
        """
        traction, problem = solution.traction, solution.problem
        assert isinstance(traction, FrettingTraction)
        limit = self.coefficient * solution.pressure
        rigid, forces, stresses = traction.rigid_displacement, traction.forces, np.array(self._stresses)
        start, end = traction.cycle or (0, len(forces) - 1)
        points = [(forces[start], rigid[start])]
        for step in range(start, end):
            shear = traction.shears[step - 1] if step else np.zeros_like(traction.shear)
            at_parts = (np.linspace(of[step], of[step + 1], LOOP_PARTS + 1)[1:-1] for of in (forces, stresses))
            for force, stress in zip(*at_parts, strict=True):
                total = np.array([force / problem.grid.cell_area, 0.0])
                stretch = self._stretch(problem.grid, stresses[step], stress)
                step_to = slip_step(
                    self.response, limit, shear, LOOP_TOLERANCE, LOOP_APPLICATIONS, total=total, stretch=stretch
                )
                points.append((force, rigid[step] + float(step_to.rigid[0])))
            points.append((forces[step + 1], rigid[step + 1]))
        forces, rigid = np.transpose(points)
        slip, largest = np.zeros_like(rigid), float(np.abs(forces).max())
        if largest:
            total = np.array([largest / problem.grid.cell_area, 0.0])
            at_rest, sticking = np.zeros_like(traction.shear), STICKING * limit
            stuck = slip_step(self.response, sticking, at_rest, LOOP_TOLERANCE, LOOP_APPLICATIONS, total=total)
            slip = rigid - forces / largest * float(stuck.rigid[0])
        return forces, rigid, slip


@dataclass(frozen=True, eq=False)
class PartialSlipShear:
    """Tangential traction of partial slip: that of a `fretting` contact, whose slip and energy are left out."""

    fretting: FrettingShear

    def solve(self, problem: Problem, options: SolveOptions, start: Array | None, device: Device) -> Solution:
        """Return the normal contact with the tangential traction after the last force."""
        solution = self.fretting.solve(problem, options, start, device)
        last = solution.traction
        assert last is not None
        traction = TangentialTraction(last.shear, last.stick, "partial slip, Newton", last.iterations, bulk=last.bulk)
        return replace(solution, traction=traction)


def _last_cycle(forces: Sequence[float], stresses: Sequence[float]) -> tuple[int, int] | None:
    """Return the indices of the `forces` at which the last whole cycle starts and ends; None if no cycle is whole.

    A cycle is whole from a reversal to the next but one, at the same force. The last force counts as a reversal, the
    first one, before which nothing has slipped, does not. The bulk `stresses` are the same too; where they alone change,
    their reversals count.
    """
    if len(set(forces[1:])) == 1 < len(set(stresses)):
        forces, stresses = stresses, forces
    moved = [0, *(n for n in range(1, len(forces)) if forces[n] != forces[n - 1])]
    triples = zip(moved, moved[1:], moved[2:], strict=False)
    turns = [b for a, b, c in triples if (forces[b] > forces[a]) != (forces[c] > forces[b])]
    turns += moved[1:][-1:]
    whole = [
        (a, b)
        for a, b in zip(turns, turns[2:], strict=False)
        if all(abs(of[a] - of[b]) <= SAME_FORCE * max(map(abs, of)) for of in (forces, stresses))
    ]
    return whole[-1] if whole else None

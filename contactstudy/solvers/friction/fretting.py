"""Fretting: tangential traction under an oscillating tangential force, each step from the traction before it.

Under a constant pressure a step from one reversal of the force to the next is exact in plane strain, as slip does not
reverse within it. Source: Mindlin & Deresiewicz (1953), J. Appl. Mech. 20, 327.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.fields import Array
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.problem.problem import Problem
from contactstudy.solvers.friction.bulk_stress import BulkStress
from contactstudy.solvers.friction.coulomb_newton import shear_status
from contactstudy.solvers.friction.fretting_traction import FrettingTraction
from contactstudy.solvers.friction.partial_slip import slip_step, transmission_status
from contactstudy.solvers.solution import Solution, TangentialTraction, with_traction, worst
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Difference of two forces over the largest one within which they count as the same.
SAME_FORCE = 1e-9
# Parts of a loop between two forces, and the tolerance and the most applications of the response at their ends.
LOOP_PARTS, LOOP_TOLERANCE, LOOP_APPLICATIONS = 8, 1e-6, 1000
# Factor on friction with which a contact sticks all over.
STICKING = 1e3


@dataclass(frozen=True, eq=False)
class FrettingShear:
    """Tangential traction under successive tangential forces, added to the pressure of a frictionless contact.

    Parameters
    ----------
    coefficient
        Coefficient of friction mu.
    forces_per_length
        Tangential forces along x [N/m], each less than friction transmits, starting from 0.
    response
        Displacement under tangential traction.
    bulk
        Body that carries a bulk stress.
    bulk_stresses
        Bulk stresses [Pa] that act with the forces; none if empty.
    """

    coefficient: float
    forces_per_length: tuple[float, ...]
    response: ShearResponse
    bulk: BulkStress = BulkStress()  # noqa: RUF009 (frozen)
    bulk_stresses: tuple[float, ...] = ()

    def solve(self, problem: Problem, options: SolveOptions, start: Array | None, device: Device) -> Solution:
        """Return the normal contact with the tangential traction after the last force, and the history of slip."""
        normal = solve_contact(problem, options, start, device)
        limit = self.coefficient * normal.pressure
        shear, stick = np.zeros((2, *limit.shape)), normal.pressure > 0
        statuses = [transmission_status(force, limit, problem.grid) for force in self.forces_per_length]
        applications, residual = 0, 0.0
        sliding: list[Array] = []
        shears: list[Array] = []
        displacements = [0.0]
        limits = options.tolerance, options.max_iterations
        # without a load there is no tangential force
        forces = self.forces_per_length if limit.any() else ()
        stresses = (0.0, *(self.bulk_stresses or (0.0,) * len(self.forces_per_length)))
        for number, force in enumerate(forces):
            stretch = None
            if stresses[number] != stresses[number + 1]:
                stretch = self.bulk.stretch(problem.grid, *stresses[number : number + 2])
            total = np.array([force * problem.grid.length / problem.grid.cell_area, 0.0])
            step = slip_step(self.response, limit, shear, *limits, total=total, stretch=stretch)
            sliding.append(np.hypot(*step.slip))
            displacements.append(displacements[-1] + float(step.rigid[0]))
            shear, stick = step.shear, step.stick
            shears.append(shear)
            applications += step.applications
            residual = max(residual, step.residual)
            statuses.append(shear_status(step.residual, step.applications, *limits))
        cycle = _last_cycle([0.0, *forces], stresses)
        slip_distance = sum(sliding[slice(*cycle or (None,))], start=np.zeros_like(limit))
        traction = FrettingTraction(
            shear=shear,
            stick=stick,
            method="fretting, Newton",
            iterations=applications,
            forces=np.array([0.0, *forces]) * problem.grid.length,
            rigid_displacement=np.array(displacements),
            shears=np.reshape(shears, (len(shears), 2, *limit.shape)),
            slip_distance=slip_distance,
            energy=limit * slip_distance,
            cycle=cycle,
            bulk=self.bulk.of_bodies(stresses[-1]),
        )
        return with_traction(normal, worst(statuses), residual, applications, 2.0 * applications, traction)

    def loop(self, solution: Solution) -> tuple[Array, Array, Array]:
        """Return forces along x [N], rigid displacements [m] and slip [m] along the last whole cycle, or the history.

        Each point between two forces is solved from the traction after the first of them. The slip is the displacement
        less that of a contact which sticks all over; the area of both loops is the energy lost.
        """
        traction, problem = solution.traction, solution.problem
        assert isinstance(traction, FrettingTraction)
        limit = self.coefficient * solution.pressure
        rigid, forces = traction.rigid_displacement, traction.forces
        start, end = traction.cycle or (0, len(forces) - 1)
        points = [(forces[start], rigid[start])]
        for step in range(start, end):
            shear = traction.shears[step - 1] if step else np.zeros_like(traction.shear)
            for force in np.linspace(forces[step], forces[step + 1], LOOP_PARTS + 1)[1:-1]:
                total = np.array([force / problem.grid.cell_area, 0.0])
                found = slip_step(self.response, limit, shear, LOOP_TOLERANCE, LOOP_APPLICATIONS, total=total)
                points.append((force, rigid[step] + float(found.rigid[0])))
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
    """Tangential traction of a `fretting` contact, without the slip and the energy, which partial slip does not name."""

    fretting: FrettingShear

    def solve(self, problem: Problem, options: SolveOptions, start: Array | None, device: Device) -> Solution:
        """Return the normal contact with the tangential traction after the last force."""
        solution = self.fretting.solve(problem, options, start, device)
        found = solution.traction
        assert found is not None
        traction = TangentialTraction(
            found.shear, found.stick, "partial slip, Newton", found.iterations, bulk=found.bulk
        )
        return replace(solution, traction=traction)


def _last_cycle(forces: Sequence[float], stresses: Sequence[float]) -> tuple[int, int] | None:
    """Return where the last whole cycle starts and ends: at a reversal and the next but one, at the same force.

    The last force counts as a reversal, the first one, before which nothing has slipped, does not. The bulk `stresses`
    are the same too; where they alone change, their reversals count.
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

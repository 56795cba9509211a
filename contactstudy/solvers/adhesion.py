"""Adhesion: an attraction that falls with the gap, frozen in each contact without adhesion and updated after it.

With the pressure p, the attraction (cohesive traction) t and the undeformed gap h the contact is

    g = h + K (p - t) - approach >= 0,  p >= 0,  p g = 0,  t = sigma(g),

under the load ``sum(p - t)`` or at a given approach. The method is the convex-concave procedure. The energy is convex
in the displacements but for that of the surfaces, minus the remaining work of separation, which is concave where
sigma falls with the gap. An outer iteration freezes t, solves the contact with the heights ``h - K t`` under the load
``L + sum(t)``, and takes ``t = sigma(g)``: the concave part is replaced by its tangent, so that the energy never rises.
Anderson's (1965) mixing of the last attractions accelerates it; a mixed iterate that raises the energy by more than the
change that it leaves is rejected.

Without mixing the iteration is monotone in the attraction that it starts from. From zero it rises to the least adhesive
state, the approach (jump-in) branch; from the largest attraction everywhere it falls to the most adhesive one, the
separation branch.

Source: Tao & Hoai An (1997), Acta Math. Vietnam. 22, 289 (difference of convex functions).

The pull-off is the load at which the equilibrium is lost, found by a search over loads.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.grid import Array, dot
from contactstudy.problem.constraint import CohesiveLaw, PrescribedLoad
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import AdhesiveTraction, Branch, CoupledSolution, Solution, Status, unloaded
from contactstudy.solvers.solve import AndersonMixing, SolveOptions, solve_contact

# Constants of the outer iteration, judged by the convolutions of six contacts, smooth and rough, and of pull-offs.
# Relative change of the attraction in the last outer iteration, in tolerances of the contact. A tenth of it takes up to
# 14 % more convolutions.
CHANGE_IN_TOLERANCES = 1e3
# Largest relative change of the attraction in the last outer iteration at any tolerance. A change of 1 would leave an
# attraction of zero.
MAX_CHANGE = 0.1
# Largest error of the gap in an inner contact over the range of the attraction. Below it the error is a tenth of the
# last change of the attraction. Solving each contact to its tolerance takes 1.3 to 1.6 times the convolutions.
MAX_INNER_ERROR = 1e-3
# Plain updates of the attraction before the first mixed iterate, and after the one that replaces the first rejected one;
# twice as many after each further one. From 0 to 4 convolutions change by 0.6 to 1.3 times, with no best value.
PLAIN_ITERATIONS = 2
# Fraction of the tolerance by which an attraction may change load and heights without another solve, so that a
# negligible adhesion costs one solve.
NEGLIGIBLE = 1e-3
# Traction at an open edge over the largest, above which the attraction that is cut off there matters.
EDGE = 1e-3


def is_cut_off(problem: Problem, attraction: Array) -> bool:
    """Return whether an `attraction` (x, y) [Pa] at the open edges of `problem` is above a fraction of its peak."""
    lines = [attraction[ix] for ix in problem.open_edges]
    lines += [attraction[:, iy] for iy in problem.open_ends]
    at_edge = max((float(line.max()) for line in lines), default=0.0)
    return at_edge > EDGE * float(attraction.max())


# Solves a problem without adhesion coupled to a state of the bodies: from the frozen attraction (x, y) [Pa] that its
# heights contain, options, and a pressure (x, y) [Pa] to begin with.
InnerSolve = Callable[[Problem, Array, SolveOptions, Array | None], CoupledSolution]


@dataclass(frozen=True, eq=False)
class AdhesiveSolver:
    """Solver of a contact with adhesion on one grid.

    Parameters
    ----------
    law
        Traction as a function of the gap.
    branch
        History that decides between several states.
    cells_in_zone
        Number of cells in the cohesive zone.
    tabor
        Tabor's parameter, or None without a curved shape.
    regularised
        Whether the range was chosen for the grid, in place of the JKR limit of short ranges.
    attraction
        Traction (x, y) [Pa] of the state before, for a history that is continued.
    depth
        Number of attractions before the last that enter a mixed iterate; 0 mixes none, and solves each contact to its
        tolerance.
    """

    law: CohesiveLaw
    branch: Branch
    cells_in_zone: float
    tabor: float | None = None
    regularised: bool = False
    attraction: Array | None = None
    depth: int = 5

    def continued(self, attraction: Array) -> "AdhesiveSolver":
        """Return this solver for a contact that comes from a state with this `attraction` (x, y) [Pa]."""
        return replace(self, branch=Branch.CONTINUED, attraction=attraction)

    def after(self, solution: Solution) -> "AdhesiveSolver":
        """Return this solver for a contact that comes from the state of `solution`."""
        assert solution.adhesion is not None
        return self.continued(solution.adhesion.attraction)

    def solve(self, problem: Problem, options: SolveOptions, start: Array | None, device: Device) -> Solution:
        """Return the solution of the contact `problem` with adhesion, from the state that the branch names."""
        return self.solve_coupled(None, problem, options, start, device)[0]

    def solve_coupled(
        self, inner: InnerSolve | None, problem: Problem, options: SolveOptions, start: Array | None, device: Device
    ) -> tuple[Solution, Any]:
        """Return the solution of :meth:`solve`, and the coupled state of the bodies.

        `inner` solves each contact under a frozen attraction together with a state such as plastic strain. The state
        returned is that of the last contact, empty where `inner` is None; it is None where the bodies came apart,
        because the attraction does not carry the tensile load.
        """
        first = {Branch.FROM_AFAR: 0.0, Branch.FROM_FULL_CONTACT: self.law.strength, Branch.CONTINUED: self.attraction}[
            self.branch
        ]
        attraction = np.broadcast_to(np.asarray(first), problem.undeformed_gap.shape)
        return OuterIteration(problem, self, options, device, inner).solution(attraction, start)


@dataclass(frozen=True, eq=False)
class _State:
    """Contact under a frozen `attraction` (x, y) [Pa].

    `attraction_displacement` (x, y) [m] is the displacement of the surface by it, `updated` the attraction (x, y) [Pa]
    at its gap, `change` the distance to that over its sum, `energy` [J] that of the bodies, the load and the surfaces,
    and `remaining_work` [J] the remaining work of separation. The state `of_bodies` has added `added_gap` (x, y) [m].
    """

    contact: Solution
    of_bodies: Any
    added_gap: Array
    attraction: Array
    attraction_displacement: Array
    updated: Array
    change: float
    energy: float
    remaining_work: float

    def accepts(self, following: "_State") -> bool:
        """Return whether the energy of a `following` state is no higher, up to `change**2 * remaining_work`."""
        return following.energy <= self.energy + following.change**2 * following.remaining_work


@dataclass(eq=False)
class OuterIteration:
    """Outer iteration over the attraction of one problem, and its counts."""

    problem: Problem
    solver: AdhesiveSolver
    options: SolveOptions
    device: Device
    inner: InnerSolve | None = None
    count: int = 0
    iterations: int = 0
    convolutions: float = 0.0
    energies: list[float] = field(default_factory=list)

    def solution(self, attraction: Array, start: Array | None) -> tuple[Solution, Any]:
        """Return the solution from an `attraction` (x, y) [Pa] on, and the coupled state of the bodies.

        The first contact begins with the pressure `start` (x, y) [Pa].
        """
        tolerance = min(CHANGE_IN_TOLERANCES * self.options.tolerance, MAX_CHANGE)
        loosest = 0.0 if self.solver.depth == 0 or self._is_weak() else MAX_INNER_ERROR
        gap_error, mixing = loosest, AndersonMixing(self.solver.depth)
        plain_left = plain_after_rejection = PLAIN_ITERATIONS
        is_mixed, pressure, last = False, start, None
        while True:
            if last is not None and self._iterations_left() == 0:
                return self._ended(last)
            load = self._contact_load(attraction)
            if load <= 0 and not is_mixed:
                return self._detached(), None
            displacement = self.problem.operator(attraction)
            self.convolutions += 1
            if last is not None and self._is_negligible(attraction, displacement, last):
                return self._ended(replace(last, attraction=attraction, change=0.0))
            state = self._frozen(attraction, displacement, load, pressure, gap_error) if load > 0 else None
            if state is not None and not np.isfinite(state.contact.residual):
                return self._ended(state)
            if is_mixed and last is not None and (state is None or not last.accepts(state)):
                attraction, is_mixed = last.updated, False
                mixing.restart()
                plain_left, plain_after_rejection = plain_after_rejection, 2 * plain_after_rejection
                continue
            assert state is not None
            last, pressure = state, state.contact.pressure
            self.energies.append(state.energy)
            converged = state.change <= tolerance
            is_exact = self._inner_tolerance(gap_error) <= self.options.tolerance
            if converged and is_exact:
                return self._ended(state)
            if converged:  # the same attraction once more, to the tolerance of the contact
                gap_error = 0.0
                continue
            gap_error = min(max(state.change, tolerance) / 10, loosest)
            mixing.record(state.attraction, state.updated - state.attraction)
            plain_left -= 1
            is_mixed, attraction = plain_left < 0 and mixing.mixes, state.updated
            if is_mixed:
                attraction = np.clip(mixing.mixed_iterate(), 0, self.solver.law.strength)

    def _is_weak(self) -> bool:
        """Return whether the largest attraction everywhere is below the tolerance of the load."""
        control = self.problem.control
        largest = self.solver.law.strength * self.problem.undeformed_gap.size
        return control.total is not None and largest < self.options.tolerance * control.total

    def _contact_load(self, attraction: Array) -> float:
        """Return the load of the pressure alone, over the area of a cell [Pa]; infinite under a given approach."""
        control = self.problem.control
        if control.total is None:
            return inf
        return control.total + float(attraction.sum())

    def _inner_tolerance(self, gap_error: float) -> float:
        """Return the dimensionless tolerance of a contact for an error of its gap, a fraction of the range."""
        allowed = gap_error * self.solver.law.range / self.problem.scales.gap
        return max(self.options.tolerance, allowed)

    def _iterations_left(self) -> int:
        """Return how many inner and outer iterations together are left to their limit."""
        return max(self.options.max_iterations - self.iterations - self.count, 0)

    def _is_negligible(self, attraction: Array, displacement: Array, last: _State) -> bool:
        """Return whether the step from the `last` state to an `attraction` is far below the tolerance of the contact."""
        problem, allowed = self.problem, NEGLIGIBLE * self.options.tolerance
        change = float(np.abs(displacement - last.attraction_displacement).max())
        added = float(np.abs(attraction - last.attraction).sum())
        is_exact = last.contact.residual <= self.options.tolerance
        load = float(last.contact.pressure.sum())
        return is_exact and change <= allowed * problem.scales.gap and added <= allowed * load

    def _frozen(
        self, attraction: Array, displacement: Array, load: float, start: Array | None, gap_error: float
    ) -> _State:
        """Return the contact under a frozen `attraction`, which displaces the surface by `displacement`."""
        problem, law = self.problem, self.solver.law
        control = problem.control if load == inf else PrescribedLoad(load)
        frozen = replace(problem, undeformed_gap=problem.undeformed_gap - displacement, control=control, adhesion=None)
        options = replace(
            self.options, tolerance=self._inner_tolerance(gap_error), max_iterations=max(self._iterations_left() - 1, 0)
        )
        if self.inner is None:
            coupled = CoupledSolution(solve_contact(frozen, options, start, self.device))
        else:
            coupled = self.inner(frozen, attraction, options, start)
        contact = coupled.solution
        self.count += 1
        self.iterations += contact.iterations
        self.convolutions += contact.convolutions
        updated = law.traction(contact.gap)
        total = float(updated.sum())
        change = float(np.abs(updated - attraction).sum())
        area = problem.grid.cell_area
        remaining_work = area * float(law.remaining_work(contact.gap).sum())
        net = contact.pressure - attraction
        energy = area * dot(net, contact.displacement - displacement) / 2 - remaining_work + coupled.energy
        if load != inf:
            energy -= area * (load - float(attraction.sum())) * contact.approach
        relative = change / total if total else change
        added_gap = contact.problem.undeformed_gap - frozen.undeformed_gap
        return _State(
            contact, coupled.state, added_gap, attraction, displacement, updated, relative, energy, remaining_work
        )

    def _ended(self, state: _State) -> tuple[Solution, Any]:
        """Return the solution of the last `state`, and the coupled state of the bodies."""
        contact = state.contact
        gap = self.problem.undeformed_gap + state.added_gap
        residual = max(contact.residual, state.change / CHANGE_IN_TOLERANCES)
        status = contact.status
        if status.has_converged and residual > self.options.tolerance:
            status = Status.ITERATION_LIMIT
        elif status is Status.CONVERGED and not contact.pressure.any():
            status = Status.DETACHED
        elif status is Status.CONVERGED and is_cut_off(self.problem, state.attraction):
            status = Status.ATTRACTION_AT_EDGE
        solution = replace(
            contact,
            problem=replace(self.problem, undeformed_gap=gap),
            displacement=contact.displacement - state.attraction_displacement,
            status=status,
            iterations=self.iterations,
            convolutions=self.convolutions,
            residual=residual,
            adhesion=self._part(state.attraction, tuple(self.energies)),
        )
        return solution, state.of_bodies

    def _detached(self) -> Solution:
        """Return the undeformed bodies as they just touch: the attraction does not carry the tensile load."""
        touching = unloaded(self.problem)
        return replace(
            touching,
            status=Status.DETACHED,
            iterations=self.iterations,
            convolutions=self.convolutions,
            adhesion=self._part(touching.pressure, (0.0,)),
        )

    def _part(self, attraction: Array, energies: tuple[float, ...]) -> AdhesiveTraction:
        """Return the part of a solution that adhesion adds."""
        solver = self.solver
        return AdhesiveTraction(
            attraction=attraction,
            branch=solver.branch.value,
            energies=energies,
            cells_in_zone=solver.cells_in_zone,
            tabor=solver.tabor,
            regularised=solver.regularised,
            outer_iterations=self.count,
            range=solver.law.range,
        )


# Iterations of each load but the first over those of a solve: just beyond the last stable load the bodies detach slowly.
ITERATION_FACTOR = 10
# Step of the load over the sum of the attraction, until a load is unstable.
LOAD_STEP = 0.25


@dataclass(frozen=True, eq=False)
class PullOffSearch:
    """Search for the pull-off load of a contact with adhesion, from the load of its problem on.

    The load is lowered until the bodies detach, and bisected between the last stable load and the first unstable one.
    Each solve begins with the last stable state. A load at which the solve does not converge ends the search.

    Parameters
    ----------
    solver
        Solver of each load.
    error
        Difference of both loads over the first unstable one.
    """

    solver: AdhesiveSolver
    error: float

    def continued(self, attraction: Array) -> "PullOffSearch":
        """Return this search, which begins with the load of its problem in any case."""
        return self

    def solve(self, problem: Problem, options: SolveOptions, start: Array | None, device: Device) -> Solution:
        """Return the last stable state; its part `adhesion` has the first unstable load, None if none was found.

        Where the solve at some load does not converge, the status is that of this load, which the note says.
        """
        assert problem.control.total is not None
        last_stable = self.solver.solve(problem, options, start, device)
        status, note = last_stable.status, last_stable.note
        iterations, convolutions = last_stable.iterations, last_stable.convolutions
        load, first_unstable = problem.control.total, -inf
        to_load_per_length = problem.grid.cell_area / problem.grid.length
        options = replace(options, max_iterations=ITERATION_FACTOR * options.max_iterations)
        while status.has_converged and (
            first_unstable == -inf or load - first_unstable > self.error * abs(first_unstable)
        ):
            assert last_stable.adhesion is not None
            pull = LOAD_STEP * float(last_stable.adhesion.attraction.sum())
            # bodies that attract each other do not separate under a load of at least 0
            trial = min(load - pull, 0.0) if first_unstable == -inf else (load + first_unstable) / 2
            lowered = replace(problem, control=PrescribedLoad(trial))
            state = self.solver.after(last_stable).solve(lowered, options, last_stable.pressure, device)
            iterations += state.iterations
            convolutions += state.convolutions
            if state.status is Status.DETACHED:
                first_unstable = trial
                continue
            status, note = state.status, state.note
            if status.has_converged:
                load, last_stable = trial, state
            else:
                where = f"{trial * to_load_per_length:.4g} N/m"
                ended = f"The search for the pull-off load ended at {where}, where it did not converge."
                note = f"{note} {ended}".lstrip()
        assert last_stable.adhesion is not None
        part = replace(
            last_stable.adhesion,
            branch=self.solver.branch.value,
            first_unstable_load=first_unstable * to_load_per_length if first_unstable > -inf else None,
        )
        return replace(
            last_stable, status=status, note=note, iterations=iterations, convolutions=convolutions, adhesion=part
        )

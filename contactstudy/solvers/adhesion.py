"""Adhesion: an attraction that falls with the gap, frozen in each contact without adhesion and updated after it.

With the pressure p, the attraction (cohesive traction) t and the undeformed gap h the contact is

    g = h + K (p - t) - approach >= 0,  p >= 0,  p g = 0,  t = sigma(g),

under the load ``sum(p - t)`` or at a given approach. The method is the convex-concave procedure. The energy is convex
in the displacements but for that of the surfaces, minus the remaining work of separation, which is concave where
sigma falls with the gap. An outer iteration freezes t, solves the contact with the heights ``h - K t`` under the load
``L + sum(t)``, and takes ``t = sigma(g)``. This replaces the concave part by its tangent, so that the energy never
rises. Anderson's (1965) mixing of the last attractions accelerates it; a mixed iterate is rejected if it raises the
energy by more than is uncertain while the attraction still changes.

Without mixing the iteration is monotone in the attraction that it starts from. From zero it rises to the least adhesive
state, the approach (jump-in) branch; from the largest attraction everywhere it falls to the most adhesive one, the
separation branch.

Source: Tao & Hoai An (1997), Acta Math. Vietnam. 22, 289 (difference of convex functions).

The pull-off is the load at which the equilibrium is lost, found by a search over loads.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import NamedTuple

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.grid import Array, dot
from contactstudy.problem.constraint import CohesiveLaw, PrescribedLoad
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import AdhesiveTraction, Branch, Solution, Status, unloaded
from contactstudy.solvers.solve import SolveOptions, fixed_point, solve_contact

# Constants of the outer iteration, judged by the convolutions of 18 contacts, smooth and rough, four of them pull-offs.
# Relative change of the attraction in the last outer iteration, in tolerances of the contact. A tenth of it takes 41 %
# more, ten times it 2 % fewer.
CHANGE_IN_TOLERANCES = 1e3
# Largest relative change of the attraction in the last outer iteration at any tolerance. From zero the first change is
# 1: with that limit the iteration would end without an attraction.
MAX_CHANGE = 0.1
# Largest error of the gap in an inner contact over the range of the attraction. Below it the error is a tenth of the
# last change of the attraction. A tenth of it takes 39 % more, ten times it 1 % more.
MAX_INNER_ERROR = 1e-3
# Number of attractions before the last that enter a mixed iterate: 3 take 9 % more, 8 take 25 % more.
DEPTH = 5
# Traction at an open edge over the largest, above which the attraction beyond that edge matters: it is about this
# fraction of the whole attraction.
EDGE = 1e-3


def is_cut_off(problem: Problem, attraction: Array) -> bool:
    """Return whether an `attraction` (x, y) [Pa] at the open edges of `problem` is above a fraction of its peak."""
    return problem.is_cut_off(np.where(attraction > EDGE * float(attraction.max()), attraction, 0.0))


# Solves a problem without adhesion, together with a state of the bodies such as plastic strain. Its arguments are the
# problem, the frozen attraction (x, y) [Pa], by which the heights of the problem are displaced, options, and a pressure
# (x, y) [Pa] to begin with or None. It returns the contact and the energy [J] that the state adds.
InnerSolve = Callable[[Problem, Array, SolveOptions, Array | None], tuple[Solution, float]]


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
        Number of cells in the cohesive zone, over which the traction falls at the edge of a contact.
    tabor
        Tabor's parameter, the elastic deformation over the range of the traction; None without a curved shape.
    regularised
        Whether the range was chosen for the grid, in place of the limit of short ranges (Johnson, Kendall & Roberts
        1971).
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
    depth: int = DEPTH

    def continued(self, attraction: Array) -> "AdhesiveSolver":
        """Return this solver for a contact that comes from a state with this `attraction` (x, y) [Pa]."""
        return replace(self, branch=Branch.CONTINUED, attraction=attraction)

    def solve(
        self,
        problem: Problem,
        options: SolveOptions,
        start: Array | None,
        device: Device,
        inner: InnerSolve | None = None,
    ) -> Solution:
        """Return the solution of the contact `problem` with adhesion, from the state that the branch names.

        The first contact begins with the pressure `start` (x, y) [Pa]. `inner` solves each contact under a frozen
        attraction, lastly that of the solution; None is for bodies without a state. Where the attraction does not carry
        a tensile load, the solution is the undeformed bodies as they just touch.
        """
        control, law = problem.control, self.law
        # an attraction below the tolerance of the load, which is as if there were none
        largest = law.strength * problem.undeformed_gap.size
        is_negligible = control.total is not None and largest < options.tolerance * control.total
        tolerance = inf if is_negligible else min(CHANGE_IN_TOLERANCES * options.tolerance, MAX_CHANGE)
        loosest = 0.0 if is_negligible or self.depth == 0 else MAX_INNER_ERROR
        outer = _OuterIteration(problem, law, options, start, device, inner, tolerance, loosest)
        first = {Branch.FROM_AFAR: 0.0, Branch.FROM_FULL_CONTACT: law.strength, Branch.CONTINUED: self.attraction}
        attraction = np.broadcast_to(np.asarray(first[self.branch]), problem.undeformed_gap.shape)
        energies: list[float] = []
        for state in fixed_point(outer.state_at, attraction, self.depth, _State.accepts):
            energies.append(state.energy)
            if state.change <= tolerance or not outer.iterations_left or not np.isfinite(state.contact.residual):
                break
        contact: Solution = state.contact
        residual = contact.residual
        if not is_negligible:
            residual = max(residual, state.change / CHANGE_IN_TOLERANCES)
        status = contact.status
        if status.has_converged and residual > options.tolerance:
            status = Status.ITERATION_LIMIT
        elif status is Status.CONVERGED and not contact.pressure.any():
            status = Status.DETACHED
        elif status is Status.CONVERGED and is_cut_off(problem, state.iterate):
            status = Status.ATTRACTION_AT_EDGE
        # the displacement by the state that `inner` solves, zero without one
        added_gap = contact.problem.undeformed_gap - (problem.undeformed_gap - state.displacement)
        return replace(
            contact,
            problem=replace(problem, undeformed_gap=problem.undeformed_gap + added_gap),
            displacement=contact.displacement - state.displacement,
            status=status,
            iterations=outer.iterations,
            convolutions=outer.convolutions,
            residual=residual,
            adhesion=AdhesiveTraction(
                attraction=state.iterate,
                branch=self.branch.value,
                energies=tuple(energies),
                cells_in_zone=self.cells_in_zone,
                tabor=self.tabor,
                regularised=self.regularised,
                outer_iterations=outer.count,
                range=law.range,
            ),
        )


class _State(NamedTuple):
    """Contact under a frozen attraction, the `iterate` (x, y) [Pa], and the attraction at its gap, the `image` (x, y).

    `displacement` (x, y) [m] is that of the surface by the frozen attraction. `change` is the distance between both
    attractions in L1 over the sum of the second, `energy` [J] that of the bodies, the load and the surfaces.
    `uncertainty` [J] is its error by the change, of second order as the energy is stationary.
    """

    contact: Solution
    iterate: Array
    image: Array
    displacement: Array
    change: float
    energy: float
    uncertainty: float

    def accepts(self, following: "_State") -> bool:
        """Return whether a `following` state is in contact, with an energy that is no higher up to its uncertainty."""
        in_contact = following.contact.status is not Status.DETACHED
        return in_contact and following.energy <= self.energy + following.uncertainty


@dataclass(eq=False)
class _OuterIteration:
    """Contacts under frozen attractions of one problem, and their number and work so far.

    `tolerance` is the largest relative change of the attraction in the last of them, and `loosest` the largest error of
    the gap in those before, over the range of the attraction. The other parameters are those of
    :meth:`AdhesiveSolver.solve`.
    """

    problem: Problem
    law: CohesiveLaw
    options: SolveOptions
    start: Array | None
    device: Device
    inner: InnerSolve | None
    tolerance: float
    loosest: float
    count: int = 0
    iterations: int = 0
    convolutions: float = 0.0

    @property
    def iterations_left(self) -> int:
        """Number of inner and outer iterations together that are left to their limit."""
        return max(self.options.max_iterations - self.iterations - self.count, 0)

    def state_at(self, attraction: Array, last: _State | None) -> _State:
        """Return the contact under a frozen `attraction` (x, y) [Pa], which begins with the pressure of the `last` one.

        It is solved to the tolerance of the options where it changes the attraction by no more than `tolerance`. Where
        the attraction does not carry a tensile load, the bodies just touch, detached.
        """
        problem, control = self.problem, self.problem.control
        attraction = np.clip(attraction, 0, self.law.strength)
        if control.total is not None:
            control = PrescribedLoad(control.total + float(attraction.sum()))
            if control.total <= 0:
                detached, none = replace(unloaded(problem), status=Status.DETACHED), np.zeros_like(attraction)
                return _State(detached, none, none, none, 0.0, 0.0, 0.0)
        displacement = problem.operator(attraction)
        self.convolutions += 1
        frozen = replace(problem, undeformed_gap=problem.undeformed_gap - displacement, control=control, adhesion=None)
        gap_error, start = self.loosest, self.start
        if last is not None:
            gap_error = min(max(last.change, self.tolerance) / 10, self.loosest)
            start = last.contact.pressure
        tolerance = max(self.options.tolerance, gap_error * self.law.range / problem.scales.gap)
        state = self._contact(frozen, attraction, displacement, start, tolerance)
        if state.change <= self.tolerance and tolerance > self.options.tolerance:
            state = self._contact(frozen, attraction, displacement, state.contact.pressure, self.options.tolerance)
        return state

    def _contact(
        self, frozen: Problem, attraction: Array, displacement: Array, start: Array | None, tolerance: float
    ) -> _State:
        """Return the contact of the `frozen` problem, whose `attraction` displaces the surface by `displacement`."""
        limit = max(self.iterations_left - 1, 0)
        options = replace(self.options, tolerance=tolerance, max_iterations=limit)
        if self.inner is None:
            contact, energy = solve_contact(frozen, options, start, self.device), 0.0
        else:
            contact, energy = self.inner(frozen, attraction, options, start)
        self.count += 1
        self.iterations += contact.iterations
        self.convolutions += contact.convolutions
        image, area = self.law.traction(contact.gap), frozen.grid.cell_area
        change, total = float(np.abs(image - attraction).sum()), float(image.sum())
        relative_change = change / total if total else change
        remaining_work = area * float(self.law.remaining_work(contact.gap).sum())
        net = contact.pressure - attraction
        energy += area * dot(net, contact.displacement - displacement) / 2 - remaining_work
        if self.problem.control.total is not None:
            energy -= area * self.problem.control.total * contact.approach
        uncertainty = relative_change**2 * remaining_work
        return _State(contact, attraction, image, displacement, relative_change, energy, uncertainty)


# Largest number of iterations of each load but the first, over that of a solve. Just beyond the last stable load the
# bodies detach slowly, in up to four times the iterations of the first load.
ITERATION_FACTOR = 10
# Step of the load over the sum of the attraction, until a load is unstable: 0.1 takes 44 % more convolutions of the four
# pull-offs, 0.5 takes 2 % more.
LOAD_STEP = 0.25


@dataclass(frozen=True, eq=False)
class PullOffSearch:
    """Search for the pull-off load of a contact with adhesion, from the load of its problem on.

    The load, the sum of the net pressure over all cells [Pa], is lowered until the bodies detach, and bisected between
    the last stable load and the first unstable one.
    Each solve begins with the last stable state. A load at which the solve does not converge ends the search.

    Parameters
    ----------
    solver
        Solver of each load.
    error
        Largest difference of the last stable and the first unstable load, over the latter.
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
        load, first_unstable, trial = problem.control.total, -inf, inf
        last = stable = self.solver.solve(problem, options, start, device)
        iterations, convolutions = last.iterations, last.convolutions
        options = replace(options, max_iterations=ITERATION_FACTOR * options.max_iterations)
        while last.status.has_converged and (
            first_unstable == -inf or load - first_unstable > self.error * abs(first_unstable)
        ):
            assert stable.adhesion is not None
            attraction = stable.adhesion.attraction
            # bodies that attract each other do not separate under a load of at least 0
            lower = min(load - LOAD_STEP * float(attraction.sum()), 0.0)
            trial = lower if first_unstable == -inf else (load + first_unstable) / 2
            lowered = replace(problem, control=PrescribedLoad(trial))
            last = self.solver.continued(attraction).solve(lowered, options, stable.pressure, device)
            iterations, convolutions = iterations + last.iterations, convolutions + last.convolutions
            if last.status is Status.DETACHED:
                first_unstable, last = trial, stable
            elif last.status.has_converged:
                load, stable = trial, last
        assert stable.adhesion is not None
        note, to_load_per_length = last.note, problem.grid.cell_area / problem.grid.length
        if last is not stable:
            where = f"{trial * to_load_per_length:.4g} N/m"
            note = f"{note} The search for the pull-off load ended at {where}, where it did not converge.".lstrip()
        part = replace(
            stable.adhesion,
            branch=self.solver.branch.value,
            first_unstable_load=first_unstable * to_load_per_length if first_unstable > -inf else None,
        )
        status = last.status
        return replace(
            stable, status=status, note=note, iterations=iterations, convolutions=convolutions, adhesion=part
        )

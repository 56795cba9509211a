"""Adhesion: a cohesive traction that falls with the gap, frozen in each ordinary contact and updated after it.

With the pressure p, the cohesive traction t and the undeformed gap h the contact is

    g = h + K (p - t) - approach >= 0,  p >= 0,  p g = 0,  t = sigma(g),

under the load ``sum(p - t)`` or at a given approach. Its energy is convex in the displacements but for the work of
adhesion, which is concave where sigma falls with the gap. A pass that freezes t, solves the contact with the heights
``h - K t`` and the load ``L + sum(t)``, and takes ``t = sigma(g)`` replaces the concave part by its tangent: it never
raises the energy. Anderson's (1965) mixing of the last tractions accelerates it, and is undone where it raises the
energy.

The traction that a plain pass makes grows with the one that it begins with. From no traction the passes rise to the
least adhesive state, the approach (jump-in) branch; from the largest traction everywhere they fall to the most adhesive
one, the separation branch.

Source: Tao & Hoai An (1997), Acta Math. Vietnam. 22, 289 (difference of convex functions).
"""

from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.fields import Array, dot
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.problem.problem import Problem
from contactstudy.solvers.anderson import anderson_mixture
from contactstudy.solvers.cohesive_law import CohesiveLaw
from contactstudy.solvers.solution import Branch, CohesiveTraction, Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Change of the traction in the last pass over its sum, in tolerances of the contact.
CHANGE = 1e3
# Tolerance of a contact, as a fraction of the range: a tenth of the last change, but no more than this.
LOOSEST = 1e-3
# Plain passes before the first mixture.
PLAIN_PASSES = 2
# A traction that changes heights by this fraction of the tolerance is not worth another pass.
NEGLIGIBLE = 1e-3
# Traction at an open edge over the largest, above which the attraction that is cut off there matters.
EDGE = 1e-3


@dataclass(frozen=True, eq=False)
class Adhesive:
    """Law of adhesion of one problem.

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
        Whether the range was chosen for the grid, in place of the limit of short ranges.
    traction
        Traction (x, y) [Pa] of the state before, for a history that is continued.
    depth
        Number of tractions before the last that the next one is mixed of; 0 takes plain passes alone, each
        contact solved to its tolerance.
    """

    law: CohesiveLaw
    branch: Branch
    cells_in_zone: float
    tabor: float | None = None
    regularised: bool = False
    traction: Array | None = None
    depth: int = 5

    def continued(self, traction: Array) -> "Adhesive":
        """Return this law for a contact that comes from a state with this `traction` (x, y) [Pa]."""
        return replace(self, branch=Branch.CONTINUED, traction=traction)

    def after(self, solution: Solution) -> "Adhesive":
        """Return this law for a contact that comes from the state of `solution`."""
        assert solution.adhesion is not None
        return self.continued(solution.adhesion.traction)

    def separated(self, error: float) -> "PullOffSearch":
        """Return the search for the pull-off load to a relative `error`."""
        return PullOffSearch(self, error)

    def solve(
        self, problem: Problem, options: SolveOptions, start: Array | None, on: Device
    ) -> Solution:
        """Return the solution of the contact `problem` with adhesion, from the state that the branch names."""
        shape = problem.undeformed_gap.shape
        first = {
            Branch.FROM_AFAR: 0.0,
            Branch.FROM_FULL_CONTACT: self.law.strength,
            Branch.CONTINUED: self.traction,
        }[self.branch]
        passes = _Passes(problem, self.law, self.depth, options, on)
        return passes.solution(self, np.broadcast_to(np.asarray(first), shape), start)


# Iterations of each load in a search, over those of a solve.
MORE_ITERATIONS = 10
# Step of the load below the last stable one, over the sum of the adhesive traction, until a load is unstable.
LOAD_STEP = 0.25


@dataclass(frozen=True, eq=False)
class PullOffSearch:
    """Search for the pull-off load of a contact with adhesion, from the load of its problem on.

    The load is lowered until no equilibrium is found, and bisected between the last stable load and the first unstable
    one. Each solve begins with the last stable state.

    Parameters
    ----------
    adhesive
        Law of adhesion.
    error
        Difference of both loads over the first unstable one.
    """

    adhesive: Adhesive
    error: float

    def continued(self, traction: Array) -> "PullOffSearch":
        """Return this search, which begins with the load of its problem in any case."""
        return self

    def solve(
        self, problem: Problem, options: SolveOptions, start: Array | None, on: Device
    ) -> Solution:
        """Return the last stable state; its part `adhesion` has the first unstable load."""
        assert isinstance(problem.resultant, PrescribedLoad)
        last_stable = self.adhesive.solve(problem, options, start, on)
        iterations, convolutions = last_stable.iterations, last_stable.convolutions
        load, first_unstable = problem.resultant.total, -inf
        # just beyond the last stable load the iteration takes long to detach
        options = replace(options, max_iterations=MORE_ITERATIONS * options.max_iterations)
        while last_stable.status in EQUILIBRIUM and (
            first_unstable == -inf or load - first_unstable > self.error * abs(first_unstable)
        ):
            assert last_stable.adhesion is not None
            pull = LOAD_STEP * float(last_stable.adhesion.traction.sum())
            trial = load - pull if first_unstable == -inf else (load + first_unstable) / 2
            lowered = replace(problem, resultant=PrescribedLoad(trial))
            state = self.adhesive.after(last_stable).solve(
                lowered, options, last_stable.pressure, on
            )
            iterations += state.iterations
            convolutions += state.convolutions
            if state.status is Status.DETACHED:
                first_unstable = trial
            else:
                load, last_stable = trial, state
        assert last_stable.adhesion is not None
        line = problem.grid.cell_area / problem.grid.period
        part = replace(
            last_stable.adhesion,
            branch=self.adhesive.branch.value,
            first_unstable_load=first_unstable * line if first_unstable > -inf else None,
        )
        return replace(last_stable, iterations=iterations, convolutions=convolutions, adhesion=part)


# Outcomes in which a state is one of equilibrium.
EQUILIBRIUM = (Status.CONVERGED, Status.CONTACT_AT_EDGE, Status.ATTRACTION_AT_EDGE)


@dataclass(frozen=True, eq=False)
class _State:
    """Contact under a frozen `traction` (x, y) [Pa].

    `traction_displacement` (x, y) [m] is the displacement of the surface by it, `following` the traction (x, y) [Pa] at
    its gap, `change` the distance to that over its sum, `energy` [J] that of the elastic bodies, the load and the work
    of adhesion, and `cohesion` [J] the last alone.
    """

    contact: Solution
    traction: Array
    traction_displacement: Array
    following: Array
    change: float
    energy: float
    cohesion: float


@dataclass(eq=False)
class _Passes:
    """Passes over the traction of one problem, and what they took."""

    problem: Problem
    law: CohesiveLaw
    depth: int
    options: SolveOptions
    on: Device
    count: int = 0
    iterations: int = 0
    convolutions: float = 0.0
    energies: list[float] = field(default_factory=list)

    def solution(self, adhesive: Adhesive, traction: Array, start: Array | None) -> Solution:
        """Return the solution that the passes from a `traction` (x, y) [Pa] lead to."""
        tolerance = CHANGE * self.options.tolerance
        loosest = 0.0 if self.depth == 0 or self._too_weak() else LOOSEST
        inner = loosest
        pressure, last = start, None
        tractions: list[Array] = []
        changes: list[Array] = []
        plain, cautious, mixed = PLAIN_PASSES, PLAIN_PASSES, False
        while True:
            load = self._carried(traction)
            if load <= 0 and not mixed:
                return self._detached(adhesive, last)
            traction_displacement = self.problem.operator(traction)
            self.convolutions += 1
            if last is not None and self._negligible(traction, traction_displacement, last):
                return self._ended(adhesive, replace(last, change=0.0))
            state = (
                self._solve_frozen(traction, traction_displacement, load, pressure, inner)
                if load > 0
                else None
            )
            if state is not None and not np.isfinite(state.contact.residual):
                return self._ended(adhesive, state)
            if mixed and (
                state is None or (last is not None and state.energy > _allowed(last, state))
            ):
                # not downhill: back to the traction that the last accepted state leads to
                assert last is not None
                traction, mixed = last.following, False
                tractions, changes = [], []
                plain, cautious = cautious, 2 * cautious
                continue
            assert state is not None
            last, pressure = state, state.contact.pressure
            self.energies.append(state.energy)
            exact = self._inner(inner) <= self.options.tolerance
            if (state.change <= tolerance and exact) or self._limit_reached():
                return self._ended(adhesive, state)
            if state.change <= tolerance:
                inner = 0.0  # once more, to the tolerance of the contact
                continue
            inner = min(max(state.change, tolerance) / 10, loosest)
            tractions = [*tractions, state.traction][-self.depth - 1 :]
            changes = [*changes, state.following - state.traction][-self.depth - 1 :]
            plain -= 1
            mixed = plain < 0 and len(changes) > 1
            traction = state.following
            if mixed:
                mixture = anderson_mixture(tractions, changes)
                traction = np.clip(mixture, 0, self.law.strength)

    def _too_weak(self) -> bool:
        """Return whether the largest traction everywhere is too little to be felt: one pass may be all there is."""
        load = self.problem.resultant
        most = self.law.strength * self.problem.undeformed_gap.size
        return isinstance(load, PrescribedLoad) and most < self.options.tolerance * load.total

    def _carried(self, traction: Array) -> float:
        """Return the load of the pressure alone, over the area of a cell [Pa]; infinite under a given approach."""
        resultant = self.problem.resultant
        if not isinstance(resultant, PrescribedLoad):
            return inf
        return resultant.total + float(traction.sum())

    def _inner(self, fraction: float) -> float:
        """Return the dimensionless tolerance of a contact whose gap may be wrong by a `fraction` of the range."""
        allowed = fraction * self.law.range / self.problem.scales.gap
        return max(self.options.tolerance, allowed)

    def _limit_reached(self) -> bool:
        """Return whether the iterations of all passes have reached their limit."""
        return self.iterations + self.count > self.options.max_iterations

    def _negligible(self, traction: Array, traction_displacement: Array, last: _State) -> bool:
        """Return whether a `traction` leaves the contact of the `last` state as it is, by far within the tolerance."""
        problem, allowed = self.problem, NEGLIGIBLE * self.options.tolerance
        change = float(np.abs(traction_displacement - last.traction_displacement).max())
        added = float(np.abs(traction - last.traction).sum())
        exact = last.contact.residual <= self.options.tolerance
        carried = float(last.contact.pressure.sum())
        return exact and change <= allowed * problem.scales.gap and added <= allowed * carried

    def _solve_frozen(
        self,
        traction: Array,
        traction_displacement: Array,
        load: float,
        pressure: Array | None,
        fraction: float,
    ) -> _State:
        """Return the contact under a frozen `traction`, from a `pressure` (x, y) [Pa]."""
        problem, law = self.problem, self.law
        resultant = problem.resultant if load == inf else PrescribedLoad(load)
        frozen = replace(
            problem,
            undeformed_gap=problem.undeformed_gap - traction_displacement,
            resultant=resultant,
            adhesion=None,
        )
        options = replace(self.options, tolerance=self._inner(fraction))
        contact = solve_contact(frozen, options, pressure, self.on)
        self.count += 1
        self.iterations += contact.iterations
        self.convolutions += contact.convolutions
        following = law.traction(contact.gap)
        total = float(following.sum())
        change = float(np.abs(following - traction).sum())
        area = problem.grid.cell_area
        cohesion = area * float(law.remaining_work(contact.gap).sum())
        net, displacement = (
            contact.pressure - traction,
            contact.displacement - traction_displacement,
        )
        energy = area * dot(net, displacement) / 2 - cohesion
        if load != inf:
            energy -= area * (load - float(traction.sum())) * contact.approach
        relative = change / total if total else change
        return _State(
            contact, traction, traction_displacement, following, relative, energy, cohesion
        )

    def _ended(self, adhesive: Adhesive, state: _State) -> Solution:
        """Return the solution of the last `state`."""
        contact, problem = state.contact, self.problem
        edge = _edge_fraction(state.traction, problem)
        residual = max(contact.residual, state.change / CHANGE)
        status = contact.status
        if status is Status.CONVERGED and residual > self.options.tolerance:
            status = Status.ITERATION_LIMIT
        elif status is Status.CONVERGED and not contact.pressure.any():
            status = Status.DETACHED
        elif status is Status.CONVERGED and edge > EDGE:
            status = Status.ATTRACTION_AT_EDGE
        return replace(
            contact,
            problem=problem,
            displacement=contact.displacement - state.traction_displacement,
            status=status,
            iterations=self.iterations,
            convolutions=self.convolutions,
            residual=residual,
            adhesion=self._part(adhesive, state.traction, tuple(self.energies)),
        )

    def _detached(self, adhesive: Adhesive, last: _State | None) -> Solution:
        """Return the bodies far apart: no traction carries the load."""
        problem = self.problem
        nothing = np.zeros_like(problem.undeformed_gap)
        return Solution(
            problem=problem,
            pressure=nothing,
            displacement=nothing.copy(),
            gap=problem.undeformed_gap - problem.undeformed_gap.min(),
            approach=float(problem.undeformed_gap.min()),
            status=Status.DETACHED,
            iterations=self.iterations,
            convolutions=self.convolutions,
            residual=0.0,
            adhesion=self._part(adhesive, nothing, (0.0,)),
        )

    def _part(
        self, adhesive: Adhesive, traction: Array, energies: tuple[float, ...]
    ) -> CohesiveTraction:
        """Return the part of a solution that adhesion adds."""
        return CohesiveTraction(
            traction=traction,
            branch=adhesive.branch.value,
            energies=energies,
            cells_in_zone=adhesive.cells_in_zone,
            tabor=adhesive.tabor,
            regularised=adhesive.regularised,
            passes=self.count,
            range=self.law.range,
        )


def _allowed(last: _State, state: _State) -> float:
    """Return the energy [J] up to which a mixture is accepted: that before, and what the change left open."""
    return last.energy + state.change**2 * state.cohesion


def _edge_fraction(traction: Array, problem: Problem) -> float:
    """Return the largest traction in the rows at open edges, over the largest of all."""
    rows = [traction[row] for row in problem.open_edges]
    rows += [traction[:, row] for row in problem.open_ends]
    largest = float(traction.max())
    return max((float(row.max()) for row in rows), default=0.0) / largest if largest else 0.0

"""Internal variables of bodies and interfaces, their update in a time step, and the contacts on the way.

Each has its state before the first load (``start``), what it contributes to the problem at the end of a step
(``contribution``), its state there (``update``), and the fields of a state that a user is shown (``fields``). A
contribution and an update follow from the state and the pressure (x, y) [Pa], less the attraction, at the start of the
step; an update from the pressure at its end too. States are never changed in place: a step may be tried and rejected.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import exp, expm1

import numpy as np

from contactstudy.domain.grid import Array
from contactstudy.elasticity.coefficients import Coefficients
from contactstudy.elasticity.viscoelastic import Creep
from contactstudy.problem.problem import Field, Problem
from contactstudy.solvers.solution import Solution, unloaded
from contactstudy.solvers.solve import SolveOptions, solve_contact

# The arrays that a state variable keeps, by name: all that a checkpoint needs of it.
State = Mapping[str, Array]
# Factor on the tolerance of a contact that is solved together with a state variable, into which its error goes.
COUPLED_TOLERANCE_FACTOR = 0.01


@dataclass(frozen=True)
class Step:
    """A step in time, or a jump of the load where it starts and ends at one instant.

    Attributes
    ----------
    start, end
        Time [s].
    loads
        Load [N/m] at the start and at the end.
    mean_load
        Mean load [N/m] over the step.
    explicit
        Fraction of the step in which an interface changes under the pressure at its start; in the remaining fraction it
        changes under the pressure at its end.
    """

    start: float
    end: float
    loads: tuple[float, float]
    mean_load: float
    explicit: float = 0.0

    @property
    def duration(self) -> float:
        """Duration of the step [s]; 0 for a jump."""
        return self.end - self.start


@dataclass(frozen=True)
class Contribution:
    """Contribution of a state variable to the problem at the end of a step.

    Attributes
    ----------
    gap
        Added to the undeformed gap (x, y) [m]; None adds nothing.
    convolved
        Past pressures times creep compliance (x, y) [-], to be convolved with influence coefficients [m] and added to
        the gap.
    compliance
        Added to the weights [1/Pa] of coefficients in the operator.
    local_compliance
        Displacement of a cell over its own pressure [m/Pa], one number or (x, y), added to the operator.
    """

    gap: Array | None = None
    convolved: Mapping[Coefficients, Array] = field(default_factory=dict)
    compliance: Mapping[Coefficients, float] = field(default_factory=dict)
    local_compliance: float | Array = 0.0


@dataclass(frozen=True)
class CreepState:
    """Internal variables of a viscoelastic body: retarded pressures, and the impulse of a body that flows (Maxwell).

    Retarded pressures follow ``c_i' = (p - c_i) / lambda_i``; the impulse is the time integral ``b' = p``. The surface
    moves as under ``J_0 p + sum(J_i c_i) + fluidity b``. Steps are exact for a pressure that is linear in time.

    Attributes
    ----------
    creep
        Creep function of the body, with weights [1/Pa].
    coefficients
        Influence coefficients [m] of its surface.
    """

    creep: Creep
    coefficients: Coefficients

    def start(self, shape: tuple[int, ...]) -> State:
        """Return retarded pressures and impulse of zero on `shape` cells (x, y), or of several fields."""
        names = [f"retarded{number}" for number in range(len(self.creep.terms))]
        names += ["impulse"] * bool(self.creep.fluidity)
        return {name: np.zeros(shape) for name in names}

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """Return the hereditary term of past pressures, and the compliance for the pressure at the end of the step."""
        weighted, compliance = self.hereditary_terms(state, pressure, step.duration)
        return Contribution(convolved={self.coefficients: weighted}, compliance={self.coefficients: compliance})

    def hereditary_terms(self, state: State, pressure: Array, duration: float) -> tuple[Array, float]:
        """Return the past pressures times their creep compliance after a `duration` [s], and the compliance of the next.

        Parameters
        ----------
        state
            State before.
        pressure
            Pressure before [Pa], of the shape of the state's fields.
        duration
            Time in which the pressure changes linearly to the next [s].
        """
        weighted = np.zeros_like(pressure)
        compliance = 0.0
        for number, (size, time) in enumerate(self.creep.terms):
            from_state, from_start, from_end = retardation_weights(duration / time)
            weighted += (size * from_state) * state[f"retarded{number}"]
            weighted += (size * from_start) * pressure
            compliance += size * from_end
        if self.creep.fluidity:
            half = self.creep.fluidity * duration / 2
            weighted += self.creep.fluidity * state["impulse"] + half * pressure
            compliance += half
        return weighted, compliance

    def update(self, state: State, before: Array, after: Array, step: Step) -> State:
        """Return the retarded pressures [Pa] and the impulse [Pa s] at the end of the step."""
        retarded: dict[str, Array] = {}
        for number, (_, time) in enumerate(self.creep.terms):
            from_state, from_start, from_end = retardation_weights(step.duration / time)
            retarded[f"retarded{number}"] = (
                from_state * state[f"retarded{number}"] + from_start * before + from_end * after
            )
        if self.creep.fluidity:
            retarded["impulse"] = state["impulse"] + step.duration / 2 * (before + after)
        return retarded

    def fields(self, state: State) -> Mapping[str, Field]:
        """Return no fields: retarded pressures are not shown to users."""
        return {}


def retardation_weights(ratio: float) -> tuple[float, float, float]:
    """Return the weights of the retarded pressure, the pressure before and the pressure after, in a step of creep.

    They are ``e``, ``f - e`` and ``1 - f`` with ``e = exp(-ratio)`` and ``f = (1 - e) / ratio``. They add up to 1 and
    none is negative.

    Parameters
    ----------
    ratio
        Duration of the step over the retardation time lambda.
    """
    from_state = exp(-ratio)
    if ratio < 1e-3:  # where the quotient would cancel
        from_end = ratio / 2 - ratio**2 / 6 + ratio**3 / 24
        return from_state, -expm1(-ratio) - from_end, from_end
    from_end = 1 + expm1(-ratio) / ratio
    return from_state, -expm1(-ratio) - from_end, from_end


@dataclass(frozen=True)
class WearState:
    """State variable of wear: the wear depth w, with ``dw/dt = k v p`` (Archard 1953).

    The pressure at the start of a step acts in its explicit fraction, the pressure at its end in the remaining one,
    which adds a constant to the diagonal of the operator. The wear volume is exact where the load changes within the
    step: both pressures are scaled down to the mean load, or the weight of the pressure at the start is raised, and
    then that of the pressure at the end.

    Attributes
    ----------
    rate_per_pressure
        Depth over pressure and time [m/(Pa s)]: the specific wear rate times the sliding speed.
    body
        Index in ``Scene.solids`` of the body that wears.
    """

    rate_per_pressure: float
    body: int = 0

    def start(self, shape: tuple[int, int]) -> State:
        """Return a wear depth of zero on `shape` cells (x, y)."""
        return {"wear_depth": np.zeros(shape)}

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """Return the depth worn so far as a gap, and the wear by the pressure at the end as a local compliance."""
        explicit, implicit = self._depths_per_pressure(step)
        worn = state["wear_depth"]
        if explicit:
            worn = worn + explicit * pressure
        return Contribution(gap=worn, local_compliance=implicit)

    def update(self, state: State, before: Array, after: Array, step: Step) -> State:
        """Return the wear depth at the end of the step."""
        explicit, implicit = self._depths_per_pressure(step)
        worn = state["wear_depth"] + implicit * after
        return {"wear_depth": worn + explicit * before if explicit else worn}

    def fields(self, state: State) -> Mapping[str, Field]:
        """Return the wear depth (x, y) [m]."""
        return {"wear_depth": Field(("x", "y"), state["wear_depth"], "m", "wear depth")}

    def _depths_per_pressure(self, step: Step) -> tuple[float, float]:
        """Return depth over pressure [m/Pa] worn in the step by the pressure at its start and by that at its end."""
        (first, last), mean, explicit = step.loads, step.mean_load, step.explicit
        depth = self.rate_per_pressure * step.duration
        weighted_load = explicit * first + (1 - explicit) * last
        if weighted_load >= mean:
            scale = mean / weighted_load if weighted_load else 0.0
            return depth * explicit * scale, depth * (1 - explicit) * scale
        if last == 0:
            return depth * (mean / first if first else 0.0), 0.0

        # at most half of the implicit fraction becomes explicit, so that the step stays stable
        additional = min((mean - weighted_load) / first, (1 - explicit) / 2) if first else 0.0
        explicit += additional
        return depth * explicit, depth * (mean - explicit * first) / last


def least_eigenvalue(contact_modulus: float, cell: float) -> float:
    """Return the smallest eigenvalue [m/Pa] of the influence matrix of touching cells, ``0.742 cell / contact_modulus``.

    It is that of plane strain, with the width of a cell [m] across and the contact modulus E* [Pa]; cells that are
    also short along the length have a smaller one.
    """
    return 0.742 * cell / contact_modulus


def solved_or_unloaded(options: SolveOptions, problem: Problem, start: Array | None = None) -> Solution:
    """Return the solution of `problem`; without load, the undeformed bodies that just touch.

    Parameters
    ----------
    options
        How the problem is solved.
    problem
        The contact.
    start
        Pressure (x, y) [Pa] to begin with; None or zero begins on coarser grids.
    """
    if problem.adhesion is None and problem.control.uniform(1) == 0:
        return unloaded(problem)
    begin = start if start is not None and start.any() else None
    return solve_contact(problem, options, begin)


@dataclass(eq=False)
class WarmStartedContact:
    """The contact of `problem` with a field added to its gap, each time solved from the `last` pressure (x, y) [Pa].

    Its tolerance is that of `options` times `COUPLED_TOLERANCE_FACTOR`.
    """

    problem: Problem
    options: SolveOptions
    last: Array

    def __call__(self, added_gap: Array) -> Solution:
        """Return the contact with `added_gap` (x, y) [m] added to its gap."""
        tolerance = COUPLED_TOLERANCE_FACTOR * self.options.tolerance
        options = replace(self.options, tolerance=tolerance)
        solution = solved_or_unloaded(options, with_added_gap(self.problem, added_gap), self.last)
        self.last = solution.pressure
        return solution


def with_added_gap(problem: Problem, added_gap: Array) -> Problem:
    """Return `problem` with `added_gap` (x, y) [m] added to its undeformed gap."""
    return replace(problem, undeformed_gap=problem.undeformed_gap + added_gap)

"""What a body or an interface keeps from one instant to the next, and what it makes of it in a step."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, expm1
from typing import ClassVar, Protocol

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.coefficients import Coefficients
from contactstudy.elasticity.viscoelastic import Creep
from contactstudy.problem.problem import Field, Problem
from contactstudy.solvers.solution import Solution

# The fields (x, y) that a memory keeps, by name: all that a checkpoint needs of it.
State = Mapping[str, Array]
# From the lift of a surface (x, y) [m] to the contact over it.
Contact = Callable[[Array], Solution]


@dataclass(frozen=True)
class Step:
    """From ``start`` to ``end`` [s], a jump of the load if these are one; ``loads`` [N/m] before and after.

    ``mean_load`` [N/m] is that over the step. ``explicit`` is the share of the step in which an interface changes
    under the pressure before it; in the rest it changes under the one after.
    """

    start: float
    end: float
    loads: tuple[float, float]
    mean_load: float
    explicit: float = 0.0

    @property
    def duration(self) -> float:
        """[s]"""
        return self.end - self.start


@dataclass(frozen=True)
class Contribution:
    """What a memory adds to the problem at the end of a step.

    ``gap`` (x, y) [m] is added to the undeformed gap. ``strained`` (x, y) [-] are fields to be convolved with their
    coefficients [m], and added to it too. ``compliance`` [1/Pa] is added to the weights of coefficients in
    the operator, ``own`` [m/Pa] to the displacement of each cell under its own pressure.
    """

    gap: Array | None = None
    strained: Mapping[Coefficients, Array] = field(default_factory=dict)
    compliance: Mapping[Coefficients, float] = field(default_factory=dict)
    own: float = 0.0


class Kept(Protocol):
    """What a body or an interface keeps.

    States are never changed in place: a step may be tried and rejected.
    """

    @property
    def has_stages(self) -> bool:
        """Whether the stages of a :class:`~contactstudy.evolution.steps.Scheme` make a step better."""
        ...

    def start(self, shape: tuple[int, int]) -> State:
        """What is kept before the first load."""
        ...

    def fields(self, state: State) -> Mapping[str, Field]:
        """What of it is worth to be shown, by name."""
        ...


class Memory(Kept, Protocol):
    """What changes in a step as the pressures at its ends say."""

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """To the problem at the end of ``step``, from the state and the ``pressure`` [Pa] at its start."""
        ...

    def advance(self, state: State, before: Array, after: Array, step: Step) -> State:
        """What is kept at the end of ``step``, by the pressures [Pa] at its ends."""
        ...


class JointMemory(Kept, Protocol):
    """What changes in a step together with the pressure at its end, so that both are found at once.

    It depends on the path of the load, not on how fast it is followed.
    """

    def settled(
        self, state: State, problem: Problem, contact: Contact, tolerance: float
    ) -> tuple[Solution, State]:
        """The solution of ``problem`` and what is kept then, from the ``state`` before.

        ``contact`` solves the problem over a surface that is lowered by a field (x, y) [m].
        """
        ...

    def abrupt(self, before: State, after: State) -> bool:
        """Whether a step between these states changed far more than those since the last without change."""
        ...

    def over_time(self, states: Sequence[State], pressures: Sequence[Array]) -> Mapping[str, Field]:
        """What follows from states and pressures of several instants, (time, ...), by name."""
        ...


@dataclass(frozen=True)
class CreepMemory:
    """Delayed pressures c_i with ``c_i' = (p - c_i) / lambda_i``, and for a fluid the impulse ``b' = p``.

    The surface moves as under ``J_0 p + sum(J_i c_i) + fluidity b``, whose weights are those of ``creep`` [1/Pa], by
    the influence ``coefficients`` [m]. Exact for a pressure that is linear in a step.
    """

    creep: Creep
    coefficients: Coefficients

    has_stages: ClassVar[bool] = False

    def start(self, shape: tuple[int, int]) -> State:
        """Nothing."""
        names = [f"delayed{number}" for number in range(len(self.creep.terms))]
        names += ["impulse"] * bool(self.creep.fluidity)
        return {name: np.zeros(shape) for name in names}

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """The part of the strain that the past has fixed, and the compliance of a step so long."""
        strain = np.zeros_like(pressure)
        more = 0.0
        for number, (size, time) in enumerate(self.creep.terms):
            kept, before, after = weights(step.duration / time)
            strain += (size * kept) * state[f"delayed{number}"]
            strain += (size * before) * pressure
            more += size * after
        if self.creep.fluidity:
            half = self.creep.fluidity * step.duration / 2
            strain += self.creep.fluidity * state["impulse"] + half * pressure
            more += half
        return Contribution(
            strained={self.coefficients: strain}, compliance={self.coefficients: more}
        )

    def advance(self, state: State, before: Array, after: Array, step: Step) -> State:
        """The delayed pressures and the impulse at the end of the step."""
        new: dict[str, Array] = {}
        for number, (_, time) in enumerate(self.creep.terms):
            kept, first, last = weights(step.duration / time)
            new[f"delayed{number}"] = (
                kept * state[f"delayed{number}"] + first * before + last * after
            )
        if self.creep.fluidity:
            new["impulse"] = state["impulse"] + step.duration / 2 * (before + after)
        return new

    def fields(self, state: State) -> Mapping[str, Field]:
        """None."""
        return {}


def weights(ratio: float) -> tuple[float, float, float]:
    """How the delayed pressure after ``ratio`` = step / lambda is made of itself, p before and p after.

    They add up to 1 and none is negative: ``e, f - e, 1 - f`` with ``e = exp(-ratio)``, ``f = (1 - e) / ratio``.
    """
    kept = exp(-ratio)
    if ratio < 1e-3:  # where the quotient would cancel
        after = ratio / 2 - ratio**2 / 6 + ratio**3 / 24
        return kept, -expm1(-ratio) - after, after
    after = 1 + expm1(-ratio) / ratio
    return kept, -expm1(-ratio) - after, after


@dataclass(frozen=True)
class WearMemory:
    """The worn depth w, ``dw/dt = rate p`` with ``rate`` [m/(Pa s)].

    The pressure before a step acts in its explicit share, the one after in the rest, which adds a constant to
    the operator. The volume is exact: where the load changes within the step, both are scaled to the
    mean load, or what a falling load leaves missing is worn by the pressure before.
    """

    rate: float

    has_stages: ClassVar[bool] = True

    def start(self, shape: tuple[int, int]) -> State:
        """Nothing is worn."""
        return {"worn_depth": np.zeros(shape)}

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """The depth worn so far, and what the pressure to come wears off."""
        before, after = self._shares(step)
        worn = state["worn_depth"]
        if before:
            worn = worn + before * pressure
        return Contribution(gap=worn, own=after)

    def advance(self, state: State, before: Array, after: Array, step: Step) -> State:
        """The depth at the end of the step."""
        first, last = self._shares(step)
        worn = state["worn_depth"] + last * after
        return {"worn_depth": worn + first * before if first else worn}

    def fields(self, state: State) -> Mapping[str, Field]:
        """``worn_depth``."""
        return {"worn_depth": Field(("x", "y"), state["worn_depth"], "m", "worn depth")}

    def _shares(self, step: Step) -> tuple[float, float]:
        """Depth over pressure [m/Pa] that the pressure before the step wears off in it, and the one after."""
        (first, last), mean, explicit = step.loads, step.mean_load, step.explicit
        whole = self.rate * step.duration
        carried = explicit * first + (1 - explicit) * last
        if carried >= mean:
            scale = mean / carried if carried else 0.0
            return whole * explicit * scale, whole * (1 - explicit) * scale
        if last == 0:
            return whole * (mean / first if first else 0.0), 0.0
        # no more than half of the rest explicitly, so that it stays stable
        more = min((mean - carried) / first, (1 - explicit) / 2) if first else 0.0
        explicit += more
        return whole * explicit, whole * (mean - explicit * first) / last


def explicit_limit(rate: float, contact_modulus: float, cell: float) -> float:
    """The longest step [s] of an explicit scheme in plane strain: ``1.48 dx / (rate E*)``.

    ``rate`` [m/(Pa s)], E* [Pa], ``cell`` dx [m]. The smallest eigenvalue of the influence matrix of touching cells is
    0.742 dx / E*, and an explicit step must be shorter than twice that over the rate.
    """
    return 1.484 * cell / (rate * contact_modulus)

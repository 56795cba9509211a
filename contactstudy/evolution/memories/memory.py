"""What a body or an interface keeps from one instant to the next, and what it makes of it in a step."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from contactstudy.domain.fields import Array
from contactstudy.elasticity.coefficients import Coefficients
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
        """Whether the stages of a :class:`~contactstudy.evolution.scheme.Scheme` make a step better."""
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

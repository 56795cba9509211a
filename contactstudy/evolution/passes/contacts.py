"""The pressure that rolls over a half-space, whatever its surface has become."""

from dataclasses import dataclass, replace
from enum import Enum
from typing import Protocol

from contactstudy.domain.fields import Array
from contactstudy.evolution.march import LoweredContact, SolverOptions, lowered, unloaded
from contactstudy.problem.problem import Problem
from contactstudy.solvers.settle import ContactTangent, Tangent
from contactstudy.solvers.solution import Solution


class RollingPressure(Enum):
    """What pressure rolls over a half-space."""

    SETTLED = "that of the contact, which plastic strain changes"
    ELASTIC = "that of the elastic contact, whatever yields, as Merwin & Johnson (1963) assume"


class Contact(Protocol):
    """A contact over a surface that is lowered."""

    def __call__(self, lift: Array) -> Solution:
        """Over a surface that is lowered by ``lift`` (x, y) [m]."""
        ...

    def tangent(self, solution: Solution) -> Tangent | None:
        """Its linearisation there; None for a pressure that does not change."""
        ...


class SettledContact(LoweredContact):
    """One that is solved anew for every surface."""

    def tangent(self, solution: Solution) -> Tangent:
        """Of the same cells in contact."""
        return ContactTangent.of(solution, self.options.precision)


@dataclass(frozen=True, eq=False)
class FixedContact:
    """The pressure of ``solution``, which stays as it is."""

    solution: Solution

    def __call__(self, lift: Array) -> Solution:
        """The same pressure."""
        return replace(self.solution, problem=lowered(self.solution.problem, lift))

    def tangent(self, _: Solution) -> None:
        """None: the pressure does not change."""


def rolling_contact(problem: Problem, options: SolverOptions, kind: RollingPressure) -> Contact:
    """Of ``problem``, which is elastic."""
    elastic = options.solved(problem)
    if kind is RollingPressure.ELASTIC:
        return FixedContact(elastic)
    return SettledContact(problem, options, elastic.pressure)


def nothing(problem: Problem) -> FixedContact:
    """No pressure at all."""
    return FixedContact(unloaded(problem))

"""The pressure that rolls over a half-space, whatever its surface has become."""

from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from typing import Protocol

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.eigenstrain.plane_strain import HalfLines, PlaneStrainOperator
from contactstudy.elasticity.eigenstrain.volume import Volume
from contactstudy.evolution.march import LoweredContact, lowered, solved_or_unloaded, unloaded
from contactstudy.evolution.plastic import larger, spread
from contactstudy.problem.problem import Problem
from contactstudy.solvers.settle import ContactTangent, Settled, Tangent, settle
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions
from contactstudy.solvers.yielding_bodies import Hardening, YieldingBodies


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


def rolling_contact(problem: Problem, options: SolveOptions, kind: RollingPressure) -> Contact:
    """Of ``problem``, which is elastic."""
    elastic = solved_or_unloaded(options, problem)
    if kind is RollingPressure.ELASTIC:
        return FixedContact(elastic)
    return SettledContact(problem, options, elastic.pressure)


def nothing(problem: Problem) -> FixedContact:
    """No pressure at all."""
    return FixedContact(unloaded(problem))


@dataclass(frozen=True, eq=False)
class Profile:
    """Plastic ``strain`` (component, layers) and ``equivalent`` plastic strain (layers,) that are the same along x."""

    strain: Array
    equivalent: Array

    def deeper(self, layers: int) -> "Profile":
        """With more layers that have not yielded."""
        return Profile(padded(self.strain, layers), padded(self.equivalent, layers))


def padded(field: Array, layers: int) -> Array:
    """A field (..., layers) with more layers of zeros."""
    shape = *field.shape[:-1], layers - field.shape[-1]
    return np.concatenate((field, np.zeros(shape)), axis=-1)


@dataclass(frozen=True, eq=False)
class Track:
    """Plastic ``strain`` (component, layers, x, 1) and ``equivalent`` plastic strain (layers, x, 1) in a window.

    On the left of the window the half-space has the strain ``behind`` (component, layers) to infinity: a mean over
    what was left there, since all of it as left last would make the strain swing from one width to the
    next. On the right it is as it is ``ahead``.
    """

    surroundings: HalfLines
    hardening: Hardening
    strain: Array
    equivalent: Array
    behind: Array
    ahead: Profile

    @classmethod
    def fresh(cls, operator: PlaneStrainOperator, hardening: Hardening) -> "Track":
        """One that has not yielded."""
        cells = operator.volume.shape
        strain, equivalent = np.zeros((len(operator.basis), *cells)), np.zeros(cells)
        profile = Profile(strain[:, :, 0, 0], equivalent[:, 0, 0])
        return cls(HalfLines(operator), hardening, strain, equivalent, profile.strain, profile)

    @property
    def operator(self) -> PlaneStrainOperator:
        """On plastic strain in the window."""
        return self.surroundings.operator

    @property
    def left(self) -> Profile:
        """What the window is about to leave behind."""
        return Profile(self.strain[:, :, 0, 0], self.equivalent[:, 0, 0])

    def rolled(self, share: float) -> "Track":
        """With the half-space one cell further to the left, of which what is behind takes on a ``share``."""
        strain, equivalent = np.roll(self.strain, -1, axis=2), np.roll(self.equivalent, -1, axis=1)
        strain[:, :, -1, 0], equivalent[:, -1, 0] = self.ahead.strain, self.ahead.equivalent
        behind = self.behind + share * (self.left.strain - self.behind)
        return replace(self, strain=strain, equivalent=equivalent, behind=behind)

    def settled(self, contact: Contact, tolerance: float, length: float) -> tuple["Track", Settled]:
        """After a step with a ``contact`` over a lowered surface; deeper, where it yields down to its last layer.

        ``length`` [m] is that of the contact, which layers are made for.
        """
        track = self
        while True:
            operator, around = track.operator, track.surroundings
            bodies = YieldingBodies((operator,), (track.hardening,))
            found = settle(
                bodies,
                partial(_over, contact, around.lift(track.behind, track.ahead.strain)),
                contact.tangent,
                bodies.joined([track.strain]),
                bodies.joined([track.equivalent]),
                tolerance,
                bodies.joined([around.stress(track.behind, track.ahead.strain)]),
            )
            (flow,) = bodies.parted(found.flow)
            volume = operator.volume
            if not flow[-1].any():
                break
            deeper = larger(replace(volume, first=0, last=volume.grid.cells[0]), length, flow > 0)
            track = track.deeper(deeper)
        (strain,) = bodies.parted(found.strain)
        return replace(track, strain=strain, equivalent=track.equivalent + flow), found

    def deeper(self, volume: Volume) -> "Track":
        """In a larger ``volume``, which has not yielded there."""
        layers = volume.shape[0]
        return Track(
            HalfLines(PlaneStrainOperator(volume, self.operator.moduli)),
            self.hardening,
            spread(self.strain, 0, volume),
            spread(self.equivalent, 0, volume),
            padded(self.behind, layers),
            self.ahead.deeper(layers),
        )

    def residual_stress(self) -> Array:
        """All stresses (6, layers, x, 1) [Pa] in the window, without pressure."""
        around = self.surroundings.tensor(self.behind, self.ahead.strain)
        return self.operator.tensor_of_strain(self.strain) + around


def _over(contact: Contact, lowered: Array, lift: Array) -> Solution:
    """A contact over a surface that is lowered twice."""
    return contact(lowered + lift)

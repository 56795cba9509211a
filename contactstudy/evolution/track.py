"""The half-space below a grid that moves with the contact: its plastic strain, and a step of its change."""

from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from contactstudy.domain.device import Precision
from contactstudy.domain.grid import Array
from contactstudy.elasticity.eigenstrain.half_space_wave import Volume
from contactstudy.elasticity.eigenstrain.plane_strain_operator import OuterStrain, PlaneStrainOperator
from contactstudy.evolution.states.plastic import embedded, enlarged
from contactstudy.evolution.states.state_variables import WarmStartedContact, with_added_gap
from contactstudy.solvers.plasticity import (
    ContactTangent,
    ElastoplasticStep,
    Hardening,
    Tangent,
    YieldingBodies,
    solve_elastoplastic_step,
)
from contactstudy.solvers.solution import Solution


class ContactWithAddedGap(Protocol):
    """Protocol of a contact that is solved with a field added to its gap."""

    def __call__(self, added_gap: Array) -> Solution:
        """Return the contact with `added_gap` (x, y) [m] added to its gap."""

    def tangent(self, solution: Solution) -> Tangent | None:
        """Return the linearised contact at `solution`; None if its pressure never changes."""


class SolvedContact(WarmStartedContact):
    """A contact that is solved for each added gap."""

    def tangent(self, solution: Solution) -> Tangent:
        """Return the linearised contact in which the same cells stay in contact."""
        return ContactTangent.from_solution(solution, Precision(self.options.precision))


@dataclass(frozen=True, eq=False)
class FixedContact:
    """A contact whose pressure stays that of `solution`, whatever the surface."""

    solution: Solution

    def __call__(self, added_gap: Array) -> Solution:
        """Return `solution` with `added_gap` (x, y) [m] added to the undeformed gap of its problem."""
        return replace(self.solution, problem=with_added_gap(self.solution.problem, added_gap))

    def tangent(self, _: Solution) -> None:
        """Return None, since the pressure does not change."""


@dataclass(frozen=True, eq=False)
class DepthProfile:
    """Plastic strain over depth that is the same along x.

    Attributes
    ----------
    strain
        Plastic strain (component, layers), in the basis of the moving grid's operator.
    equivalent
        Equivalent plastic strain (layers,).
    """

    strain: Array
    equivalent: Array

    def deeper(self, layers: int) -> "DepthProfile":
        """Return the profile with `layers` layers in all; the added ones have not yielded."""
        return DepthProfile(with_zero_layers(self.strain, layers), with_zero_layers(self.equivalent, layers))


def with_zero_layers(field: Array, layers: int) -> Array:
    """Return a field (..., layers) with zeros appended up to `layers` layers."""
    shape = *field.shape[:-1], layers - field.shape[-1]
    return np.concatenate((field, np.zeros(shape)), axis=-1)


@dataclass(frozen=True, eq=False)
class Track:
    """A half-space in plane strain over which a contact rolls, seen on a grid that moves with the contact.

    Attributes
    ----------
    outer_strain
        Influence of the half-space outside the moving grid.
    hardening
        Yield stress and hardening moduli [Pa].
    strain
        Plastic strain (component, layers, x, 1) in the moving grid.
    equivalent
        Equivalent plastic strain (layers, x, 1) in the moving grid.
    mean_strain_behind
        Plastic strain (component, layers) from the left edge of the moving grid to infinity: a running mean of the
        strain that left the moving grid. The last strain alone would make it oscillate with the period of the moving
        grid.
    front
        The half-space on the right of the moving grid.
    """

    outer_strain: OuterStrain
    hardening: Hardening
    strain: Array
    equivalent: Array
    mean_strain_behind: Array
    front: DepthProfile

    @classmethod
    def virgin(cls, operator: PlaneStrainOperator, hardening: Hardening) -> "Track":
        """Return a virgin track, without plastic strain."""
        cells = operator.volume.shape
        strain, equivalent = np.zeros((len(operator.basis), *cells)), np.zeros(cells)
        profile = DepthProfile(strain[:, :, 0, 0], equivalent[:, 0, 0])
        return cls(OuterStrain(operator), hardening, strain, equivalent, profile.strain, profile)

    @property
    def operator(self) -> PlaneStrainOperator:
        """Operator on plastic strain in the moving grid."""
        return self.outer_strain.operator

    @property
    def left_profile(self) -> DepthProfile:
        """Profile at the left edge of the moving grid, which leaves it in the next step."""
        return DepthProfile(self.strain[:, :, 0, 0], self.equivalent[:, 0, 0])

    def rolled(self, weight: float) -> "Track":
        """Return the track after the contact has rolled by one cell.

        Parameters
        ----------
        weight
            Weight of the strain that leaves the moving grid in the mean strain behind it.
        """
        strain, equivalent = np.roll(self.strain, -1, axis=2), np.roll(self.equivalent, -1, axis=1)
        strain[:, :, -1, 0], equivalent[:, -1, 0] = self.front.strain, self.front.equivalent
        mean_strain_behind = self.mean_strain_behind + weight * (self.left_profile.strain - self.mean_strain_behind)
        return replace(self, strain=strain, equivalent=equivalent, mean_strain_behind=mean_strain_behind)

    def solve_step(
        self, contact: ContactWithAddedGap, tolerance: float, length: float
    ) -> tuple["Track", ElastoplasticStep]:
        """Solve a step: the contact, and the plastic strain below it.

        Layers are added while the last one yields.

        Parameters
        ----------
        contact
            Solves the contact with a field added to its gap.
        tolerance
            Largest relative residual.
        length
            Length scale of the contact [m], for which layers are made.

        Returns
        -------
        tuple of Track and ElastoplasticStep
            The track after the step, and the contact with its residual and work.
        """
        track = self
        while True:
            operator, outer_strain = track.operator, track.outer_strain
            bodies = YieldingBodies((operator,), (track.hardening,))
            outside = track.mean_strain_behind, track.front.strain
            outer_gap = outer_strain.residual_displacement(*outside)
            step = solve_elastoplastic_step(
                bodies,
                partial(_with_outer_gap, contact, outer_gap),
                contact.tangent,
                bodies.concatenated([track.strain]),
                bodies.concatenated([track.equivalent]),
                tolerance,
                bodies.concatenated([outer_strain.stress(*outside)]),
            )
            (flow,) = bodies.split(step.equivalent_increment)
            volume = operator.volume
            if not flow[-1].any():
                break
            deeper_volume = enlarged(replace(volume, first=0, last=volume.grid.cells[0]), length, flow > 0)
            track = track.deeper(deeper_volume)
        (strain,) = bodies.split(step.strain)
        return replace(track, strain=strain, equivalent=track.equivalent + flow), step

    def deeper(self, volume: Volume) -> "Track":
        """Return the track in a larger `volume`, whose added layers have not yielded."""
        layers = volume.shape[0]
        return Track(
            OuterStrain(PlaneStrainOperator(volume, self.operator.moduli)),
            self.hardening,
            embedded(self.strain, 0, volume),
            embedded(self.equivalent, 0, volume),
            with_zero_layers(self.mean_strain_behind, layers),
            self.front.deeper(layers),
        )

    def residual_stress(self) -> Array:
        """Return the residual stress (6, layers, x, 1) [Pa] in the moving grid, tension positive."""
        around = self.outer_strain.tensor(self.mean_strain_behind, self.front.strain)
        return self.operator.residual_stress_tensor(self.strain) + around


def _with_outer_gap(contact: ContactWithAddedGap, outer: Array, added_gap: Array) -> Solution:
    """Return a contact with `added_gap` and that by the strain outside the moving grid (x, y) [m] added to its gap."""
    return contact(outer + added_gap)

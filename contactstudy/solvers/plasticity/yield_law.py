"""Von Mises plasticity with linear hardening: the return to the yield surface and its tangent."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.devices.arrays import Array

# |deviator| over von Mises' stress, and equivalent over |plastic strain|.
ROOT = (2 / 3) ** 0.5


@dataclass(frozen=True, eq=False)
class YieldLaw:
    """Per cell (cells,) [Pa]: twice the shear modulus, yield stress, isotropic and kinematic hardening modulus.

    Hardening moduli are stress over plastic strain in tension.
    """

    twice_shear: Array
    yield_stress: Array
    isotropic: Array
    kinematic: Array

    @property
    def slope(self) -> Array:
        """``2/3 (H_i + H_k)`` [Pa]: stress over plastic strain along the flow."""
        return np.asarray(2 / 3 * (self.isotropic + self.kinematic))

    def returned(self, stress: Array, strain: Array, before: Array, equivalent: Array) -> "Return":
        """The step from plastic strain ``before`` (C, cells) that ``stress`` at ``strain`` asks for.

        Radial return (Simo & Hughes 1998, box 3.1): the proximal step 1 / 2G of the energy.
        """
        trial = stress + self.twice_shear * (strain - before) - (2 / 3) * self.kinematic * before
        size = np.sqrt(np.einsum("ck,ck->k", trial, trial))
        limit = ROOT * (self.yield_stress + self.isotropic * equivalent)
        amount = np.maximum(size - limit, 0.0) / (self.twice_shear + self.slope)
        flows = amount > 0
        direction = np.where(flows, trial / np.where(flows, size, 1.0), 0.0)
        return Return(self, before + amount * direction, direction, size, amount, flows)

    def dissipation(self, strain: Array, before: Array, equivalent: Array) -> Array:
        """Per cell [Pa]: what the step to ``strain`` costs in work, with the energy of kinematic hardening."""
        squared = np.einsum("ck,ck->k", strain - before, strain - before)
        limit = ROOT * (self.yield_stress + self.isotropic * equivalent)
        kept = self.kinematic / 3 * np.einsum("ck,ck->k", strain, strain)
        return np.asarray(limit * np.sqrt(squared) + self.isotropic / 3 * squared + kept)


@dataclass(frozen=True, eq=False)
class Return:
    """Plastic ``strain`` (C, cells) on the yield surface, the unit ``direction`` of flow, |trial stress| ``size`` [Pa].

    ``amount`` of flow and whether a cell ``flows`` (cells,).
    """

    law: YieldLaw
    strain: Array
    direction: Array
    size: Array
    amount: Array
    flows: NDArray[np.bool_]

    @property
    def _across(self) -> Array:
        """|trial stress| over amount: the inverse tangent across the flow [Pa]; 0 where nothing flows."""
        return np.asarray(self.size / np.where(self.flows, self.amount, np.inf))

    def inverse_tangent(self, strain: Array) -> Array:
        """The inverse derivative of the return, times ``strain`` (C, cells); cells that do not flow give 0."""
        law, across = self.law, self._across
        along = np.einsum("ck,ck->k", self.direction, strain) * self.direction
        return np.asarray(along * (law.twice_shear + law.slope) + across * (strain - along))

    @property
    def stiffness(self) -> Array:
        """The same without 2G, as matrices of the cells that flow (flowing cells, C, C) [Pa]: not negative."""
        flows, direction = self.flows, self.direction[:, self.flows]
        across = (self._across - self.law.twice_shear)[flows][:, None, None]
        along = self.law.slope[flows][:, None, None]
        dyads = np.einsum("ik,jk->kij", direction, direction)
        return np.asarray(across * np.eye(len(direction)) + (along - across) * dyads)

"""Von Mises plasticity with linear hardening, and the yielding volumes of both bodies as one list of cells."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.fields import Array
from contactstudy.elasticity.eigenstrain.volume import EigenstrainOperator

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


@dataclass(frozen=True)
class Hardening:
    """``yield_stress``, ``isotropic`` and ``kinematic`` hardening modulus of a body [Pa]."""

    yield_stress: float
    isotropic: float
    kinematic: float


@dataclass(frozen=True, eq=False)
class YieldingBodies:
    """The operators on plastic strain of one or two bodies, and how each hardens.

    Fields are (C, cells): the cells of the first body, then those of the second.
    """

    operators: tuple[EigenstrainOperator, ...]
    hardening: tuple[Hardening, ...]

    @cached_property
    def law(self) -> YieldLaw:
        """Of every cell."""
        return YieldLaw(
            self._per_cell([2 * one.moduli.shear for one in self.operators]),
            self._per_cell([one.yield_stress for one in self.hardening]),
            self._per_cell([one.isotropic for one in self.hardening]),
            self._per_cell([one.kinematic for one in self.hardening]),
        )

    @cached_property
    def unit(self) -> Array:
        """Y / E of every cell."""
        bodies = zip(self.operators, self.hardening, strict=True)
        return self._per_cell([h.yield_stress / one.moduli.youngs_modulus for one, h in bodies])

    @cached_property
    def volumes(self) -> Array:
        """(cells,) [m^3]"""
        return self.joined(
            [np.broadcast_to(o.volume.cell_volumes, o.volume.shape) for o in self.operators]
        )

    def self_blocks(self, cells: NDArray[np.bool_]) -> Array:
        """Of the chosen ``cells`` on themselves (chosen cells, C, C) [Pa]."""
        shapes = [one.volume.shape for one in self.operators]
        layers = np.repeat(
            range(sum(n for n, _, _ in shapes)), [nx * ny for n, nx, ny in shapes for _ in range(n)]
        )
        blocks = np.concatenate([one.self_blocks for one in self.operators])
        return np.asarray(blocks[layers[cells]])

    @property
    def cell_area(self) -> float:
        """Of the surface grid [m^2]."""
        return self.operators[0].volume.grid.cell_area

    def joined(self, fields: Sequence[Array]) -> Array:
        """One field of the (..., layers, x, y) of each body."""
        return np.concatenate([one.reshape(*one.shape[:-3], -1) for one in fields], axis=-1)

    def parted(self, field: Array) -> list[Array]:
        """The (..., layers, x, y) of each body."""
        found, start = [], 0
        for one in self.operators:
            end = start + int(np.prod(one.volume.shape))
            found.append(field[..., start:end].reshape(*field.shape[:-1], *one.volume.shape))
            start = end
        return found

    def stress_of_pressure(self, pressure: Array) -> Array:
        """S p [Pa]."""
        return self.joined([one.stress_of_pressure(pressure) for one in self.operators])

    def stress_of_strain(self, strain: Array) -> Array:
        """B e [Pa]."""
        return self._mapped(lambda one, part: one.stress_of_strain(part), strain)

    def lift(self, strain: Array) -> Array:
        """``S^T e`` (x, y) [m] of all bodies together."""
        parts = zip(self.operators, self.parted(strain), strict=True)
        return np.asarray(sum(one.lift(part) for one, part in parts))

    def inner(self, one: Array, other: Array) -> float:
        """Sum over volume [m^3 times their units]."""
        return float(np.einsum("ck,ck,k->", one, other, self.volumes))

    def _mapped(self, of: Callable[[EigenstrainOperator, Array], Array], strain: Array) -> Array:
        parts = zip(self.operators, self.parted(strain), strict=True)
        return self.joined([of(one, part) for one, part in parts])

    def _per_cell(self, values: Sequence[float]) -> Array:
        sizes = [int(np.prod(one.volume.shape)) for one in self.operators]
        return np.repeat(np.array(values, dtype=np.float64), sizes)

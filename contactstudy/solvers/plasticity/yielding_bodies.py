"""Von Mises plasticity with linear hardening, and the yielding volumes of both bodies as one list of cells."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.fields import Array
from contactstudy.elasticity.eigenstrain.volume import EigenstrainOperator

# |deviator| over von Mises' stress, and equivalent over |plastic strain|.
SQRT_TWO_THIRDS = (2 / 3) ** 0.5


@dataclass(frozen=True, eq=False)
class VonMisesPlasticity:
    """Von Mises' yield criterion with linear hardening, with one value per cell (cells,) [Pa].

    `twice_shear_modulus` is 2G. Hardening moduli, `isotropic` and `kinematic`, are stress over plastic strain in
    tension.
    """

    twice_shear_modulus: Array
    yield_stress: Array
    isotropic: Array
    kinematic: Array

    @property
    def deviatoric_hardening(self) -> Array:
        """Hardening of the deviatoric stress along the flow, ``d|s| / d|e| = 2/3 (H_i + H_k)`` (cells,) [Pa]."""
        return np.asarray(2 / 3 * (self.isotropic + self.kinematic))

    def return_mapping(self, stress: Array, strain: Array, strain_n: Array, equivalent_n: Array) -> "ReturnMapping":
        """Return the plastic strain that puts the trial `stress` at `strain` back onto the yield surface.

        `strain_n` (C, cells) and `equivalent_n` (cells,) are the plastic strain and its equivalent at the start of the
        step. Radial return (Simo & Hughes 1998, box 3.1): the proximal step 1 / 2G of the energy.
        """
        trial = stress + self.twice_shear_modulus * (strain - strain_n) - (2 / 3) * self.kinematic * strain_n
        norm = np.sqrt(np.einsum("ck,ck->k", trial, trial))
        limit = SQRT_TWO_THIRDS * (self.yield_stress + self.isotropic * equivalent_n)
        multiplier = np.maximum(norm - limit, 0.0) / (self.twice_shear_modulus + self.deviatoric_hardening)
        flows = multiplier > 0
        direction = np.divide(trial, norm, out=np.zeros_like(trial), where=flows)
        return ReturnMapping(self, strain_n + multiplier * direction, direction, norm, multiplier, flows)

    def incremental_potential(self, strain: Array, strain_n: Array, equivalent_n: Array) -> Array:
        """Return the potential of the step from `strain_n` to `strain`, per volume (cells,) [Pa].

        It is the work that the yield stress dissipates in the step, with the energy of isotropic hardening in the step
        and that of kinematic hardening at its end.
        """
        squared = np.einsum("ck,ck->k", strain - strain_n, strain - strain_n)
        limit = SQRT_TWO_THIRDS * (self.yield_stress + self.isotropic * equivalent_n)
        stored = self.kinematic / 3 * np.einsum("ck,ck->k", strain, strain)
        return np.asarray(limit * np.sqrt(squared) + self.isotropic / 3 * squared + stored)


@dataclass(frozen=True, eq=False)
class ReturnMapping:
    """Return mapping of a trial stress to the yield surface.

    It has the plastic `strain` (C, cells) on the yield surface, the unit `direction` of flow (C, cells), the `norm` of
    the trial stress (cells,) [Pa], the increment of the plastic `multiplier` in the step (cells,), and whether a cell
    `flows` (cells,).
    """

    law: VonMisesPlasticity
    strain: Array
    direction: Array
    norm: Array
    multiplier: Array
    flows: NDArray[np.bool_]

    @property
    def _transverse(self) -> Array:
        """Inverse derivative transverse to the flow, ``|trial| / multiplier`` (cells,) [Pa]; 0 where nothing flows."""
        return np.asarray(self.norm / np.where(self.flows, self.multiplier, np.inf))

    def inverse_derivative(self, strain: Array) -> Array:
        """Return the inverse derivative of the return mapping times `strain` (C, cells) [Pa]; 0 where nothing flows."""
        law, transverse = self.law, self._transverse
        along = np.einsum("ck,ck->k", self.direction, strain) * self.direction
        return np.asarray(along * (law.twice_shear_modulus + law.deviatoric_hardening) + transverse * (strain - along))

    @property
    def consistent_plastic_moduli(self) -> Array:
        """Inverse derivative of the return mapping less 2G, as matrices (flowing cells, C, C) [Pa].

        They are positive semidefinite. The derivative is that of the plastic strain with respect to the trial stress.
        """
        flows, direction = self.flows, self.direction[:, self.flows]
        transverse = (self._transverse - self.law.twice_shear_modulus)[flows][:, None, None]
        along = self.law.deviatoric_hardening[flows][:, None, None]
        dyads = np.einsum("ik,jk->kij", direction, direction)
        return np.asarray(transverse * np.eye(len(direction)) + (along - transverse) * dyads)


@dataclass(frozen=True)
class Hardening:
    """Yield stress and moduli of isotropic and kinematic hardening of a body [Pa]."""

    yield_stress: float
    isotropic: float
    kinematic: float


@dataclass(frozen=True, eq=False)
class YieldingBodies:
    """Operators on plastic strain of one or two bodies, and how each hardens.

    Fields are (C, cells): the cells of the first body, then those of the second.
    """

    operators: tuple[EigenstrainOperator, ...]
    hardening: tuple[Hardening, ...]

    @cached_property
    def law(self) -> VonMisesPlasticity:
        """Yield criterion and hardening of all cells."""
        return VonMisesPlasticity(
            self._per_cell([2 * operator.moduli.shear for operator in self.operators]),
            self._per_cell([body.yield_stress for body in self.hardening]),
            self._per_cell([body.isotropic for body in self.hardening]),
            self._per_cell([body.kinematic for body in self.hardening]),
        )

    @cached_property
    def yield_strain(self) -> Array:
        """Yield stress over Young's modulus (cells,)."""
        bodies = zip(self.operators, self.hardening, strict=True)
        return self._per_cell([h.yield_stress / o.moduli.youngs_modulus for o, h in bodies])

    @cached_property
    def volumes(self) -> Array:
        """Volume of each cell (cells,) [m^3]."""
        return self.concatenated([np.broadcast_to(o.volume.cell_volumes, o.volume.shape) for o in self.operators])

    def diagonal_blocks(self, cells: NDArray[np.bool_]) -> Array:
        """Return minus the residual stress of each chosen cell by its own unit strain (chosen cells, C, C) [Pa]."""
        shapes = [operator.volume.shape for operator in self.operators]
        layers = np.repeat(range(sum(n for n, _, _ in shapes)), [nx * ny for n, nx, ny in shapes for _ in range(n)])
        blocks = np.concatenate([operator.diagonal_blocks for operator in self.operators])
        return np.asarray(blocks[layers[cells]])

    @property
    def cell_area(self) -> float:
        """Area of a cell of the surface grid [m^2]."""
        return self.operators[0].volume.grid.cell_area

    def concatenated(self, fields: Sequence[Array]) -> Array:
        """Return the fields (..., layers, x, y) of all bodies as one field (..., cells)."""
        return np.concatenate([field.reshape(*field.shape[:-3], -1) for field in fields], axis=-1)

    def split(self, field: Array) -> list[Array]:
        """Return the field (..., layers, x, y) of each body in one `field` (..., cells)."""
        parts, start = [], 0
        for operator in self.operators:
            shape = operator.volume.shape
            end = start + int(np.prod(shape))
            parts.append(field[..., start:end].reshape(*field.shape[:-1], *shape))
            start = end
        return parts

    def stress_of_pressure(self, pressure: Array) -> Array:
        """Return the deviatoric stress S p (C, cells) [Pa] under `pressure` (x, y) [Pa]."""
        return self.concatenated([o.stress_of_pressure(pressure) for o in self.operators])

    def negative_residual_stress(self, strain: Array) -> Array:
        """Return B e, minus the deviatoric residual stress (C, cells) [Pa] of plastic `strain` e."""
        parts = zip(self.operators, self.split(strain), strict=True)
        return self.concatenated([operator.negative_residual_stress(part) for operator, part in parts])

    def residual_displacement(self, strain: Array) -> Array:
        """Return the surface displacement ``S^T e`` (x, y) [m] by plastic `strain`, of all bodies together."""
        parts = zip(self.operators, self.split(strain), strict=True)
        return np.asarray(sum(operator.residual_displacement(part) for operator, part in parts))

    def inner(self, first: Array, second: Array) -> float:
        """Return the inner product of two fields (C, cells), integrated over the volume [m^3 times their units]."""
        return float(np.einsum("ck,ck,k->", first, second, self.volumes))

    def _per_cell(self, values: Sequence[float]) -> Array:
        """Return the `values` of the bodies for every cell (cells,)."""
        sizes = [int(np.prod(operator.volume.shape)) for operator in self.operators]
        return np.repeat(np.array(values, dtype=np.float64), sizes)

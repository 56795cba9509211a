"""Both bodies' yielding volumes as one list of cells."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.eigenstrain.volume import EigenstrainOperator
from contactstudy.solvers.plasticity.yield_law import YieldLaw


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

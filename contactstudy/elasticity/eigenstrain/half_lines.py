"""Plastic strain that goes on unchanged beyond a volume, to infinity on both sides, in plane strain."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import zeta

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.eigenstrain.airy import influence, pressed
from contactstudy.elasticity.eigenstrain.plane_strain import (
    BASIS,
    DERIVATIVES,
    FACTORS,
    ODD,
    PlaneStrainOperator,
)

# Sums of what is odd across go on for so many depths of the volume; the rest is found from its asymptote.
DEPTHS = 16
# Of in-plane components, when x changes its sign.
MIRRORED = np.where(np.arange(len(BASIS)) == ODD, -1.0, 1.0)
# Powers of the distance with which they fall.
POWERS = np.array([3.0, 5.0])


@dataclass(frozen=True, eq=False)
class HalfLines:
    """The surroundings of ``operator``'s volume: one profile (component, layers) on the left of it, one on the right.

    Sums of closed forms over all cells of each side: those of what is even across from the sum over both, in
    closed form; those of what is odd with an asymptote beyond ``DEPTHS``, to 1e-6 of the largest.
    """

    operator: PlaneStrainOperator

    def stress(self, left: Array, right: Array) -> Array:
        """Deviatoric stress (3, layers, x, 1) [Pa] in the volume, without pressure."""
        return -self.operator.deviator(self._taken(left, right))

    def tensor(self, left: Array, right: Array) -> Array:
        """All stresses (6, layers, x, 1) [Pa] in the volume, without pressure."""
        return self.operator.tensor(-self._taken(left, right), None)

    def lift(self, left: Array, right: Array) -> Array:
        """Surface displacement (x, 1) [m] into the body, on a grid that the volume covers."""
        thicknesses, cells = self.operator.volume.thicknesses, self.operator.volume.grid.cells[0]
        sums = self._lifts[..., :cells]
        by_left, by_right = (
            np.einsum("al,alx->x", self.operator.in_plane(profile) * thicknesses, signs * sums)
            for profile, signs in ((left, MIRRORED[:, None, None]), (right, 1.0))
        )
        return np.asarray((by_left + by_right[::-1])[:, None])

    def _taken(self, left: Array, right: Array) -> Array:
        """Minus the in-plane stress (3, layers, x, 1) [Pa]."""
        sums = self._stresses
        mirrored = np.multiply.outer(MIRRORED, MIRRORED)[:, None, :, None, None]
        by_left = np.einsum("iljmx,jm->ilx", sums, self.operator.in_plane(left))
        by_right = np.einsum("iljmx,jm->ilx", mirrored * sums, self.operator.in_plane(right))
        return np.asarray((by_left + by_right[..., ::-1])[..., None])

    @cached_property
    def _stresses(self) -> Array:
        """(3, layer, 3, layer of strain, x): by all cells that are more than x cells to the left."""
        operator = self.operator
        layers, across, _ = operator.volume.shape
        found = np.empty((3, layers, 3, layers, across))
        modulus = operator.moduli.plane_strain
        for layer in range(layers):
            means = influence(self._count, operator.edges_in_cells, layer)
            for i in range(3):
                for j in range(3):
                    known = modulus * FACTORS[i, j] * means[DERIVATIVES[i][j]]
                    if (i == ODD) != (j == ODD):
                        sums = _odd_sums(known)
                    else:
                        # strain that is the same everywhere leaves the stress xx of its own layer
                        uniform = np.zeros((layers, 1))
                        uniform[layer] = modulus if i == j == 0 else 0.0
                        sums = _even_sums(known, uniform)
                    found[i, layer, j] = sums[:, :across]
        return found

    @cached_property
    def _lifts(self) -> Array:
        """(3, layers, x): in-plane stress by pressure in a cell, over all cells more than x to its right."""
        xx, zz, xz = pressed(np.arange(float(self._count)), self.operator.edges_in_cells)
        # under pressure that is the same everywhere, xx = zz = -1
        uniform = -np.ones((len(xx), 1))
        sums = _even_sums(xx, uniform), _even_sums(zz, uniform), _odd_sums(2**0.5 * xz)
        return np.stack(sums)

    @property
    def _count(self) -> int:
        deep = DEPTHS * self.operator.edges_in_cells[-1]
        return int(max(deep, self.operator.volume.grid.cells[0])) + 1


def _even_sums(values: Array, total: Array) -> Array:
    """Sums of even ``values`` (..., distance) over all distances above 0, above 1 ..., ``total`` over both sides."""
    before = np.cumsum(values[..., 1:], axis=-1) - values[..., 1:]
    return np.asarray((total - values[..., :1]) / 2 - before)


def _odd_sums(values: Array) -> Array:
    """The same of odd ``values``."""
    last = values.shape[-1] - 1
    known = np.array([last, last // 2])
    factors = np.linalg.solve((known[:, None] / last) ** -POWERS, values[..., known].T)
    rest = (zeta(POWERS, last + 1.0) * float(last) ** POWERS) @ factors
    return np.asarray(np.cumsum(values[..., :0:-1], axis=-1)[..., ::-1] + rest[:, None])

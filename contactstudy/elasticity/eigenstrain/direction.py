"""Tensors turned into the direction of a wave and back.

Waves of components with one index z, which are odd where others are even, are given over i: all coefficients are real.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.eigenstrain.wave import Tensor


class Components(Enum):
    """What is wanted of a stress, one sign for each component: how it changes upside down."""

    #: The five of the deviator, in the basis of the operator.
    DEVIATOR = (1, 1, -1, 1, -1)
    #: xx, yy, zz, yz, xz, xy.
    TENSOR = (1, 1, 1, -1, -1, 1)

    @property
    def signs(self) -> Array:
        """(components,)"""
        return np.array(self.value)


@dataclass(frozen=True, eq=False)
class Direction:
    """Wave number q [1/m] and direction (c, s), each (waves,), and what cells leave of it: ``weight`` for both sides."""

    q: Array
    c: Array
    s: Array
    weight: Array

    def strain(self, e: Array) -> Tensor:
        """Components nn, tt, zz, nz / i, nt, tz / i of strain in the basis of the operator (5, ..., waves)."""
        c, s = self.c, self.s
        xx, yy = e[0] / 2**0.5 - e[1] / 6**0.5, (2 / 6**0.5) * e[1]
        zz = -xx - yy
        xz, xy, yz = (e[number] / 2**0.5 for number in (2, 3, 4))
        twisted = (2 * c * s) * xy
        nn = c * c * xx + s * s * yy + twisted
        tt = -zz - nn
        nt = (c * s) * (yy - xx) + (c * c - s * s) * xy
        return nn, tt, zz, c * xz + s * yz, nt, c * yz - s * xz

    def stress(self, tensor: Tensor, components: Components) -> Array:
        """The ``components`` asked for (components, ..., waves)."""
        c, s = self.c, self.s
        nn, tt, zz, nz, nt, tz = tensor
        apart, twice = nn - tt, 2 * c * s
        even = np.broadcast_shapes(nn.shape, c.shape)
        found = np.empty((len(components.value), *even))
        xx = (c * c) * apart
        xx += tt
        xx -= twice * nt
        xy = (twice / 2) * apart
        xy += (c * c - s * s) * nt
        xz, yz = c * nz - s * tz, s * nz + c * tz
        if components is Components.TENSOR:
            found[0], found[1], found[2] = xx, nn + tt - xx, zz
            found[3], found[4], found[5] = yz, xz, xy
            return found
        np.subtract(xx, zz, out=found[0])
        xx *= -3
        xx += 2 * (nn + tt)
        xx -= zz
        found[0] /= 2**0.5
        np.divide(xx, 6**0.5, out=found[1])
        for number, one in ((2, xz), (3, xy), (4, yz)):
            np.multiply(one, 2**0.5, out=found[number])
        return found

"""Antiplane shear on an infinite axis x: stress xy and yz by plastic strain that is the same along y.

Closed forms: means over cells of the Green's function of the Laplacian with a free surface,
``N = (ln r + ln R) / (2 pi)``, where r is the distance from the source and R that from its image.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.eigenstrain.layered import convolved, real_spectrum
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume

# Even in x, odd.
ODD = 1


@dataclass(frozen=True, eq=False)
class AntiplaneOperator:
    """The part of B between shear strains ``sqrt(2) xy`` and ``sqrt(2) yz``, (2, layers, x)."""

    volume: Volume
    moduli: Moduli

    def __call__(self, strain: Array) -> Array:
        """What ``strain`` takes from the stress (2, layers, x) [Pa]."""
        return convolved(self._spectrum_and_own[0], strain, ODD)

    @property
    def self_blocks(self) -> Array:
        """(layers, 2, 2) [Pa]."""
        return self._spectrum_and_own[1]

    @cached_property
    def _spectrum_and_own(self) -> tuple[Array, Array]:
        """(waves, 2 layers, 2 layers), real, and the blocks of each layer's cells on themselves."""
        layers, across, _ = self.volume.shape
        edges = np.array(self.volume.edges) / self.volume.grid.cell[0]
        blocks = 2 * self.moduli.shear * influence(across, edges)
        spectrum = np.array(
            [
                [real_spectrum(blocks[i, j], is_odd=(i == ODD, j == ODD)) for j in range(2)]
                for i in range(2)
            ]
        )
        spectrum = spectrum.transpose(4, 0, 2, 1, 3).reshape(-1, 2 * layers, 2 * layers)
        every = np.arange(layers)
        return spectrum, np.moveaxis(blocks[:, :, every, every, 0], -1, 0)


def influence(count: int, edges: Array) -> Array:
    """What unit shear takes from the stress, over 2G, (2, 2, layers, layers, x): stress xy or yz by strain xy or yz.

    Of each layer by each layer, at ``count`` offsets 0, 1, 2 ... in cells; ``edges`` of the layers in cells too.
    """
    x = np.arange(-1.0, count + 1)
    direct = _integrals(x, edges[:, None, None] - edges[:, None])
    image = _integrals(x, edges[:, None, None] + edges[:, None])
    thickness = np.diff(edges)[:, None, None]

    def mean(field: Array) -> Array:
        change = np.diff(np.diff(field, axis=0), axis=1)
        return (change[..., 2:] - 2 * change[..., 1:-1] + change[..., :-2]) / thickness

    (near_xx, near_xz, near_zz), (far_xx, far_xz, far_zz) = (
        [mean(field) / (2 * np.pi) for field in fields] for fields in (direct, image)
    )
    own = (np.eye(len(edges) - 1)[..., None]) * (x[1:-1] == 0)
    return np.array(
        (
            (own + near_xx - far_xx, near_xz + far_xz),
            (near_xz - far_xz, own + near_zz + far_zz),
        )
    )


def _integrals(x: Array, z: Array) -> tuple[Array, Array, Array]:
    """Second derivatives xx, xz, zz of ``ln r``, integrated twice over x and z but for what differences remove."""
    squared = x * x + z * z
    log = np.log(np.where(squared > 0, squared, 1.0)) / 2
    by_x = np.sign(x) * np.arctan2(z, np.abs(x))
    by_z = np.sign(z) * np.arctan2(x, np.abs(z))
    return (
        ((z * z - x * x) * log) / 2 + x * z * by_x,
        x * z * log + (z * z * by_z + x * x * by_x) / 2,
        ((x * x - z * z) * log) / 2 + x * z * by_z,
    )

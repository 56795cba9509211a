"""Plastic strain in plane strain, on an axis across that goes on beyond the grid."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import fft

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.eigenstrain.airy import influence, pressed
from contactstudy.elasticity.eigenstrain.layered import convolved, padded_cells, real_spectrum
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume

# (xx - zz) / sqrt(2), (2 yy - xx - zz) / sqrt(6) and sqrt(2) xz, in terms of xx, yy, zz, yz, xz, xy.
BASIS = np.array(
    (
        (1 / 2**0.5, 0, -1 / 2**0.5, 0, 0, 0),
        (-1 / 6**0.5, 2 / 6**0.5, -1 / 6**0.5, 0, 0, 0),
        (0, 0, 0, 0, 1 / 2**0.5, 0),
    )
)
# The derivatives of the stress function in -(xx, zz, sqrt(2) xz) by strain (xx, zz, sqrt(2) xz), and their factors.
DERIVATIVES = (
    ((2, 2), (2, 0), (2, 1)),
    ((0, 2), (0, 0), (0, 1)),
    ((1, 2), (1, 0), (1, 1)),
)
FACTORS = np.array(((1, 1, 2**0.5), (1, 1, 2**0.5), (-(2**0.5), -(2**0.5), -2)))
# Even in x, even, odd.
ODD = 2


@dataclass(frozen=True, eq=False)
class PlaneStrainOperator:
    """An :class:`~contactstudy.elasticity.eigenstrain.volume.EigenstrainOperator` for one cell along the length.

    Strain and stress are means over cells, so that B is the elastic energy of piecewise constant strain: symmetric in
    the inner product of cell volumes. Transforms across are padded to twice the cells, without error.
    """

    volume: Volume
    moduli: Moduli

    @property
    def basis(self) -> Array:
        """(3, 6)."""
        return BASIS

    def stress_of_pressure(self, pressure: Array) -> Array:
        """S p."""
        return self.deviator(self._pressed(pressure))

    def stress_of_strain(self, strain: Array) -> Array:
        """B e."""
        stress = self.deviator(self._taken(strain))
        stress[1] += self.moduli.youngs_modulus * BASIS[1, 1] ** 2 * strain[1]
        return stress

    def lift(self, strain: Array) -> Array:
        """``S^T e`` (x, 1) [m]."""
        volume, spectrum = self.volume, self._pressure_spectrum
        first, last = volume.first, volume.last
        padded = self._padded_grid
        whole = np.zeros((3, volume.shape[0], last))
        whole[..., first:] = self.in_plane(strain)[..., 0] * volume.thicknesses[:, None]
        waves = np.einsum("clk,clk->k", spectrum.conj(), fft.rfft(whole, padded, axis=-1))
        return np.asarray(fft.irfft(waves, padded)[: volume.grid.cells[0], None])

    def tensor_of_pressure(self, pressure: Array) -> Array:
        """(6, layers, x, 1) [Pa]."""
        return self.tensor(self._pressed(pressure), None)

    def tensor_of_strain(self, strain: Array) -> Array:
        """(6, layers, x, 1) [Pa]."""
        return self.tensor(-self._taken(strain), strain[1])

    @cached_property
    def self_blocks(self) -> Array:
        """(layers, 3, 3) [Pa]."""
        mixed = self._mixing
        own: Array = np.einsum("ai,lab,bj->lij", mixed, self._own, mixed)
        own[:, 1, 1] += self.moduli.youngs_modulus * BASIS[1, 1] ** 2
        return own

    @cached_property
    def _mixing(self) -> Array:
        """(3, 3): in-plane strains xx + nu yy, zz + nu yy, sqrt(2) xz by components."""
        nu = self.moduli.poisson_ratio
        xx, yy, zz, _, xz, _ = BASIS.T
        return np.array((xx + nu * yy, zz + nu * yy, 2**0.5 * xz))

    def in_plane(self, strain: Array) -> Array:
        """(3, ...): strains xx + nu yy, zz + nu yy, sqrt(2) xz of components (3, ...)."""
        return np.asarray(np.einsum("ai,i...->a...", self._mixing, strain))

    def deviator(self, stress: Array) -> Array:
        """Components of what in-plane stress makes, with yy = nu (xx + zz)."""
        return np.asarray(np.einsum("ai,a...->i...", self._mixing, stress))

    def tensor(self, stress: Array, out_of_plane: Array | None) -> Array:
        """(6, ...) [Pa] from stress xx, zz, sqrt(2) xz, with the component of strain out of the plane, if any."""
        xx, zz, xz = stress
        whole = np.zeros((6, *xx.shape))
        whole[0], whole[2], whole[4] = xx, zz, xz / 2**0.5
        whole[1] = self.moduli.poisson_ratio * (xx + zz)
        if out_of_plane is not None:
            whole[1] -= self.moduli.youngs_modulus * BASIS[1, 1] * out_of_plane
        return whole

    def _pressed(self, pressure: Array) -> Array:
        """In-plane stress (3, layers, x, 1) [Pa]."""
        padded = self._padded_grid
        waves = self._pressure_spectrum * fft.rfft(pressure[:, 0], padded)
        return np.asarray(fft.irfft(waves, padded, axis=-1)[..., self.volume.rows, None])

    def _taken(self, strain: Array) -> Array:
        """Minus the in-plane stress (3, layers, x, 1) [Pa] by ``strain``."""
        return convolved(self._strain_spectrum, self.in_plane(strain)[..., 0], ODD)[..., None]

    @property
    def _padded_grid(self) -> int:
        cells = self.volume.grid.cells[0] + self.volume.shape[1]
        return int(fft.next_fast_len(cells, real=True))

    @property
    def edges_in_cells(self) -> Array:
        """In cells."""
        return np.array(self.volume.edges) / self.volume.grid.cell[0]

    @cached_property
    def _pressure_spectrum(self) -> Array:
        """(3, layers, waves): in-plane stress by pressure."""
        volume, padded = self.volume, self._padded_grid
        offsets = np.arange(volume.first - volume.grid.cells[0] + 1, volume.last)
        xx, zz, xz = pressed(offsets.astype(np.float64), self.edges_in_cells)
        around = np.zeros((3, volume.shape[0], padded))
        around[..., offsets % padded] = np.stack((xx, zz, 2**0.5 * xz))
        return np.asarray(fft.rfft(around, axis=-1))

    @cached_property
    def _strain_spectrum(self) -> Array:
        """(waves, 3 layers, 3 layers), real."""
        return self._spectrum_and_own[0]

    @property
    def _own(self) -> Array:
        """(layers, 3, 3) [Pa]: of a cell on itself."""
        return self._spectrum_and_own[1]

    @cached_property
    def _spectrum_and_own(self) -> tuple[Array, Array]:
        layers, across, _ = self.volume.shape
        modulus = self.moduli.plane_strain
        spectrum = np.empty((padded_cells(across) // 2 + 1, 3, layers, 3, layers))
        own = np.empty((layers, 3, 3))
        for layer in range(layers):
            means = influence(across, self.edges_in_cells, layer)
            for i in range(3):
                for j in range(3):
                    known = (modulus * FACTORS[i, j]) * means[DERIVATIVES[i][j]]
                    own[layer, i, j] = known[layer, 0]
                    spectrum[:, i, layer, j] = real_spectrum(known, is_odd=(i == ODD, j == ODD)).T
        return spectrum.reshape(-1, 3 * layers, 3 * layers), own

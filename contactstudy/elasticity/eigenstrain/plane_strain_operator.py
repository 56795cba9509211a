"""Stress by plastic strain in plane strain, on an infinite axis across the contact.

Fields are convolved across wave by wave, with a real matrix between all layers for each wave: one component is odd in
x, the others are even, and multiplying the waves of the odd one by -i makes the matrices real. Transforms are padded so
far that nothing wraps around.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from scipy import fft

from contactstudy.domain.fields import Array
from contactstudy.elasticity.eigenstrain.airy_function import (
    TractionKernel,
    airy_means,
    stress_means_under_pressure,
    stress_means_under_shear,
)
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume


def padded_across(across: int) -> int:
    """Return the length of the transforms for a field of `across` cells: at least twice as long, and fast."""
    return int(fft.next_fast_len(2 * across, real=True))


def real_spectrum(means: Array, *, is_odd: tuple[bool, bool]) -> Array:
    """Return the real factors (..., waves) that convolve one component with another.

    `means` (..., x) are the coefficients at offsets 0, 1, 2 ... in cells. `is_odd` says of the result and of the source
    whether it is the component that is odd in x.
    """
    across = means.shape[-1]
    around = np.zeros((*means.shape[:-1], padded_across(across)))
    around[..., :across] = means
    sign = -1 if is_odd[0] != is_odd[1] else 1
    around[..., around.shape[-1] - across + 1 :] = sign * means[..., :0:-1]
    waves = fft.rfft(around, axis=-1)
    if sign > 0:
        return np.asarray(waves.real)
    # the transform of an odd field is -i times its sine transform
    return np.asarray(waves.imag if is_odd[0] else -waves.imag)


def convolved(matrices: Array, fields: Array, odd: int) -> Array:
    """Return `fields` (components, layers, x) convolved across, wave by wave.

    `matrices` are (waves, components layers, components layers); `odd` is the number of the component odd in x.
    """
    components, layers, across = fields.shape
    padded = padded_across(across)
    waves = fft.rfft(fields, padded, axis=-1)
    waves[odd] *= -1j
    columns = np.ascontiguousarray(np.moveaxis(waves, -1, 0)).reshape(-1, components * layers, 1)
    products = np.matmul(matrices, columns.view(np.float64))
    result = np.moveaxis(products.view(np.complex128).reshape(-1, components, layers), 0, -1)
    result[odd] *= 1j
    return np.asarray(fft.irfft(result, padded, axis=-1)[..., :across])


# (xx - zz) / sqrt(2), (2 yy - xx - zz) / sqrt(6) and sqrt(2) xz, in terms of xx, yy, zz, yz, xz, xy.
PLANE_STRAIN_BASIS = np.array(
    (
        (1 / 2**0.5, 0, -1 / 2**0.5, 0, 0, 0),
        (-1 / 6**0.5, 2 / 6**0.5, -1 / 6**0.5, 0, 0, 0),
        (0, 0, 0, 0, 1 / 2**0.5, 0),
    )
)
# The derivatives of the stress function in -(xx, zz, sqrt(2) xz) by strain (xx, zz, sqrt(2) xz), and their factors.
DERIVATIVES = (((2, 2), (2, 0), (2, 1)), ((0, 2), (0, 0), (0, 1)), ((1, 2), (1, 0), (1, 1)))
FACTORS = np.array(((1, 1, 2**0.5), (1, 1, 2**0.5), (-(2**0.5), -(2**0.5), -2)))
# Number of the component that is odd in x.
ODD = 2


@dataclass(frozen=True, eq=False)
class PlaneStrainOperator:
    """Linear maps on plastic strain in plane strain, for one cell along the length.

    An :class:`~contactstudy.elasticity.eigenstrain.volume.EigenstrainOperator`. Strain and stress are means over cells,
    so that the residual stress of a piecewise constant strain is minus the derivative of its elastic energy: a
    symmetric map in the inner product of cell volumes.
    """

    volume: Volume
    moduli: Moduli

    @property
    def basis(self) -> Array:
        """Basis of the three components (3, 6) in terms of xx, yy, zz, yz, xz, xy."""
        return PLANE_STRAIN_BASIS

    def stress_of_pressure(self, pressure: Array) -> Array:
        """Return the deviatoric stress (3, layers, x, 1) [Pa] under `pressure` (x, 1) [Pa]."""
        return self.deviator(self._stress_of_traction(pressure))

    def stress_of_shear(self, shear: Array) -> Array:
        """Return the deviatoric stress (3, layers, x, 1) [Pa] under `shear` along x (x, 1) [Pa]."""
        return self.deviator(self._stress_of_traction(shear, stress_means_under_shear))

    def negative_residual_stress(self, strain: Array) -> Array:
        """Return minus the deviatoric residual stress (3, layers, x, 1) [Pa] of plastic `strain`."""
        stress = self.deviator(self._negative_residual(strain))
        stress[1] += self.moduli.youngs_modulus * PLANE_STRAIN_BASIS[1, 1] ** 2 * strain[1]
        return stress

    def residual_displacement(self, strain: Array) -> Array:
        """Return the displacement (x, 1) [m] of the unloaded surface into the body by plastic `strain`."""
        volume, spectrum = self.volume, self._spectrum_of(stress_means_under_pressure)
        first, last = volume.first, volume.last
        padded = self._padded_grid
        moments = np.zeros((3, volume.shape[0], last))
        moments[..., first:] = self.in_plane(strain)[..., 0] * volume.thicknesses[:, None]
        waves = np.einsum("clk,clk->k", spectrum.conj(), fft.rfft(moments, padded, axis=-1))
        return np.asarray(fft.irfft(waves, padded)[: volume.grid.cells[0], None])

    def residual_stress_tensor(self, strain: Array) -> Array:
        """Return the residual stress (6, layers, x, 1) [Pa] of plastic `strain` without pressure."""
        return self.tensor(-self._negative_residual(strain), strain[1])

    @cached_property
    def diagonal_blocks(self) -> Array:
        """Minus the residual stress of a cell by its own unit strain, by layer (layers, 3, 3) [Pa]."""
        mixing = self._mixing
        blocks: Array = np.einsum("ai,lab,bj->lij", mixing, self._spectrum_and_blocks[1], mixing)
        blocks[:, 1, 1] += self.moduli.youngs_modulus * PLANE_STRAIN_BASIS[1, 1] ** 2
        return blocks

    @cached_property
    def _mixing(self) -> Array:
        """Matrix (3, 3) from components to the in-plane strains xx + nu yy, zz + nu yy, sqrt(2) xz."""
        nu = self.moduli.poisson_ratio
        xx, yy, zz, _, xz, _ = PLANE_STRAIN_BASIS.T
        return np.array((xx + nu * yy, zz + nu * yy, 2**0.5 * xz))

    def in_plane(self, strain: Array) -> Array:
        """Return the strains xx + nu yy, zz + nu yy, sqrt(2) xz (3, ...) of components (3, ...)."""
        return np.asarray(np.einsum("ai,i...->a...", self._mixing, strain))

    def deviator(self, stress: Array) -> Array:
        """Return the deviatoric components (3, ...) of an in-plane `stress` xx, zz, sqrt(2) xz (3, ...).

        The stress along the length is yy = nu (xx + zz).
        """
        return np.asarray(np.einsum("ai,a...->i...", self._mixing, stress))

    def tensor(self, stress: Array, out_of_plane: Array | None) -> Array:
        """Return the stress tensor (6, ...) [Pa] of an in-plane `stress` xx, zz, sqrt(2) xz (3, ...) [Pa].

        `out_of_plane` is the component of plastic strain along the length, if there is any.
        """
        xx, zz, xz = stress
        tensor = np.zeros((6, *xx.shape))
        tensor[0], tensor[2], tensor[4] = xx, zz, xz / 2**0.5
        tensor[1] = self.moduli.poisson_ratio * (xx + zz)
        if out_of_plane is not None:
            tensor[1] -= self.moduli.youngs_modulus * PLANE_STRAIN_BASIS[1, 1] * out_of_plane
        return tensor

    def _stress_of_traction(self, traction: Array, kind: TractionKernel = stress_means_under_pressure) -> Array:
        """Return the in-plane stress (3, layers, x, 1) [Pa] under a `traction` (x, 1) [Pa], pressure or shear."""
        padded = self._padded_grid
        waves = self._spectrum_of(kind) * fft.rfft(traction[:, 0], padded)
        return np.asarray(fft.irfft(waves, padded, axis=-1)[..., self.volume.rows, None])

    def _negative_residual(self, strain: Array) -> Array:
        """Return minus the in-plane residual stress (3, layers, x, 1) [Pa] of plastic `strain`."""
        return convolved(self._spectrum_and_blocks[0], self.in_plane(strain)[..., 0], ODD)[..., None]

    @property
    def _padded_grid(self) -> int:
        """Length of transforms that take fields from the grid to the volume without wrapping."""
        cells = self.volume.grid.cells[0] + self.volume.shape[1]
        return int(fft.next_fast_len(cells, real=True))

    @property
    def edges_in_cells(self) -> Array:
        """Depths between layers (layers + 1,), in cells across."""
        return np.array(self.volume.edges) / self.volume.grid.cell_size[0]

    @cached_property
    def _spectrum_of(self) -> Callable[[TractionKernel], Array]:
        """Function that returns the spectrum (3, layers, waves) from a traction to in-plane stress, each found once."""
        return cache(self._spectrum)

    def _spectrum(self, kind: TractionKernel) -> Array:
        """Return the spectrum (3, layers, waves) from a traction, pressure or shear, to in-plane stress."""
        volume, padded = self.volume, self._padded_grid
        offsets = np.arange(volume.first - volume.grid.cells[0] + 1, volume.last)
        xx, zz, xz = kind(offsets.astype(np.float64), self.edges_in_cells)
        around = np.zeros((3, volume.shape[0], padded))
        around[..., offsets % padded] = np.stack((xx, zz, 2**0.5 * xz))
        return np.asarray(fft.rfft(around, axis=-1))

    def negative_residual_means(self, count: int, layer: int) -> Iterator[tuple[int, int, Array]]:
        """Yield minus the in-plane residual stress [Pa] of one `layer`, for each pair of components.

        Each item is the component i of the stress, the component j of the unit strain, and the means over a cell
        (layers of the strain, x) at `count` offsets 0, 1, 2 ... across.
        """
        means = airy_means(count, self.edges_in_cells, layer)
        for i, j in np.ndindex(3, 3):
            yield i, j, (self.moduli.plane_strain * FACTORS[i, j]) * means[DERIVATIVES[i][j]]

    @cached_property
    def _spectrum_and_blocks(self) -> tuple[Array, Array]:
        """Matrices (waves, 3 layers, 3 layers) from in-plane strain to minus its stress [Pa], and that of a cell itself.

        The latter is minus the residual stress (layers, 3, 3) [Pa] of a cell by its own in-plane strain.
        """
        layers, across, _ = self.volume.shape
        spectrum = np.empty((padded_across(across) // 2 + 1, 3, layers, 3, layers))
        diagonal_blocks = np.empty((layers, 3, 3))
        for layer in range(layers):
            for i, j, means in self.negative_residual_means(across, layer):
                diagonal_blocks[layer, i, j] = means[layer, 0]
                spectrum[:, i, layer, j] = real_spectrum(means, is_odd=(i == ODD, j == ODD)).T
        return spectrum.reshape(-1, 3 * layers, 3 * layers), diagonal_blocks

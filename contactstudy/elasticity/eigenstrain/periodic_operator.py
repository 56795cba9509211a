"""Stress by plastic strain that varies along the length, where all repeats, below a surface that is infinite across.

The mean along the length is plane strain and antiplane shear: the stress xy and yz by plastic strain that does not vary
along y. Antiplane shear has closed forms, means over cells of second derivatives of ``N = (ln r + ln R) / (2 pi)``. N is
Green's function of the Laplacian with a free surface, with the distances r from the source and R from its mirror source
above the surface. The part that varies along the length is a sum of waves.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, log, pi

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from contactstudy.domain.device import threads
from contactstudy.domain.grid import Array
from contactstudy.elasticity.eigenstrain.fourier_modes import (
    BASIS,
    Complex,
    Components,
    TractionWave,
    Waves,
    stress_under_pressure,
    stress_under_shear,
)
from contactstudy.elasticity.eigenstrain.plane_strain_operator import (
    LayerConvolution,
    Moduli,
    PlaneStrainOperator,
    Volume,
    log_distance,
)


def antiplane_convolution(volume: Volume, moduli: Moduli) -> LayerConvolution:
    """Return the map from plastic strain ``sqrt(2) xy`` and ``sqrt(2) yz`` (2, layers, x) to minus its stress [Pa].

    Minus the residual stress over 2G is the plastic strain less the total strain, which is given by second derivatives
    of the function N in the docstring of this module. Means over the cells of stress and sums over those of strain are
    differences of integrals of N. Integrals of ln r depend on the depth of the stress less that of the source, so that a
    difference over the depth of the source changes their sign; those of ln R depend on the sum of both depths. The
    derivatives xx and zz of ln R add up to zero. The means of those of ``ln r / (2 pi)`` add up to 1 in the cell of the
    strain, to 0 in others.
    """
    edges = np.array(volume.edges) / volume.grid.cell_size[0]
    x = np.arange(-1.0, volume.shape[1] + 1)

    def means(z: Array) -> Array:
        """Return means of xz and zz (2, layers of stress, layers of strain, x).

        `z` is the depth of the edges of the stress (first axis) less or plus that of the edges of the strain.
        """
        change = np.diff(np.diff(np.diff(_integrals(x, z), axis=1), axis=2), n=2)
        return change / (2 * np.pi * np.diff(edges)[:, None, None])

    near_xz, near_zz = means(edges[:, None, None] - edges[:, None])
    far_xz, far_zz = means(edges[:, None, None] + edges[:, None])
    identity = np.eye(len(edges) - 1)[..., None] * (x[1:-1] == 0)
    blocks = np.array(((far_zz - near_zz, near_xz + far_xz), (near_xz - far_xz, identity + near_zz + far_zz)))
    # those between xy and yz are odd in x, others even
    return LayerConvolution.from_means(2 * moduli.shear * np.moveaxis(blocks, 2, 0), volume, np.array([1.0, -1.0]))


def _integrals(x: Array, z: Array) -> Array:
    """Return the second derivatives xz and zz (2, ...) of ``ln r``, each integrated twice over x and twice over z.

    Polynomials of so low a degree that the differences over cells remove them are left out.
    """
    squared = x * x + z * z
    log = log_distance(squared)
    # angles from the x axis and from the z axis, of the same sign as x z
    from_x = np.sign(x) * np.arctan2(z, np.abs(x))
    from_z = np.sign(z) * np.arctan2(x, np.abs(z))
    xz, zz = x * z * log + (z * z * from_z + x * x * from_x) / 2, (x * x - z * z) * log / 2 + x * z * from_z
    return np.stack((xz, zz))


# A wave with wave number k along the length decays across like exp(-k |x|). The period across is so long that its
# repeated image has at most this fraction of it. With 1e-4 or 1e-14 the stress by a smooth strain changes by 2e-9 of its
# largest. The stress by noise from cell to cell changes by 2e-4: between layers that are no neighbours, waves shorter
# than two cells are left out, and what is left decays across like 1 / |x| alone.
WRAP = 1e-8
# Number of complex values of one component of a field up to which waves are transformed together: half a megabyte, which
# stays in the cache of a core.
TOGETHER = 2**15


@dataclass(frozen=True, eq=False)
class PeriodicOperator:
    """Linear maps on plastic strain that varies along a period, for more than one cell along.

    It is an :class:`~contactstudy.elasticity.eigenstrain.plane_strain_operator.EigenstrainOperator`. The mean along the
    length is plane strain and antiplane shear, in closed form on an infinite axis. The part that varies along it is a
    sum of waves that repeat across, with periods so long that an image contributes at most the fraction `WRAP`. Waves
    longer than two cells act on all layers. Shorter waves, which represent the edges of cells, act on their own layer
    and on its neighbours.

    Fields written (..., orders) are transformed along the length alone; (..., period, orders) are transformed across
    too.
    """

    volume: Volume
    moduli: Moduli

    @property
    def basis(self) -> Array:
        """Basis of the five components (5, 6) in terms of xx, yy, zz, yz, xz, xy."""
        return BASIS

    def negative_residual_stress(self, strain: Array) -> Array:
        """Return minus the deviatoric residual stress (5, layers, x, y) [Pa] of plastic `strain`."""
        return -self._from_strain(strain, Components.DEVIATOR)

    def residual_stress_tensor(self, strain: Array) -> Array:
        """Return the residual stress (6, layers, x, y) [Pa] of plastic `strain` without pressure."""
        return self._from_strain(strain, Components.TENSOR)

    def stress_of_pressure(self, pressure: Array) -> Array:
        """Return the deviatoric stress (5, layers, x, y) [Pa] under `pressure` (x, y) [Pa]."""
        return self._from_traction(pressure, stress_under_pressure, self._plane.stress_of_pressure)

    def stress_of_shear(self, shear: Array) -> Array:
        """Return the deviatoric stress (5, layers, x, y) [Pa] under `shear` along x (x, y) [Pa]."""
        return self._from_traction(shear, stress_under_shear, self._plane.stress_of_shear, 1j)

    def residual_displacement(self, strain: Array) -> Array:
        """Return the displacement (x, y) [m] of the unloaded surface into the body by plastic `strain`."""
        nx, ny = self.volume.grid.cells
        mean = self._plane.residual_displacement(strain[:3].mean(axis=-1, keepdims=True))
        along = np.zeros((nx, ny // 2 + 1), dtype=np.complex128)
        along[:, 0] = ny * mean[:, 0]
        for group, waves in self._grouped(strain):
            displacement = fft.ifft(group.waves.residual_displacement(waves), axis=0, workers=threads())
            along[group.window, group.orders] = displacement[group.around_window]
        return np.asarray(fft.irfft(along, ny, axis=-1))

    @cached_property
    def diagonal_blocks(self) -> Array:
        """Minus the residual stress of a cell by its own unit strain, by layer (layers, 5, 5) [Pa]."""
        layers, _, ny = self.volume.shape
        blocks = np.zeros((layers, 5, 5))
        blocks[:, :3, :3] = self._plane.diagonal_blocks / ny
        blocks[:, 3:, 3:] = self._antiplane.diagonal_blocks / ny
        for group in self._groups:
            # a wave represents its complex conjugate too, but for the shortest of an even number of cells
            numbers = np.where(2 * group.waves.orders == ny, 1, 2)
            blocks += group.waves.diagonal_blocks(numbers / (group.waves.period * ny))
        return blocks

    def _from_strain(self, strain: Array, components: Components) -> Array:
        """Return the `components` of the residual stress of `strain`."""
        layers, across, ny = self.volume.shape
        mean = self._plane.residual_stress_tensor(strain[:3].mean(axis=-1, keepdims=True))
        mean[[5, 3], ..., 0] = -self._antiplane(strain[3:].mean(axis=-1)) / 2**0.5
        along = np.zeros((len(components.value), layers, across, ny // 2 + 1), dtype=np.complex128)
        along[..., :1] = ny * np.tensordot(components.matrix, mean, 1)
        for group, waves in self._grouped(strain):
            self._write(group.waves.stress(waves, components), group, along)
        return self._transformed_back(along)

    def _from_traction(
        self, values: Array, traction: TractionWave, of_mean: Callable[[Array], Array], factor: complex = 1.0
    ) -> Array:
        """Return the deviatoric stress (5, layers, x, y) [Pa] under the `values` (x, y) [Pa] of a traction.

        `traction` gives the stress by a wave of it over `factor`, and `of_mean` that by its mean along the length.
        """
        layers, across, ny = self.volume.shape
        waves = fft.rfft(values, axis=-1)
        along = np.zeros((5, layers, across, ny // 2 + 1), dtype=np.complex128)
        along[:3, ..., :1] = of_mean(ny * values.mean(axis=-1, keepdims=True))
        for group in self._groups:
            around = np.zeros((group.waves.period, len(group.waves.orders)), dtype=np.complex128)
            around[group.around_window] = waves[group.window, group.orders]
            around = fft.fft(around, axis=0, overwrite_x=True, workers=threads())
            self._write(group.waves.stress_of_traction(factor * around, traction), group, along)
        return self._transformed_back(along)

    def _write(self, waves: Complex, group: "WaveGroup", along: Complex) -> None:
        """Transform waves (components, layers, period, orders) back across, and write them to the `group` in `along`.

        `along` (components, layers, x, orders) has all orders along the length, in the cells of the volume across.
        """
        across = along.shape[2]
        field = fft.ifft(waves, axis=2, overwrite_x=True, workers=threads())
        along[..., group.orders] = field[:, :, :across]

    def _transformed_back(self, along: Complex) -> Array:
        """Return the field (components, layers, x, y) whose transform along the length is `along`."""
        ny = self.volume.grid.cells[1]
        return np.asarray(fft.irfft(along, ny, axis=-1, workers=threads()))

    def _grouped(self, strain: Array) -> Iterator[tuple["WaveGroup", Complex]]:
        """Yield each group with the waves (5, layers, period, orders) of `strain` that belong to it."""
        along = fft.rfft(strain, axis=-1, workers=threads())
        for group in self._groups:
            orders = along[..., group.orders]
            yield group, fft.fft(orders, group.waves.period, axis=2, workers=threads())

    @cached_property
    def _plane(self) -> PlaneStrainOperator:
        """Operator on the mean of in-plane strain along the length."""
        grid = self.volume.grid
        alone = replace(grid, cells=(grid.cells[0], 1))
        return PlaneStrainOperator(replace(self.volume, grid=alone), self.moduli)

    @cached_property
    def _antiplane(self) -> LayerConvolution:
        """Map from the mean of antiplane strain along the length to minus its stress."""
        return antiplane_convolution(self.volume, self.moduli)

    @cached_property
    def _groups(self) -> tuple["WaveGroup", ...]:
        """Groups of all waves along the length except the mean."""
        return tuple(_groups(self.volume, self.moduli))


@dataclass(frozen=True, eq=False)
class WaveGroup:
    """Waves of some orders along the length that are transformed together, and the cells that they reach.

    Attributes
    ----------
    window
        Cells of the grid across whose pressure and displacement are coupled with the volume.
    waves
        Stress and displacement of the waves.
    """

    window: slice
    waves: Waves

    @property
    def orders(self) -> slice:
        """Numbers of wavelengths in the grid's length, which are their places in a transform along it."""
        return slice(int(self.waves.orders[0]), int(self.waves.orders[-1]) + 1)

    @property
    def around_window(self) -> NDArray[np.intp]:
        """Place of each cell of the window in the period across, counted from the first cell of the volume."""
        return (np.arange(self.window.start, self.window.stop) - self.waves.volume.first) % self.waves.period


def _groups(volume: Volume, moduli: Moduli) -> Iterator[WaveGroup]:
    """Yield all waves along the length except the mean, in groups that are transformed together."""
    layers, _, ny = volume.shape
    (nx, _), (dx, _) = volume.grid.cells, volume.grid.cell_size
    last = ny // 2
    order = 1
    while order <= last:
        decay_cells = ceil(-log(WRAP) * volume.grid.length / (2 * pi * order * dx))
        window = slice(max(volume.first - decay_cells, 0), min(volume.last + decay_cells, nx))
        reach = max(volume.last - window.start, window.stop - volume.first)
        period = _odd(max(reach + decay_cells, window.stop - window.start))
        # shorter waves decay over a shorter distance and may use the same period: below order 8 up to twice the first
        # order. Above, any number may: longer transforms cost less there than transforms of few orders
        count = max(1, min(TOGETHER // (layers * period), order if order < 8 else ny))
        orders = np.arange(float(order), min(order + count, last + 1))
        order += count
        yield WaveGroup(window, Waves(volume, moduli, orders, period))


def _odd(count: int) -> int:
    """Return the next odd length of fast transforms from `count` on.

    An even length has a wave whose direction across is undefined.
    """
    count += 1 - count % 2
    while fft.next_fast_len(count) != count:
        count += 2
    return count

"""Stress and surface displacement by plastic strain in plane strain, in a volume and uniform beyond either side of it.

Closed forms give the stress by a cell of plastic strain, or by one under traction. The former are means over cells of
derivatives of the Airy stress function of a half-space free of traction, ``G = [r^2 ln(r / R) + 2 z z'] / (8 pi)``,
which solves ``nabla^4 G = delta`` with G = dG/dz = 0 at z = 0; r is the distance from the source and R that from its
mirror source. Every mean is a difference over edges of an integral of G.

:class:`PlaneStrainOperator` convolves fields in the volume across, wave by wave, with a real matrix between all layers
for each wave: one component is odd in x, the others are even, and multiplying the waves of the odd one by -i makes the
matrices real. Transforms are padded so far that nothing wraps around. :class:`OuterStrain` sums the closed forms over
all cells on either side of the volume.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from scipy import fft
from scipy.special import zeta

from contactstudy.domain.grid import Array
from contactstudy.elasticity.eigenstrain.fourier_modes import Moduli, Volume

# Means of the stresses xx, zz and xz by a traction on one cell, from offsets and edges.
TractionKernel = Callable[[Array, Array], tuple[Array, Array, Array]]
# Derivatives of G by depth of the stress (m) and of the source (n); by x there are 4 - m - n.
DERIVATIVE_ORDERS = tuple((m, n) for m in range(3) for n in range(3))


def airy_means(count: int, edges: Array, layer: int) -> Mapping[tuple[int, int], Array]:
    """Return means of derivatives of Airy's stress function G over a cell of one `layer`, by sources in all layers.

    For each (m, n) of `DERIVATIVE_ORDERS` it is ``d_z^m d_z'^n d_x^(4-m-n) G`` with depths z of the stress and z' of
    the source; G is that of a half-space free of traction. The arrays (layers, x) are at `count` offsets 0, 1, 2 ...
    across; offsets and the `edges` of the layers are in cells. Errors from cancellation grow like the offset squared,
    to some 3e-9 of the largest mean at 1000 cells.
    """
    x = np.arange(-1.0, count + 1)
    below, above = (_integrals(x, edges[layer + side], edges) for side in (1, 0))
    thickness = edges[layer + 1] - edges[layer]
    means = {}
    for orders in DERIVATIVE_ORDERS:
        change = np.diff(below[orders] - above[orders], axis=0)
        means[orders] = (change[:, 2:] - 2 * change[:, 1:-1] + change[:, :-2]) / thickness
    return means


def _integrals(x: Array, z: float, source: Array) -> dict[tuple[int, int], Array]:
    """Return ``d_z^(m-1) d_z'^(n-1) d_x^(2-m-n) G`` (source, x) for each (m, n), at offsets `x` and depth `z`.

    G is Airy's stress function, and `source` the depths z' of its sources. As ``r^2 = R^2 - 4 z z'``,
    ``8 pi G = r^2 ln r - R^2 ln R + 4 z z' ln R + 2 z z'``. Polynomials that the differences over cells
    remove are left out.
    """
    z_source = source[:, None]
    direct = _direct_terms(x, z - z_source)
    image = _direct_terms(x, z + z_source)
    products = _product_terms(x, z, z_source)
    return {
        (m, n): (-((-1) ** n) * direct[m + n] - image[m + n] + 4 * products[m, n]) / (8 * np.pi)
        for m, n in DERIVATIVE_ORDERS
    }


def log_distance(squared: Array) -> Array:
    """Return ``ln r`` from ``r^2``, and 0 at r = 0: what it is multiplied by is zero there."""
    return np.asarray(np.log(squared + (squared == 0)) / 2)


def _direct_terms(x: Array, z: Array) -> tuple[Array, ...]:
    """Return ``d_z^(k-2) d_x^(2-k) (r^2 ln r)`` for k = 0 ... 4, with r the distance from the origin to (x, z).

    Polynomials that the differences over cells remove are left out.
    """
    squared = x * x + z * z
    log = log_distance(squared)
    # angles from the z axis and from the x axis, of the same sign as x z
    by_z = np.sign(z) * np.arctan2(x, np.abs(z))
    by_x = np.sign(x) * np.arctan2(z, np.abs(x))
    return (
        (z * z - 3 * x * x) * log + 4 * x * z * by_x,
        2 * x * (z * log + x * by_x),
        squared * log,
        2 * z * (x * log + z * by_z),
        (x * x - 3 * z * z) * log + 4 * x * z * by_z,
    )


def _product_terms(x: Array, z: float, source: Array) -> dict[tuple[int, int], Array]:
    """Return ``d_z^(m-1) d_z'^(n-1) d_x^(2-m-n) (z z' ln R)`` for each (m, n), with z' the depths of the `source`.

    R is the distance from the mirror source. Polynomials that the differences over cells remove are left out.
    """
    # ln R is the real part of ln w, and d/dx is i d/dw
    w = (z + source) + 1j * x
    log = np.log(np.where(w == 0, 1.0, w))
    # ln w, integrated zero, one and two times
    log_integrals = log, w * (log - 1), w * w / 2 * (log - 1.5)
    derivatives = {}
    for m, n in DERIVATIVE_ORDERS:
        s, t = m - 1, n - 1  # orders in z and z', by Leibniz' rule, which holds for -1 too
        rotation = 1j ** ((2 - m - n) % 4)
        plain, once, twice = ((rotation * term).real for term in log_integrals)
        derivatives[m, n] = z * source * plain + (s * source + t * z) * once + s * t * twice
    return derivatives


def stress_means_under_pressure(offsets: Array, edges: Array) -> tuple[Array, Array, Array]:
    """Return means of the stresses xx, zz and xz over cells under one cell of unit pressure, each (layers, x).

    `offsets` of the stress from the pressure and `edges` of the layers are in cells. Source: the integrals of Johnson
    (1985), eqs. 2.23, over the cells.
    """
    x, z, squared, log, angle = _from_one_cell(offsets, edges)
    return _means(
        edges,
        (z * z * log - x * z * angle) / np.pi,
        -x * (z * angle + x * log) / np.pi,
        (squared * angle - x * z) / (2 * np.pi),
    )


def stress_means_under_shear(offsets: Array, edges: Array) -> tuple[Array, Array, Array]:
    """Return means of the stresses xx, zz and xz over cells by unit tangential traction on one cell, each (layers, x).

    Arguments are those of :func:`stress_means_under_pressure`. Source: the integrals of Johnson (1985), eqs. 2.23, over
    the cells: zz and xz are xz and xx of a pressed cell, and ``xx + zz = -2 x / (pi r^2)`` below a line of force.
    """
    x, z, squared, log, angle = _from_one_cell(offsets, edges)
    by_x = np.sign(x) * np.arctan2(z, np.abs(x))
    zz = (squared * angle - x * z) / (2 * np.pi)
    trace = -2 / np.pi * (x * z * log + (z * z * angle + x * x * by_x) / 2)
    return _means(edges, trace - zz, zz, (z * z * log - x * z * angle) / np.pi)


def _from_one_cell(offsets: Array, edges: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return x, z, r^2, ln r and the angle from the z axis at the edges of cells, (edge across, edge, x)."""
    x = (offsets + np.array([-1.0, 0.0, 1.0])[:, None])[:, None, :]
    z = edges[:, None]
    squared = x * x + z * z
    return x, z, squared, log_distance(squared), np.arctan2(x, z)


def _means(edges: Array, *integrals: Array) -> tuple[Array, Array, Array]:
    """Return the means (layers, x) over cells of three stresses, integrated twice over x and once over z."""
    thickness = np.diff(edges)[:, None]
    changes = [np.diff(integral, axis=1) for integral in integrals]
    xx, zz, xz = ((change[2] - 2 * change[1] + change[0]) / thickness for change in changes)
    return xx, zz, xz


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
# The derivatives of G in -(xx, zz, sqrt(2) xz) by strain (xx, zz, sqrt(2) xz), and their factors. With Airy's function
# phi, xx = d_z^2 phi, zz = d_x^2 phi and xz = -d_x d_z phi, and plastic strain e makes
# nabla^4 phi = -E' (d_z^2 e_xx + d_x^2 e_zz - 2 d_x d_z e_xz), E' being E / (1 - nu^2); d_x' G = -d_x G.
DERIVATIVES = (((2, 2), (2, 0), (2, 1)), ((0, 2), (0, 0), (0, 1)), ((1, 2), (1, 0), (1, 1)))
FACTORS = np.array(((1, 1, 2**0.5), (1, 1, 2**0.5), (-(2**0.5), -(2**0.5), -2)))
# Number of the component that is odd in x.
ODD = 2


@dataclass(frozen=True, eq=False)
class PlaneStrainOperator:
    """Linear maps on plastic strain in plane strain, for one cell along the length.

    An :class:`~contactstudy.elasticity.eigenstrain.fourier_modes.EigenstrainOperator`. Strain and stress are means
    over cells, so that the residual stress of a piecewise constant strain is minus the derivative of its elastic
    energy: a symmetric map in the inner product of cell volumes.
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
        # strain along the length makes -E e_yy there as well; only the second component has it
        stress[1] += self.moduli.youngs_modulus * PLANE_STRAIN_BASIS[1, 1] ** 2 * strain[1]
        return stress

    def residual_displacement(self, strain: Array) -> Array:
        """Return the displacement (x, 1) [m] of the unloaded surface into the body by plastic `strain`.

        By reciprocity it is the stress under unit pressure on the strain times the thickness of each layer.
        """
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


# Terms that are odd across are summed one by one up to a distance of this number of depths of the volume. Beyond it the
# sum of their asymptote is added.
DEPTHS = 16
# Factors on the components when x changes its sign: -1 for the shear xz, 1 for the others.
MIRRORED = np.where(np.arange(len(PLANE_STRAIN_BASIS)) == ODD, -1.0, 1.0)
# Powers n of the two leading terms 1 / x^n of the asymptote of odd terms at the distance x.
POWERS = np.array([3.0, 5.0])


@dataclass(frozen=True, eq=False)
class OuterStrain:
    """Influence of plastic strain beyond the volume of an `operator`, at smaller x (left) and at larger x (right).

    On either side strain does not vary along x: it is a profile (3, layers), of the deviatoric components of plane
    strain, ``(xx - zz) / sqrt(2), (2 yy - xx - zz) / sqrt(6), sqrt(2) xz``. In-plane components are xx, zz and
    ``sqrt(2) xz``.

    Coefficients are summed over all cells of a side. Those between xz and another component are odd across, the others
    are even. Sums of even ones follow from the closed form of the sum over both sides. Odd ones are replaced by their
    asymptote beyond `DEPTHS` depths, with an error of 1e-6 of the largest.
    """

    operator: PlaneStrainOperator

    def stress(self, left: Array, right: Array) -> Array:
        """Return the deviatoric stress (3, layers, x, 1) [Pa] of the profiles in the volume, without pressure."""
        return -self.operator.deviator(self._negative_residual(left, right))

    def tensor(self, left: Array, right: Array) -> Array:
        """Return the stress tensor (6, layers, x, 1) [Pa] that the profiles make in the volume, without pressure."""
        return self.operator.tensor(-self._negative_residual(left, right), None)

    def residual_displacement(self, left: Array, right: Array) -> Array:
        """Return the surface displacement (x, 1) [m] into the body; the volume has all cells of the grid across."""
        thicknesses, cells = self.operator.volume.thicknesses, self.operator.volume.grid.cells[0]
        sums = self._surface_displacements[..., :cells]
        by_left, by_right = (
            np.einsum("al,alx->x", self.operator.in_plane(profile) * thicknesses, signs * sums)
            for profile, signs in ((left, MIRRORED[:, None, None]), (right, 1.0))
        )
        return np.asarray((by_left + by_right[::-1])[:, None])

    def _negative_residual(self, left: Array, right: Array) -> Array:
        """Return minus the in-plane residual stress (3, layers, x, 1) [Pa] of the profiles."""
        sums = self._stresses
        mirrored = np.multiply.outer(MIRRORED, MIRRORED)[:, None, :, None, None]
        by_left = np.einsum("iljmx,jm->ilx", sums, self.operator.in_plane(left))
        by_right = np.einsum("iljmx,jm->ilx", mirrored * sums, self.operator.in_plane(right))
        return np.asarray((by_left + by_right[..., ::-1])[..., None])

    @cached_property
    def _stresses(self) -> Array:
        """Minus the in-plane stress (3, layer, 3, layer of strain, x) by all cells more than x cells to the left."""
        operator = self.operator
        layers, across, _ = operator.volume.shape
        stresses = np.empty((3, layers, 3, layers, across))
        for layer in range(layers):
            for i, j, means in operator.negative_residual_means(self._count, layer):
                if (i == ODD) != (j == ODD):
                    sums = _odd_sums(means)
                else:
                    # uniform strain leaves only the stress xx of its own layer
                    uniform = np.zeros((layers, 1))
                    uniform[layer] = operator.moduli.plane_strain if i == j == 0 else 0.0
                    sums = _even_sums(means, uniform)
                stresses[i, layer, j] = sums[:, :across]
        return stresses

    @cached_property
    def _surface_displacements(self) -> Array:
        """Sums of in-plane stress (3, layers, x) by unit pressure in a cell, over all cells more than x to its right.

        By reciprocity they are also the displacement of that cell by the strain in those, per thickness of a layer.
        """
        xx, zz, xz = stress_means_under_pressure(np.arange(float(self._count)), self.operator.edges_in_cells)
        # under unit pressure on all of the surface, xx = zz = -1
        uniform = -np.ones((len(xx), 1))
        sums = _even_sums(xx, uniform), _even_sums(zz, uniform), _odd_sums(2**0.5 * xz)
        return np.stack(sums)

    @property
    def _count(self) -> int:
        """Number of cells across over which odd terms are summed one by one."""
        deep = DEPTHS * self.operator.edges_in_cells[-1]
        return int(max(deep, self.operator.volume.grid.cells[0])) + 1


def _even_sums(values: Array, total: Array) -> Array:
    """Return sums of even `values` (..., distance) over all distances above 0, above 1 ... on one side.

    The values do not change when the distance changes its sign. `total` is the sum over the distance 0 and both sides.
    """
    before = np.cumsum(values[..., 1:], axis=-1) - values[..., 1:]
    return np.asarray((total - values[..., :1]) / 2 - before)


def _odd_sums(values: Array) -> Array:
    """Return sums of odd `values` (..., distance) over all distances above 0, above 1 ... on one side.

    The values change their signs with the distance. Beyond the last distance they are extrapolated with the negative
    powers `POWERS` of the distance, fitted to the last value and to that at half its distance.
    """
    last = values.shape[-1] - 1
    fitted = np.array([last, last // 2])
    factors = np.linalg.solve((fitted[:, None] / last) ** -POWERS, values[..., fitted].T)
    # Hurwitz's zeta function is the sum of 1 / x^n over all distances beyond the last
    remainder = (zeta(POWERS, last + 1.0) * float(last) ** POWERS) @ factors
    return np.asarray(np.cumsum(values[..., :0:-1], axis=-1)[..., ::-1] + remainder[:, None])

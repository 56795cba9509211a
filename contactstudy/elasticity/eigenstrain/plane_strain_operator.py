"""Stress and surface displacement by plastic strain in plane strain, in a volume and uniform beyond either side of it.

:class:`EigenstrainOperator` is what the solution of a yielding contact needs of a body below its surface: linear maps
on the plastic strain in a :class:`Volume`. This module has the maps in plane strain, for one cell along the length; the
module `periodic_operator` has those of strain that varies along it. "Eigenstrain" is strain that a body would have
without stress (Mura 1987), such as plastic strain.

The stress by a cell of plastic strain has a closed form, with derivatives of the Airy stress function of a half-space
free of traction, ``G = [r^2 ln(r / R) + 2 z z'] / (8 pi)``. It solves ``nabla^4 G = delta`` with G = dG/dz = 0 at z = 0;
r is the distance from the source at the depth z' and R that from its mirror source at -z'. The mean of the stress over
cells of a layer, by strain in a half of a layer, x > 0, is a difference over the edges of cells of an integral of G. The
mean by one cell is the difference of two such, and the mean by all cells beyond the volume is one. The stress by
traction on the surface is found alike.

In-plane components are xx, zz and ``sqrt(2) xz`` in this order; the first two are even in x, the last is odd. Lengths in
closed forms are in cells across.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from contactstudy.domain.grid import Array, Grid


@dataclass(frozen=True)
class Moduli:
    """Elastic constants of an isotropic half-space: `youngs_modulus` [Pa] and `poisson_ratio`."""

    youngs_modulus: float
    poisson_ratio: float

    @property
    def shear(self) -> float:
        """Shear modulus ``E / (2 (1 + nu))`` [Pa]."""
        return self.youngs_modulus / (2 * (1 + self.poisson_ratio))

    @property
    def plane_strain(self) -> float:
        """Plane-strain modulus ``E / (1 - nu^2)`` [Pa]."""
        return self.youngs_modulus / (1 - self.poisson_ratio**2)


@dataclass(frozen=True)
class Volume:
    """Box of cells below the surface that may yield, in layers.

    It has the cells with the numbers `first` to `last`, exclusive, of the surface `grid` across, and all of its cells
    along. `edges` [m] are the depths of the sides of layers, rising from 0 or more: one more than layers.
    """

    grid: Grid
    first: int
    last: int
    edges: tuple[float, ...]

    @property
    def rows(self) -> slice:
        """Cells of the grid across that the volume covers, as a slice."""
        return slice(self.first, self.last)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of cells (layers, x, y)."""
        return len(self.edges) - 1, self.last - self.first, self.grid.cells[1]

    @property
    def thicknesses(self) -> Array:
        """Thickness of each layer (layers,) [m]."""
        return np.diff(np.array(self.edges))

    @property
    def depths(self) -> Array:
        """Depth of the middle of each layer (layers,) [m]."""
        edges = np.array(self.edges)
        return np.asarray((edges[1:] + edges[:-1]) / 2)

    @property
    def cell_volumes(self) -> Array:
        """Volume of a cell in each layer (layers, 1, 1) [m^3], which broadcasts to cells."""
        return self.thicknesses[:, None, None] * self.grid.cell_area


class EigenstrainOperator(Protocol):
    """Linear maps on plastic strain e (component, layers, x, y), constant in each cell of a volume, to cell means.

    Components are deviatoric, in an orthonormal (Mandel) basis of C tensors: 3 in plane strain, 5 otherwise. x points
    across, y along, z into the body. Stress is positive in tension, pressure in compression; plastic strain has no
    unit.

    Methods speak of three maps. S gives the stress under a pressure, its transpose S^T the displacement by a strain, and
    B minus the residual stress by a strain: in the inner product of cell volumes B is symmetric, with eigenvalues above
    0 and below twice the shear modulus.
    """

    @property
    def volume(self) -> Volume:
        """Box of cells that carry plastic strain."""

    @property
    def moduli(self) -> Moduli:
        """Elastic constants of the body."""

    @property
    def basis(self) -> Array:
        """The tensor of each component (C, 6), as its entries xx, yy, zz, yz, xz, xy.

        Of each tensor the squares of the nine entries, those of shear twice, add up to 1.
        """

    @property
    def diagonal_blocks(self) -> Array:
        """Minus the residual stress of a cell by its own unit strain, (layers, C, C) [Pa].

        These are the blocks on the diagonal of the map B of :meth:`negative_residual_stress`.
        """

    def stress_of_pressure(self, pressure: Array) -> Array:
        """Return the deviatoric stress S p (C, layers, x, y) [Pa] under `pressure` p (x, y) [Pa] on the whole grid."""

    def stress_of_shear(self, shear: Array) -> Array:
        """Return the deviatoric stress (C, layers, x, y) [Pa] under `shear` along x (x, y) [Pa] on the whole grid."""

    def negative_residual_stress(self, strain: Array) -> Array:
        """Return B e, minus the deviatoric residual stress (C, layers, x, y) [Pa] of plastic `strain` e."""

    def residual_displacement(self, strain: Array) -> Array:
        """Return the surface displacement ``S^T e`` (x, y) [m] by plastic `strain` e, into the body, on the whole grid.

        ``sum(u * p) * cell area = sum(cell volume * e : S p)`` for any pressure p, with the displacement u returned.
        """

    def residual_stress_tensor(self, strain: Array) -> Array:
        """Return the residual stress xx, yy, zz, yz, xz, xy of plastic `strain` e, (6, layers, x, y) [Pa].

        It is the stress without pressure; its deviator is -B e.
        """


# Factors on the in-plane components, and on those in PLANE_STRAIN_BASIS, when the direction of x is reversed.
PARITIES = np.array([1.0, 1.0, -1.0])
# The stress by a strain is a derivative of G: of the order m by the depth z of the stress, n by the depth z' of the
# strain and 4 - m - n by x. These are m for the in-plane components of the stress, and n for those of the strain. For
# with Airy's function phi, xx = d_z^2 phi, zz = d_x^2 phi and xz = -d_x d_z phi, plastic strain e makes
# nabla^4 phi = -E' (d_z^2 e_xx + d_x^2 e_zz - 2 d_x d_z e_xz), E' being E / (1 - nu^2), and d_x' G = -d_x G.
DEPTH_ORDERS = 2, 0, 1
# The factors that go with them: those of minus the stress over E', and those of the strain.
STRESS_FACTORS, STRAIN_FACTORS = np.array([1, 1, -(2**0.5)]), np.array([1, 1, 2**0.5])


def strain_in_half_lines(count: int, edges: Array) -> Iterator[Array]:
    """Yield minus the stress in each layer by unit strain in the half x > 0 of layers, over the plane-strain modulus.

    Half of the stress by strain in all of a layer is subtracted, so that the result is odd or even in x. Stress is the
    mean over cells that begin at x = -1, 0 ... `count` - 1, in the layers between `edges`. The arrays (3, 3, layers,
    count + 1) are by the in-plane component of the stress, that of the strain, the layer of the strain, and the cell.
    Errors from cancellation grow like the distance squared, to some 3e-9 of the largest mean by one cell at 1000 cells.
    """
    x = np.arange(-1.0, count + 1)
    factors = np.multiply.outer(STRESS_FACTORS, STRAIN_FACTORS)[..., None, None]
    integrals = (factors * np.diff(_integrals(x, z, edges)) for z in edges)
    for (above, below), thickness in zip(pairwise(integrals), np.diff(edges), strict=True):
        yield np.diff(below - above, axis=2) / thickness


def _integrals(x: Array, z: float, source: Array) -> Array:
    """Return ``d_z^(m-1) d_z'^(n-1) d_x^(2-m-n) G`` (3, 3, source, x) at offsets `x` and depth `z`.

    G is Airy's stress function, `source` the depths z' of its sources, and m and n are `DEPTH_ORDERS` of the first two
    axes; a derivative of the order -1 is an integral. As ``r^2 = R^2 - 4 z z'``, ``8 pi G = r^2 ln r - R^2 ln R
    + 4 z z' ln R + 2 z z'``. Polynomials that vanish in differences over x, z and z' are left out.
    """
    z_source = source[:, None]
    direct = _direct_terms(x, z - z_source)
    image = _direct_terms(x, z + z_source)
    products = _product_terms(x, z, z_source)
    terms = [
        [-((-1) ** n) * direct[m + n] - image[m + n] + 4 * products[m, n] for n in DEPTH_ORDERS] for m in DEPTH_ORDERS
    ]
    return np.array(terms) / (8 * np.pi)


def log_distance(squared: Array) -> Array:
    """Return ``ln r`` from ``r^2``, and 0 at r = 0: what it is multiplied by is zero there."""
    return np.asarray(np.log(squared + (squared == 0)) / 2)


def _direct_terms(x: Array, z: Array) -> tuple[Array, ...]:
    """Return ``d_z^(k-2) d_x^(2-k) (r^2 ln r)`` for k = 0 ... 4, with r the distance from the origin to (x, z).

    Derivatives of negative orders are integrals. Polynomials that vanish in differences over x, z and z' are left out.
    """
    squared = x * x + z * z
    log = log_distance(squared)
    # angles from the z axis and from the x axis, of the same sign as x z
    from_z = np.sign(z) * np.arctan2(x, np.abs(z))
    from_x = np.sign(x) * np.arctan2(z, np.abs(x))
    return (
        (z * z - 3 * x * x) * log + 4 * x * z * from_x,
        2 * x * (z * log + x * from_x),
        squared * log,
        2 * z * (x * log + z * from_z),
        (x * x - 3 * z * z) * log + 4 * x * z * from_z,
    )


def _product_terms(x: Array, z: float, source: Array) -> dict[tuple[int, int], Array]:
    """Return ``d_z^(m-1) d_z'^(n-1) d_x^(2-m-n) (z z' ln R)`` for m and n of 0, 1 and 2, with z' the depths of `source`.

    A derivative of the order -1 is an integral. R is the distance from the mirror source. Polynomials that vanish in
    differences over x, z and z' are left out.
    """
    # ln R is the real part of ln w, and d/dx is i d/dw
    w = (z + source) + 1j * x
    log = np.log(np.where(w == 0, 1.0, w))
    # ln w, integrated zero, one and two times
    log_integrals = log, w * (log - 1), w * w / 2 * (log - 1.5)
    derivatives_by_x = [[(1j**order * integral).real for integral in log_integrals] for order in range(4)]
    derivatives = {}
    for m, n in np.ndindex(3, 3):
        # Leibniz' rule for the orders s and t of z and z', which holds for -1 too
        s, t = m - 1, n - 1
        log_r, once, twice = derivatives_by_x[(-s - t) % 4]
        derivatives[m, n] = z * source * log_r + (s * source + t * z) * once + s * t * twice
    return derivatives


# Function that returns the stress under a traction on x > 0, as `pressure_on_half_line` does.
TractionKernel = Callable[[Array, Array], Array]


def pressure_on_half_line(x: Array, edges: Array) -> Array:
    """Return the in-plane stress (3, layers, cells) under unit pressure on x > 0, less half of that under it everywhere.

    It is the mean over the cells between neighbouring distances `x`, one after another, in the layers between `edges`.
    Source: the integrals of Johnson (1985), eqs. 2.23, over the cells.
    """
    z, squared, log, angle = _polar(x, edges)
    xx, zz = z * z * log - x * z * angle, -x * (z * angle + x * log)
    return _means(edges, xx / np.pi, zz / np.pi, (squared * angle + x * z) / (2 * np.pi))


def shear_on_half_line(x: Array, edges: Array) -> Array:
    """Return the in-plane stress (3, layers, cells) under unit traction along x on x > 0, less a constant of each layer.

    Arguments and source are those of :func:`pressure_on_half_line`: zz and xz are xz and xx of a pressed line, and
    ``xx + zz = -2 x / (pi r^2)`` below a line of force.
    """
    z, squared, log, angle = _polar(x, edges)
    # the angle from the x axis
    from_x = np.sign(x) * np.arctan2(z, np.abs(x))
    zz = (squared * angle + x * z) / (2 * np.pi)
    trace = -2 / np.pi * (x * z * log + (z * z * angle + x * x * from_x) / 2)
    return _means(edges, trace - zz, zz, (z * z * log - x * z * angle) / np.pi)


def _polar(x: Array, edges: Array) -> tuple[Array, Array, Array, Array]:
    """Return z, r^2, ln r and the angle from the z axis (edges, x) at distances `x`, in the depths `edges`."""
    z = edges[:, None]
    squared = x * x + z * z
    return z, squared, log_distance(squared), np.arctan2(x, z)


def _means(edges: Array, xx: Array, zz: Array, xz: Array) -> Array:
    """Return the in-plane means (3, layers, cells) of xx, zz and xz, given as integrals over x and z (edges, x)."""
    integrals = np.stack((xx, zz, 2**0.5 * xz))
    return np.diff(np.diff(integrals, axis=1), axis=2) / np.diff(edges)[:, None]


def padded_across(across: int) -> int:
    """Return the length of the transforms for a field of `across` cells: at least twice as long, and fast."""
    return int(fft.next_fast_len(2 * across, real=True))


@dataclass(frozen=True, eq=False)
class LayerConvolution:
    """Convolution across of fields (component, layer, x), wave by wave with a real matrix between all layers.

    The effect of one component on another is even in x, or odd where one of the two changes its sign with x. Waves of
    components that change it are multiplied by -i: all matrices are then real. Transforms are padded so that nothing
    wraps around.

    Attributes
    ----------
    matrices
        Matrix (components layers, components layers) of each wave (waves, ...), in the order of component, then layer.
    diagonal_blocks
        Effect of each cell on itself (layers, components, components).
    phases
        The factor -i of odd components and 1 of even ones (components, 1, 1).
    """

    matrices: Array
    diagonal_blocks: Array
    phases: NDArray[np.complex128]

    @classmethod
    def from_means(cls, means: Iterable[Array], volume: Volume, parities: Array) -> "LayerConvolution":
        """Return the convolution in `volume` with the effect of a cell on those 0, 1, 2 ... cells further along x.

        `means` has it for each layer of the result: (component, component of the source, layer of the source, x).
        `parities` are the factors on the components when the direction of x is reversed.
        """
        layers, across, _ = volume.shape
        padded, components = padded_across(across), len(parities)
        phases = np.where(parities < 0, -1j, 1)[:, None, None]
        mirrored = np.multiply.outer(parities, parities)[..., None, None]
        matrices = np.empty((padded // 2 + 1, components, layers, components, layers))
        diagonal_blocks = np.empty((layers, components, components))
        for layer, of_layer in enumerate(means):
            diagonal_blocks[layer] = of_layer[:, :, layer, 0]
            around = np.zeros((*of_layer.shape[:-1], padded))
            around[..., :across] = of_layer
            around[..., padded - across + 1 :] = mirrored * of_layer[..., :0:-1]
            waves = phases[..., None] * fft.rfft(around, axis=-1) / phases
            matrices[:, :, layer] = np.moveaxis(waves.real, -1, 0)
        return cls(matrices.reshape(-1, components * layers, components * layers), diagonal_blocks, phases)

    def __call__(self, fields: Array) -> Array:
        """Return the `fields` (components, layers, x) convolved."""
        components, layers, across = fields.shape
        padded = padded_across(across)
        waves = self.phases * fft.rfft(fields, padded, axis=-1)
        columns = np.ascontiguousarray(np.moveaxis(waves, -1, 0)).reshape(-1, components * layers, 1)
        products = np.matmul(self.matrices, columns.view(np.float64))
        result = np.moveaxis(products.view(np.complex128).reshape(-1, components, layers), 0, -1)
        return np.asarray(fft.irfft(result / self.phases, padded, axis=-1)[..., :across])


# The tensors, as xx, yy, zz, yz, xz, xy, whose amounts in a deviator are (xx - zz) / sqrt(2), (2 yy - xx - zz) / sqrt(6)
# and sqrt(2) xz.
PLANE_STRAIN_BASIS = np.array(
    (
        (1 / 2**0.5, 0, -1 / 2**0.5, 0, 0, 0),
        (-1 / 6**0.5, 2 / 6**0.5, -1 / 6**0.5, 0, 0, 0),
        (0, 0, 0, 0, 1 / 2**0.5, 0),
    )
)


@dataclass(frozen=True, eq=False)
class PlaneStrainOperator:
    """Linear maps on plastic strain in plane strain, for one cell along the length: an :class:`EigenstrainOperator`.

    Strain and stress are means over cells, so that the residual stress of a piecewise constant strain is minus the
    derivative of its elastic energy: a symmetric map in the inner product of cell volumes.
    """

    volume: Volume
    moduli: Moduli

    @property
    def basis(self) -> Array:
        """Basis of the three components (3, 6) in terms of xx, yy, zz, yz, xz, xy."""
        return PLANE_STRAIN_BASIS

    def stress_of_pressure(self, pressure: Array) -> Array:
        """Return the deviatoric stress (3, layers, x, 1) [Pa] under `pressure` (x, 1) [Pa]."""
        return self._stress_of_traction(pressure, pressure_on_half_line)

    def stress_of_shear(self, shear: Array) -> Array:
        """Return the deviatoric stress (3, layers, x, 1) [Pa] under `shear` along x (x, 1) [Pa]."""
        return self._stress_of_traction(shear, shear_on_half_line)

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
        volume, spectrum = self.volume, self._spectrum_of(pressure_on_half_line)
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
        to_in_plane = self._to_in_plane
        blocks: Array = np.einsum("ai,lab,bj->lij", to_in_plane, self._convolution.diagonal_blocks, to_in_plane)
        blocks[:, 1, 1] += self.moduli.youngs_modulus * PLANE_STRAIN_BASIS[1, 1] ** 2
        return blocks

    @cached_property
    def _to_in_plane(self) -> Array:
        """Matrix (3, 3) from deviatoric components to the in-plane strains xx + nu yy, zz + nu yy, sqrt(2) xz.

        The total strain yy is zero, so that plastic strain yy acts in the plane as nu yy does along x and along z.
        """
        nu = self.moduli.poisson_ratio
        xx, yy, zz, _, xz, _ = PLANE_STRAIN_BASIS.T
        return np.array((xx + nu * yy, zz + nu * yy, 2**0.5 * xz))

    def in_plane(self, strain: Array) -> Array:
        """Return the strains xx + nu yy, zz + nu yy, sqrt(2) xz (3, ...) of components (3, ...)."""
        return np.asarray(np.einsum("ai,i...->a...", self._to_in_plane, strain))

    def deviator(self, stress: Array) -> Array:
        """Return the deviatoric components (3, ...) [Pa] of an in-plane `stress` (3, ...) [Pa] and yy = nu (xx + zz)."""
        return np.asarray(np.einsum("ai,a...->i...", self._to_in_plane, stress))

    def tensor(self, stress: Array, out_of_plane: Array | float) -> Array:
        """Return the stress tensor (6, ...) [Pa] of an in-plane `stress` (3, ...) [Pa].

        `out_of_plane` is the second component of plastic strain in the same cells, which has all of its yy.
        """
        xx, zz, xz = stress
        plastic_yy = PLANE_STRAIN_BASIS[1, 1] * out_of_plane
        yy = self.moduli.poisson_ratio * (xx + zz) - self.moduli.youngs_modulus * plastic_yy
        zeros = np.zeros_like(xx)
        return np.stack((xx, yy, zz, zeros, xz / 2**0.5, zeros))

    def _stress_of_traction(self, traction: Array, kernel: TractionKernel) -> Array:
        """Return the deviatoric stress (3, layers, x, 1) [Pa] under a `traction` (x, 1) [Pa], pressure or shear."""
        padded = self._padded_grid
        waves = self._spectrum_of(kernel) * fft.rfft(traction[:, 0], padded)
        return self.deviator(fft.irfft(waves, padded, axis=-1)[..., self.volume.rows, None])

    def _negative_residual(self, strain: Array) -> Array:
        """Return minus the in-plane residual stress (3, layers, x, 1) [Pa] of plastic `strain`."""
        return self._convolution(self.in_plane(strain)[..., 0])[..., None]

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

    def _spectrum(self, kernel: TractionKernel) -> Array:
        """Return the spectrum (3, layers, waves) from a traction, pressure or shear, to in-plane stress."""
        volume, padded = self.volume, self._padded_grid
        offsets = np.arange(volume.first - volume.grid.cells[0], volume.last + 1)
        around = np.zeros((3, volume.shape[0], padded))
        around[..., offsets[1:-1] % padded] = np.diff(kernel(offsets.astype(np.float64), self.edges_in_cells))
        return np.asarray(fft.rfft(around, axis=-1))

    @cached_property
    def _convolution(self) -> LayerConvolution:
        """Map from in-plane strain to minus its in-plane stress [Pa]."""
        half_lines = strain_in_half_lines(self.volume.shape[1], self.edges_in_cells)
        means = (self.moduli.plane_strain * np.diff(stress) for stress in half_lines)
        return LayerConvolution.from_means(means, self.volume, PARITIES)


@dataclass(frozen=True, eq=False)
class OuterStrain:
    """Influence of plastic strain beyond the volume of an `operator`, at smaller x (left) and at larger x (right).

    On either side strain does not vary along x: it is a profile (3, layers), of the components of `PLANE_STRAIN_BASIS`.
    """

    operator: PlaneStrainOperator

    def stress(self, left: Array, right: Array) -> Array:
        """Return the deviatoric stress (3, layers, x, 1) [Pa] of the profiles in the volume, without pressure."""
        return -self.operator.deviator(self._negative_residual(left, right))

    def tensor(self, left: Array, right: Array) -> Array:
        """Return the stress tensor (6, layers, x, 1) [Pa] that the profiles make in the volume, without pressure."""
        return self.operator.tensor(-self._negative_residual(left, right), 0.0)

    def residual_displacement(self, left: Array, right: Array) -> Array:
        """Return the surface displacement (x, 1) [m] into the body, for a volume of all cells of the grid across."""
        by_left, by_right = np.einsum("sal,alx->sx", self._seen_from_inside(left, right), self._surface_displacements)
        return np.asarray((by_left + by_right[::-1])[:, None])

    def _negative_residual(self, left: Array, right: Array) -> Array:
        """Return minus the in-plane residual stress (3, layers, x, 1) [Pa] of the profiles."""
        by_left, by_right = np.einsum("iljmx,sjm->silx", self._stresses, self._seen_from_inside(left, right))
        return np.asarray((by_left + PARITIES[:, None, None] * by_right[..., ::-1])[..., None])

    def _seen_from_inside(self, left: Array, right: Array) -> Array:
        """Return the in-plane strains (side, 3, layers) of the profiles, the right one mirrored."""
        return np.stack((self.operator.in_plane(left), PARITIES[:, None] * self.operator.in_plane(right)))

    @cached_property
    def _stresses(self) -> Array:
        """Minus the in-plane stress (3, layer, 3, layer of strain, x) [Pa] by unit strain in all cells on the left."""
        operator = self.operator
        layers, across, _ = operator.volume.shape
        stresses = np.empty((3, layers, 3, layers, across))
        for layer, half_line in enumerate(strain_in_half_lines(across, operator.edges_in_cells)):
            stresses[:, layer] = -half_line[..., 1:]
            # uniform strain leaves only the stress xx of its own layer
            stresses[0, layer, 0, layer] += 0.5
        return operator.moduli.plane_strain * stresses

    @cached_property
    def _surface_displacements(self) -> Array:
        """Displacement (3, layers, x) into the body by unit in-plane strain in all cells on the left [m].

        By reciprocity it is the stress in those cells by unit pressure on a cell at x: that in the first of them by
        pressure on all cells from x on. Under pressure on all of the surface, xx = zz = -1.
        """
        operator = self.operator
        half_line = pressure_on_half_line(np.arange(operator.volume.grid.cells[0] + 1.0), operator.edges_in_cells)
        of_half = np.array([-0.5, -0.5, 0.0])[:, None, None] - half_line
        # the strain is at smaller x than the pressure
        return PARITIES[:, None, None] * of_half * operator.volume.thicknesses[:, None]

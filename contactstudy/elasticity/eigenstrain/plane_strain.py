"""Plastic strain in plane strain, on an axis across that goes on beyond the grid.

Closed forms of the stress by a cell of plastic strain or by a pressed cell: means over cells of the Airy stress
function of a half-space free of traction, ``G = [r^2 ln(r / R) + 2 z z'] / (8 pi)``, which solves
``nabla^4 G = delta`` with G = dG/dz = 0 at z = 0; r is the distance from the source and R that from its image. Every
mean is a difference over edges of an integral of G. Fields are convolved across by real matrices that take every layer
to every layer, wave by wave: components are even in x but one, which is odd, and its waves times -i make the matrices
real. Transforms are padded to twice the cells, without error.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import fft
from scipy.special import zeta

from contactstudy.domain.fields import Array
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume

# Derivatives of G by depth of the stress (m) and of the source (n); by x there are 4 - m - n.
ORDERS = tuple((m, n) for m in range(3) for n in range(3))


def influence(count: int, edges: Array, layer: int) -> Mapping[tuple[int, int], Array]:
    """Means of ``d_z^m d_z'^n d_x^(4-m-n) G`` over a cell of ``layer``, by sources in all layers, for each (m, n).

    Arrays (layers, x) for ``count`` offsets 0, 1, 2 ... in cells; ``edges`` of the layers in cells too. Errors from
    cancellation grow like the offset squared, to 1e-9 of the largest at 1000 cells.
    """
    x = np.arange(-1.0, count + 1)
    below, above = (_integrals(x, edges[layer + side], edges) for side in (1, 0))
    thickness = edges[layer + 1] - edges[layer]
    means = {}
    for orders in ORDERS:
        change = np.diff(below[orders] - above[orders], axis=0)
        means[orders] = (change[:, 2:] - 2 * change[:, 1:-1] + change[:, :-2]) / thickness
    return means


def _integrals(x: Array, z: float, source: Array) -> dict[tuple[int, int], Array]:
    """``d_z^(m-1) d_z'^(n-1) d_x^(2-m-n) G`` at x, z by each depth of ``source``, (source, x), for each (m, n)."""
    z_source = source[:, None]
    direct = _powers(x, z - z_source)
    image = _powers(x, z + z_source)
    rest = _products(x, z, z_source)
    return {
        (m, n): (-((-1) ** n) * direct[m + n] - image[m + n] + 4 * rest[m, n]) / (8 * np.pi)
        for m, n in ORDERS
    }


def _powers(x: Array, z: Array) -> tuple[Array, ...]:
    """``d_z^(k-2) d_x^(2-k) (r^2 ln r)`` for k = 0 ... 4, but for what differences remove."""
    squared = x * x + z * z
    log = np.log(np.where(squared > 0, squared, 1.0)) / 2
    by_z = np.sign(z) * np.arctan2(x, np.abs(z))
    by_x = np.sign(x) * np.arctan2(z, np.abs(x))
    return (
        (z * z - 3 * x * x) * log + 4 * x * z * by_x,
        2 * x * (z * log + x * by_x),
        squared * log,
        2 * z * (x * log + z * by_z),
        (x * x - 3 * z * z) * log + 4 * x * z * by_z,
    )


def _products(x: Array, z: float, source: Array) -> dict[tuple[int, int], Array]:
    """``d_z^(m-1) d_z'^(n-1) d_x^(2-m-n) (z z' ln R)``, but for what differences remove."""
    w = (z + source) + 1j * x
    log = np.log(np.where(w == 0, 1.0, w))
    # integrals of ln w, none to two times
    of_log = log, w * (log - 1), w * w / 2 * (log - 1.5)
    found = {}
    for m, n in ORDERS:
        s, t = m - 1, n - 1
        turn = 1j ** ((2 - m - n) % 4)
        zero, one, two = ((turn * term).real for term in of_log)
        found[m, n] = z * source * zero + (s * source + t * z) * one + s * t * two
    return found


def pressed(offsets: Array, edges: Array) -> tuple[Array, Array, Array]:
    """Means of the stresses xx, zz and xz over cells under a cell of unit pressure, each (layers, x).

    ``offsets`` of the stress from the pressure and ``edges`` of the layers in cells. Source: the integrals of
    Johnson (1985), eqs. 2.23, over the cells.
    """
    x = offsets + np.array([-1.0, 0.0, 1.0])[:, None]
    x, z = x[:, None, :], edges[:, None]
    squared = x * x + z * z
    log = np.log(np.where(squared > 0, squared, 1.0)) / 2
    angle = np.arctan2(x, z)
    integrals = (
        (z * z * log - x * z * angle) / np.pi,
        -x * (z * angle + x * log) / np.pi,
        (squared * angle - x * z) / (2 * np.pi),
    )
    thickness = np.diff(edges)[:, None]
    found = []
    for one in integrals:
        change = np.diff(one, axis=1)
        found.append((change[2] - 2 * change[1] + change[0]) / thickness)
    xx, zz, xz = found
    return xx, zz, xz


def padded_cells(across: int) -> int:
    """How many cells the transforms of so many have."""
    return int(fft.next_fast_len(2 * across, real=True))


def real_spectrum(means: Array, *, is_odd: tuple[bool, bool]) -> Array:
    """The factors (..., waves) of a component by another, from ``means`` (..., x) at offsets 0, 1, 2 ... in cells.

    ``is_odd`` says which of the two, that of the result and that of the source, is the odd one.
    """
    across = means.shape[-1]
    around = np.zeros((*means.shape[:-1], padded_cells(across)))
    around[..., :across] = means
    sign = -1 if is_odd[0] != is_odd[1] else 1
    around[..., around.shape[-1] - across + 1 :] = sign * means[..., :0:-1]
    waves = fft.rfft(around, axis=-1)
    if sign > 0:
        return np.asarray(waves.real)
    # what is odd has waves of -i times its sine transform
    return np.asarray(waves.imag if is_odd[0] else -waves.imag)


def convolved(matrices: Array, fields: Array, odd: int) -> Array:
    """``fields`` (components, layers, x) by ``matrices`` (waves, components layers, components layers)."""
    components, layers, across = fields.shape
    padded = padded_cells(across)
    waves = fft.rfft(fields, padded, axis=-1)
    waves[odd] *= -1j
    columns = np.ascontiguousarray(np.moveaxis(waves, -1, 0)).reshape(-1, components * layers, 1)
    found = np.matmul(matrices, columns.view(np.float64))
    result = np.moveaxis(found.view(np.complex128).reshape(-1, components, layers), 0, -1)
    result[odd] *= 1j
    return np.asarray(fft.irfft(result, padded, axis=-1)[..., :across])


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

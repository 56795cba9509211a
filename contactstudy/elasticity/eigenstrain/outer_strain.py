"""Stress and displacement by plastic strain that is uniform beyond either side of a volume, in plane strain."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import zeta

from contactstudy.domain.fields import Array
from contactstudy.elasticity.eigenstrain.airy_function import stress_means_under_pressure
from contactstudy.elasticity.eigenstrain.plane_strain_operator import ODD, PLANE_STRAIN_BASIS, PlaneStrainOperator

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
        """Return the surface displacement (x, 1) [m] into the body, on a grid that the volume covers."""
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

"""The box of cells below the surface that may yield, and the operators on plastic strain in it."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid


@dataclass(frozen=True)
class Moduli:
    """Elastic constants of an isotropic half-space: `youngs_modulus` [Pa] and `poisson_ratio`."""

    youngs_modulus: float
    poisson_ratio: float

    @property
    def shear(self) -> float:
        """Shear modulus ``G = E / (2 (1 + nu))`` [Pa]."""
        return self.youngs_modulus / (2 * (1 + self.poisson_ratio))

    @property
    def plane_strain(self) -> float:
        """Plane-strain modulus ``E / (1 - nu^2)`` [Pa]."""
        return self.youngs_modulus / (1 - self.poisson_ratio**2)


@dataclass(frozen=True)
class Volume:
    """Box of cells below the surface that may yield, in layers.

    It has the cells `first` to `last`, exclusive, of `grid` across and all of its cells along. `edges` [m] are the
    depths between layers, at least 0, one more than layers.
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

    Methods speak of three maps. S gives the stress under a pressure, its transpose the displacement by a strain. B
    gives minus the residual stress by a strain: in the inner product
    of cell volumes it is symmetric, with eigenvalues above 0 and below 2 G, twice the shear modulus.
    """

    @property
    def volume(self) -> Volume:
        """Box of cells that carry plastic strain."""

    @property
    def moduli(self) -> Moduli:
        """Elastic constants of the body."""

    @property
    def basis(self) -> Array:
        """Basis of the components (C, 6) in terms of xx, yy, zz, yz, xz, xy.

        The squares of a tensor's entries, shear counted twice, add up to 1.
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

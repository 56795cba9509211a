"""The box of cells below the surface that may yield, and the operators on plastic strain in it."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid


@dataclass(frozen=True)
class Moduli:
    """Those of an isotropic half-space: ``youngs_modulus`` [Pa], ``poisson_ratio``."""

    youngs_modulus: float
    poisson_ratio: float

    @property
    def shear(self) -> float:
        """G [Pa]."""
        return self.youngs_modulus / (2 * (1 + self.poisson_ratio))

    @property
    def plane_strain(self) -> float:
        """E / (1 - nu^2) [Pa]."""
        return self.youngs_modulus / (1 - self.poisson_ratio**2)


@dataclass(frozen=True)
class Volume:
    """Cells ``first`` to ``last``, exclusive, of ``grid`` across, all of its cells along, in layers.

    ``edges`` [m] are the depths between layers, from 0 on, one more than layers.
    """

    grid: Grid
    first: int
    last: int
    edges: tuple[float, ...]

    @property
    def rows(self) -> slice:
        """The cells across."""
        return slice(self.first, self.last)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Cells (layers, x, y)."""
        return len(self.edges) - 1, self.last - self.first, self.grid.cells[1]

    @property
    def thicknesses(self) -> Array:
        """(layers,) [m]."""
        return np.diff(np.array(self.edges))

    @property
    def depths(self) -> Array:
        """Middles of the layers (layers,) [m]."""
        edges = np.array(self.edges)
        return np.asarray((edges[1:] + edges[:-1]) / 2)

    @property
    def cell_volumes(self) -> Array:
        """(layers, 1, 1) [m^3]: broadcasts to cells."""
        return self.thicknesses[:, None, None] * self.grid.cell_area


class EigenstrainOperator(Protocol):
    """Linear maps on plastic strain e (component, layers, x, y), constant in each cell of a volume, to cell means.

    Components are deviatoric, in an orthonormal basis of C tensors: 3 in plane strain, 5 otherwise. x across, y along,
    z into the body; stress is tension positive, pressure compression positive; plastic strain has no unit.
    """

    @property
    def volume(self) -> Volume:
        """The cells."""
        ...

    @property
    def moduli(self) -> Moduli:
        """Of the body."""
        ...

    @property
    def basis(self) -> Array:
        """(C, 6): each tensor's xx, yy, zz, yz, xz, xy; its squares, shear counted twice, add up to 1."""
        ...

    @property
    def self_blocks(self) -> Array:
        """(layers, C, C) [Pa]: B of one cell on itself."""
        ...

    def stress_of_pressure(self, pressure: Array) -> Array:
        """S p: deviatoric stress (C, layers, x, y) [Pa] under ``pressure`` (x, y) [Pa] on the whole grid."""
        ...

    def stress_of_strain(self, strain: Array) -> Array:
        """B e: what ``strain`` takes from the deviatoric stress (C, layers, x, y) [Pa]; 0 < B < 2G."""
        ...

    def lift(self, strain: Array) -> Array:
        """``S^T e`` (x, y) [m] on the whole grid: how far the unloaded surface moves into the body.

        ``sum(lift * p) * cell area = sum(cell volume * e : S p)`` for any pressure p.
        """
        ...

    def tensor_of_pressure(self, pressure: Array) -> Array:
        """All stresses (6, layers, x, y) [Pa]: xx, yy, zz, yz, xz, xy, under ``pressure``."""
        ...

    def tensor_of_strain(self, strain: Array) -> Array:
        """All stresses (6, layers, x, y) [Pa] that ``strain`` leaves without pressure; its deviator is - B e."""
        ...

"""An operator in series with a Winkler layer whose compliance differs from cell to cell."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import on_cells
from contactstudy.elasticity.approximate_inverse import ExactInverse, FreeEndsInverse, SpectralInverse
from contactstudy.elasticity.convolution import Convolution, weighted_sum


@dataclass(frozen=True, eq=False)
class WithWinklerLayer:
    """Linear map from pressure to displacement, ``K * pressure + compliance pressure``.

    Parameters
    ----------
    convolution
        Displacement of the bodies, K.
    compliance
        Displacement of each cell over its own pressure (x, y) [m/Pa], at least 0.
    """

    convolution: Convolution
    compliance: Array

    def __call__(self, pressure: Array) -> Array:
        """Return the displacement (x, y) under a `pressure` (x, y)."""
        displacement = self.convolution(pressure)
        displacement += self.compliance * pressure
        return displacement

    @property
    def transform_size(self) -> float:
        """Number of cells of the padded grid, transformed in one application."""
        return self.convolution.transform_size

    @property
    def self_compliance(self) -> float:
        """Displacement of the most compliant cell by its own unit pressure; that of the half-space above the mean."""
        return self.convolution.self_compliance + float(self.compliance.max())

    @property
    def blocks(self) -> tuple[int, int]:
        """Number of cells (across, along) that are merged on a coarser grid."""
        return self.convolution.blocks

    def scaled(self, factor: float, precision: Precision) -> "WithWinklerLayer":
        """Return this operator times `factor`, in `precision`."""
        layer = (self.compliance * factor).astype(precision.real)
        return WithWinklerLayer(self.convolution.scaled(factor, precision), layer)

    def coarsened(self) -> "WithWinklerLayer":
        """Return the operator on larger cells: mean displacement of blocks under a pressure constant in each."""
        convolution = self.convolution.coarsened()
        return WithWinklerLayer(convolution, on_cells(self.compliance, convolution.cells))

    def approximate_inverse(
        self, precision: Precision | None = None
    ) -> SpectralInverse | FreeEndsInverse | ExactInverse:
        """Return a preconditioner: the exact inverse of few cells, else that with a layer of the mean compliance."""
        layer = float(self.compliance.mean())
        inverse = weighted_sum([(1.0, self.convolution)], layer).approximate_inverse(precision)
        if isinstance(inverse, ExactInverse):
            return ExactInverse(inverse.compliance + np.diag(self.compliance.ravel() - layer))
        return inverse

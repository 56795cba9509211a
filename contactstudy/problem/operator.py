"""The linear map from pressure to displacement, as a solver sees it."""

from typing import Protocol, Self

from numpy.typing import DTypeLike

from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array


class Extension(Protocol):
    """Linear map from the displacement (x, y) of some cells, zero elsewhere, to that of all cells."""

    @property
    def active(self) -> Array:
        """The active set (x, y), the given cells: 1, others 0."""

    def __call__(self, displacement: Array) -> Array:
        """Return the `displacement` extended to all cells."""

    def pressure(self, extended: Array) -> Array:
        """Return the pressure (x, y) on the given cells that makes an `extended` displacement, which may change."""


class ApproximateInverse(Protocol):
    """Map from the displacement of some cells to the pressure on them: ``extension.pressure(extension(displacement))``.

    It is symmetric.
    """

    @property
    def real(self) -> DTypeLike:
        """Type of the numbers in all fields that the map takes and returns."""

    @property
    def cells_transformed(self) -> float:
        """Number of cells transformed so far."""

    def extension(self, active: Array) -> Extension:
        """Return the extension from the cells of an `active` set (x, y), which is 1 there and 0 elsewhere."""


class Operator(Protocol):
    """Symmetric linear map from pressure to displacement, both (x, y)."""

    @property
    def transform_size(self) -> float:
        """Number of cells of the padded grid, transformed in one application."""

    @property
    def self_compliance(self) -> float:
        """Displacement of a cell under its own unit pressure less the mean of all cells, which is above zero.

        It does not change with a constant in the operator, which has no effect under pressures of zero sum.
        """

    @property
    def blocks(self) -> tuple[int, int]:
        """Number of cells (across, along) of which :meth:`coarsened` makes one; (1, 1) if it cannot."""

    def __call__(self, pressure: Array) -> Array:
        """Return the displacement under `pressure`."""

    def scaled(self, factor: float, precision: Precision) -> Self:
        """Return this operator times `factor`, in `precision`."""

    def coarsened(self) -> Self:
        """Return the operator on a grid of larger cells, each a block of these."""

    def approximate_inverse(self, precision: Precision | None = None) -> ApproximateInverse:
        """Return a preconditioner, in this `precision` if it can, else in the operator's own."""

"""The linear map from pressure to displacement, and its approximate inverse, as a solver sees them."""

from typing import Protocol, Self

from numpy.typing import DTypeLike

from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array


class Extension(Protocol):
    """Linear map from the displacement (x, y) of an active set, zero elsewhere, to that of all cells."""

    @property
    def active(self) -> Array:
        """The active set (x, y): 1 in its cells, 0 elsewhere."""

    def __call__(self, displacement: Array) -> Array:
        """Return the `displacement` extended to all cells, and it may be to more beyond them along each axis."""

    def pressure(self, extended: Array) -> Array:
        """Return the pressure (x, y) on the active set that approximately makes the `extended` displacement.

        The given array may be overwritten.
        """


class ApproximateInverse(Protocol):
    """Self-adjoint preconditioner: from the displacement of an active set to an approximate pressure on it.

    For a set that is 1 in its cells and 0 elsewhere it is applied in two steps: ``extension =
    inverse.extension(active)``, then ``extension.pressure(extension(displacement))``.
    """

    @property
    def real(self) -> DTypeLike:
        """Type of the numbers in all fields that it takes and returns."""

    @property
    def cells_transformed(self) -> float:
        """Number of cells transformed so far."""

    def extension(self, active: Array) -> Extension:
        """Return the extension from the cells of an `active` set (x, y), which is 1 there and 0 elsewhere."""


class Operator(Protocol):
    """Self-adjoint linear map from pressure to displacement (x, y), positive definite for pressures of zero sum."""

    @property
    def transform_size(self) -> float:
        """Number of cells of the padded grid, transformed in one application."""

    @property
    def self_compliance(self) -> float:
        """Displacement of a cell under a unit pressure on it alone, less the mean displacement of all cells; above zero.

        A constant added to the operator, which has no effect under pressures of zero sum, does not change it.
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

"""The linear map from pressure to displacement, as a solver sees it."""

from typing import Protocol, Self

from numpy.typing import DTypeLike

from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array


class Extension(Protocol):
    """Linear map from the displacement (x, y) of some cells, zero elsewhere, to that of all cells."""

    @property
    def work(self) -> float:
        """Number of cells transformed in making the map, and in each use of it or of its transpose."""
        ...

    def __call__(self, displacement: Array) -> Array:
        """Return the `displacement` extended to all cells."""
        ...

    def transposed(self, pressure: Array) -> Array:
        """Gather a `pressure` (x, y) on all cells to the given cells, in place: the transposed map."""
        ...


class ApproximateInverse(Protocol):
    """Map from the displacement of some cells to the pressure on them, in two steps that can be used alone."""

    @property
    def real(self) -> DTypeLike:
        """Type of the numbers in all fields that the map takes and returns."""
        ...

    @property
    def work(self) -> float:
        """Number of cells transformed from an extended displacement to its pressure."""
        ...

    def extension(self, contact: Array) -> Extension:
        """Return the extension from the cells of a `contact` (x, y), which is 1 there and 0 elsewhere."""
        ...

    def pressure(self, displacement: Array) -> Array:
        """Return the pressure (x, y) on all cells that makes a `displacement` of all cells."""
        ...

    def __call__(self, displacement: Array, contact: Array) -> Array:
        """Return the pressure on a `contact` with this `displacement`: extended, inverted and gathered again.

        The map is symmetric.
        """
        ...


class Operator(Protocol):
    """Symmetric linear map from pressure to displacement, both (x, y)."""

    @property
    def work(self) -> float:
        """Number of cells transformed in one application."""
        ...

    @property
    def self_compliance(self) -> float:
        """Displacement of a cell under its own unit pressure, above the mean of all cells.

        It does not depend on a rigid shift, which a balanced load cannot tell, and is above zero.
        """
        ...

    @property
    def blocks(self) -> tuple[int, int]:
        """Number of cells (across, along) of which :meth:`coarsened` makes one; (1, 1) if it cannot."""
        ...

    def __call__(self, pressure: Array) -> Array:
        """Return the displacement under `pressure`."""
        ...

    def scaled(self, factor: float, precision: Precision) -> Self:
        """Return this operator times `factor`, in `precision`."""
        ...

    def coarsened(self) -> Self:
        """Return the operator on a grid of larger cells, each a block of these."""
        ...

    def approximate_inverse(self, precision: Precision | None = None) -> ApproximateInverse:
        """Return a preconditioner, in this `precision` if it can, else in the operator's own."""
        ...

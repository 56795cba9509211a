"""The linear map from pressure to displacement, as a solver sees it."""

from typing import Protocol, Self

from numpy.typing import DTypeLike

from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array


class Extension(Protocol):
    """A linear map from the displacement (x, y) of some cells, zero elsewhere, to that of all cells."""

    @property
    def work(self) -> float:
        """Cells transformed in making it, and in each use of it or of its transpose."""
        ...

    def __call__(self, displacement: Array) -> Array:
        """The displacement of all cells."""
        ...

    def transposed(self, pressure: Array) -> Array:
        """The transposed map: a ``pressure`` (x, y) on all cells gathered to those cells, in place."""
        ...


class ApproximateInverse(Protocol):
    """A map from the displacement of some cells to the pressure on them, in two steps that stand alone too."""

    @property
    def real(self) -> DTypeLike:
        """The numbers it works in: those of all fields that it takes and gives."""
        ...

    @property
    def work(self) -> float:
        """Cells transformed from an extended displacement to its pressure."""
        ...

    def extension(self, contact: Array) -> Extension:
        """The first step, for the cells of a ``contact`` (x, y), which is 1 there and 0 elsewhere."""
        ...

    def pressure(self, displacement: Array) -> Array:
        """The second: the pressure (x, y) on all cells that makes a ``displacement`` of all cells."""
        ...

    def __call__(self, displacement: Array, contact: Array) -> Array:
        """Both, and the first one transposed: a symmetric map."""
        ...


class Operator(Protocol):
    """A symmetric linear map from pressure to displacement, both (x, y)."""

    @property
    def work(self) -> float:
        """Cells transformed in one application."""
        ...

    @property
    def own(self) -> float:
        """Displacement of a cell under its own unit pressure, above the mean of all cells.

        So that it does not depend on a rigid shift, which a balanced load cannot tell, and is above zero.
        """
        ...

    @property
    def blocks(self) -> tuple[int, int]:
        """How many cells across and along :meth:`coarsened` makes one of; (1, 1) if it cannot."""
        ...

    def __call__(self, pressure: Array) -> Array:
        """The displacement under ``pressure``."""
        ...

    def scaled(self, factor: float, precision: Precision) -> Self:
        """This operator times ``factor``, in ``precision``."""
        ...

    def coarsened(self) -> Self:
        """The operator on a grid of larger cells, each a block of these."""
        ...

    def approximate_inverse(self, precision: Precision | None = None) -> ApproximateInverse:
        """What to precondition with, in this ``precision`` if it can, else in the operator's own."""
        ...

"""The linear map from pressure to displacement, as a solver sees it."""

from collections.abc import Callable
from typing import Protocol, Self

from contactstudy.domain.arrays import Array
from contactstudy.domain.precision import Precision


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

    def approximate_inverse(self) -> tuple[Callable[[Array, Array], Array], float]:
        """A map from the displacement of some cells to the pressure on them, to precondition with, and its work.

        It takes a displacement (x, y), zero elsewhere, and a field that is 1 in these cells and 0 elsewhere.
        """
        ...

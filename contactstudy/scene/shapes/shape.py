"""Shapes of the undeformed gap; the shapes of a scene add up."""

from typing import Protocol, runtime_checkable

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid


@runtime_checkable
class Shape(Protocol):
    """A contribution to the undeformed gap."""

    @property
    def curvature(self) -> float:
        """Curvature of the mean cross-section at the axis [1/m]; zero where a shape has none."""
        ...

    def gap(self, grid: Grid) -> Array:
        """Undeformed gap [m] at the cell centres; broadcasts to (x, y).

        The shape (nx, 1) says that nothing varies along the length.
        """
        ...

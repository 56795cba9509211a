"""Heights of the undeformed gap; the shapes of a scene add up."""

from dataclasses import dataclass
from typing import Protocol

from contactstudy.arrays import Array
from contactstudy.checks import positive
from contactstudy.grid import Grid


class Shape(Protocol):
    """Anything that opens a gap."""

    @property
    def curvature(self) -> float:
        """Curvature of the mean cross-section at the axis [1/m]; zero where a shape has none."""
        ...

    def gap(self, grid: Grid) -> Array:
        """Undeformed gap [m] at the cell centres; broadcasts to (width, length)."""
        ...


@dataclass(frozen=True)
class Cylinder:
    """A parabolic cylinder about the length axis, ``x^2 / (2 R)``, as in Hertz's theory.

    ``radius`` R [m], above zero, else :class:`~contactstudy.InvalidInput`. Two cylinders in one scene
    are two curved bodies: curvatures add.
    """

    radius: float

    def __post_init__(self) -> None:
        positive("Cylinder.radius", self.radius, "give a radius above 0 m")

    @property
    def curvature(self) -> float:
        """1 / R [1/m]."""
        return 1 / self.radius

    def gap(self, grid: Grid) -> Array:
        """``x^2 / (2 R)``, shape (width, 1) [m]."""
        return (grid.x**2 / (2 * self.radius))[:, None]

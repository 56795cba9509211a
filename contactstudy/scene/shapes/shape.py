"""Shapes of the undeformed gap; the shapes of a scene add up."""

from dataclasses import dataclass
from math import inf
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


@dataclass(frozen=True)
class Detail:
    """The scales of a shape, as far as they bear on the choice of a grid; all [m] but the slope.

    ``finest`` are its shortest wavelengths (across, along), infinite where it is smooth. ``repeat`` is the
    length after which it repeats, 0 where any will do; ``longest`` its longest wavelength along the length;
    ``roller`` the length of a roller that it ends or crowns, infinite where it has none of its own, 0
    for other shapes. ``height`` is how far its highest stands above its mean; ``slope`` its rms slope. ``widest`` is
    the width over which the shape is known, infinite for most.
    """

    finest: tuple[float, float] = (inf, inf)
    repeat: float = 0.0
    longest: float = 0.0
    roller: float = 0.0
    height: float = 0.0
    slope: float = 0.0
    widest: float = inf

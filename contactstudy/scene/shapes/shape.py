"""Shapes of the undeformed gap; the shapes of a scene add up."""

from dataclasses import dataclass
from math import inf
from typing import Protocol, runtime_checkable

from contactstudy.domain.checks import answers_typos
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid


@runtime_checkable
class Shape(Protocol):
    """Contribution to the undeformed gap."""

    @property
    def curvature(self) -> float:
        """Curvature of the mean cross-section at the axis [1/m], zero if the shape has none."""
        ...

    def gap(self, grid: Grid) -> Array:
        """Return the undeformed gap [m] at the cell centres; it broadcasts to (x, y).

        The shape (nx, 1) means that nothing varies along the length.
        """
        ...


@answers_typos
@dataclass(frozen=True)
class Detail:
    """Length scales of a shape that decide which grid resolves it.

    Parameters
    ----------
    finest
        Shortest wavelengths (across, along) [m], infinite where the shape is smooth.
    repeat
        Length [m] after which the shape repeats, zero if any will do.
    longest
        Longest wavelength along the length [m].
    roller
        Length [m] of a roller that the shape ends or crowns, infinite if it has none of its own, zero for other shapes.
    height
        Height of the highest point above the mean [m].
    slope
        Root mean square of the slope.
    widest
        Width [m] over which the shape is known, infinite for most.
    """

    finest: tuple[float, float] = (inf, inf)
    repeat: float = 0.0
    longest: float = 0.0
    roller: float = 0.0
    height: float = 0.0
    slope: float = 0.0
    widest: float = inf
    spacing: tuple[float, float] | None = None

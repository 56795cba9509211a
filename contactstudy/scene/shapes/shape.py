"""Shapes of the undeformed gap, which add up, and the tilt of a roller."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf, tan
from typing import Annotated, Protocol, runtime_checkable

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import Radians
from contactstudy.domain.validation import Limits, validated


@runtime_checkable
class Shape(Protocol):
    """Contribution to the undeformed gap.

    A shape that curves the body also has the `curvature` of its mean cross-section at the axis [1/m].
    """

    def gap(self, grid: Grid) -> Array:
        """Return the undeformed gap [m] at the cell centres; it broadcasts to (x, y).

        The shape (nx, 1) means that nothing varies along the length.
        """


@dataclass(frozen=True)
class LengthScales:
    """Length scales of a shape that decide which grid resolves it.

    Parameters
    ----------
    shortest_wavelengths
        Shortest wavelengths (across, along) [m], infinite where the shape is smooth.
    period
        Period [m] of the shape along the length, zero if any will do.
    period_across
        Period [m] of the shape across, zero if any will do.
    longest_wavelength
        Longest wavelength along the length [m].
    longest_across
        Longest wavelength [m] that the width of the grid has to hold, zero for shapes that take any width.
    roller
        Length [m] of a roller that the shape ends or crowns, infinite if the shape names no length, zero for other
        shapes.
    height
        Height of the highest point above the mean [m].
    slope
        Root mean square of the slope.
    known_width
        Width [m] over which the shape is known, infinite for most.
    spacing
        Distance of the measured points (across, along) [m]; None for other shapes.
    """

    shortest_wavelengths: tuple[float, float] = (inf, inf)
    period: float = 0.0
    longest_wavelength: float = 0.0
    period_across: float = 0.0
    longest_across: float = 0.0
    roller: float = 0.0
    height: float = 0.0
    slope: float = 0.0
    known_width: float = inf
    spacing: tuple[float, float] | None = None


def curvature_of(shape: object) -> float:
    """Return the curvature [1/m] of the mean cross-section of a shape at the axis; 0 where it names none."""
    return getattr(shape, "curvature", 0.0)


def curvatures_of(shape: object) -> tuple[float, float]:
    """Return the curvatures of a shape (across, along) [1/m], where also those of a surface curved both ways count."""
    return getattr(shape, "curvatures", (curvature_of(shape), 0.0))


def no_gap(grid: Grid) -> Array:
    """Return zeros of shape (nx, 1), by which nothing varies along the length and a scene may be in plane strain."""
    return np.zeros((grid.cells[0], 1))


def gap_of(shape: Shape, grid: Grid) -> Array:
    """Return the gap [m] that `shape` adds at the cell centres of `grid`, which broadcasts to (x, y).

    Raises
    ------
    InvalidInput
        If a shape of the user's own returns anything but real, finite heights that broadcast to the cells.
    """
    name, remedy = f"{type(shape).__name__}.gap", "return an array of real heights [m]"
    returned = shape.gap(grid)
    try:
        gap = np.asarray(np.ma.filled(returned, np.nan))
    except (TypeError, ValueError):
        raise InvalidInput(f"{name} is {returned!r}: {remedy}.") from None
    fits = all(size in (1, count) for size, count in zip(gap.shape, grid.cells, strict=False))
    if gap.ndim not in (0, 2) or not fits:
        raise InvalidInput(
            f"{name} has the shape {gap.shape}: return heights [m] of the shape {grid.cells}, or of "
            f"{(grid.cells[0], 1)} if nothing varies along the length."
        )
    if gap.dtype.kind not in "biuf":
        raise InvalidInput(f"{name} has values of the type {gap.dtype}: {remedy}.")
    with np.errstate(over="ignore", invalid="ignore"):
        total = gap.sum()  # much faster than each height
    if not np.isfinite(total) and (undefined := np.count_nonzero(~np.isfinite(gap))):
        raise InvalidInput(f"{name} is not finite at {undefined} points: {remedy}, all finite.")
    return gap


def length_scales_of(shapes: Iterable[Shape]) -> list[LengthScales]:
    """Return the length scales of the shapes that name theirs."""
    return [shape.length_scales for shape in shapes if hasattr(shape, "length_scales")]


# Angle [rad] of a roller beyond which its ends leave the half-space.
MAX_ANGLE = 0.1
Angle = Annotated[Radians, Limits(f"between -{MAX_ANGLE:g} and {MAX_ANGLE:g} rad", lambda x: abs(x) <= MAX_ANGLE)]


@validated
class Tilt:
    """Misalignment: the axis of a roller turned by an angle out of the plane of contact, ``y tan(angle)``.

    The axis leans in the plane of the load, about the middle of the length. With an angle above zero the gap opens
    towards larger y, and the end at smaller y carries more. Under a crown of radius R the contact moves along the
    length by ``-R tan(angle)``. The roller must end within the grid: give it a length, as
    :class:`~contactstudy.FiniteLength` does, and :class:`~contactstudy.ZeroPadding` along it.

    Parameters
    ----------
    angle
        Angle [rad], between -0.1 and 0.1.

    Raises
    ------
    InvalidInput
        If the angle is outside these limits.
    """

    angle: Angle

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of a roller whose length is not known."""
        return LengthScales(roller=inf if self.angle else 0.0)

    def gap(self, grid: Grid) -> Array:
        """Return ``y tan(angle)`` [m], of shape (1, ny), or (nx, 1) without a tilt."""
        if self.angle == 0:
            return no_gap(grid)
        return (grid.y * tan(self.angle))[None, :]

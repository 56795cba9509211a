"""Shapes of the undeformed gap, which add up: the tilt of a roller, heights that move, and all shapes of a scene."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from math import ceil, inf, tan
from typing import Annotated, Protocol, Self, runtime_checkable

import numpy as np

from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.validation import BodyIndex, InvalidInput, Limits, Radians, readable, validated, whole_quotient
from contactstudy.problem.problem import Problem


@runtime_checkable
class Shape(Protocol):
    """Contribution to the undeformed gap.

    A shape may also have, each asked for where it is there:

    - ``curvature`` [1/m] of its mean cross-section at the axis, above 0 for a convex body, or ``curvatures`` (across,
      along) of a body that is curved both ways;
    - ``length_scales``, the :class:`LengthScales` that decide which grid resolves it;
    - ``covered_fractions(grid)``, the length (y,) that each row represents of a roller that ends, over that of a cell;
    - ``with_extent_of(grid)``, the shape with the extent of a grid, of heights that are given cell by cell;
    - ``left_out(grid)``, a sentence on what a grid leaves out of it, or an empty one;
    - ``gap_after(grid, shift)``, the gap [m] after the body has moved by a shift [m];
    - ``is_sampled``, True for measured heights, which shift by interpolation.
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
        Longest wavelength along the length [m], several of which a period has to hold.
    longest_across
        Longest wavelength [m] that the width of the grid has to hold, zero for shapes that take any width.
    roller
        Length [m] of a roller that the shape ends or crowns, infinite if the shape names no length, zero for other
        shapes.
    height
        Height of the highest point above the mean [m].
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
    known_width: float = inf
    spacing: tuple[float, float] | None = None


def curvature_of(shape: object) -> float:
    """Return the curvature [1/m] of the mean cross-section of a shape at the axis; 0 where it names none."""
    return getattr(shape, "curvature", 0.0)


def curvatures_of(shape: object) -> tuple[float, float]:
    """Return the ``curvatures`` of a shape (across, along) [1/m], else its ``curvature`` and 0; above 0 if convex."""
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
    name = f"{type(shape).__name__}.gap"
    remedy = f"return real heights [m] of the shape {grid.cells}, or {(grid.cells[0], 1)} if all is one profile"
    returned = shape.gap(grid)
    try:
        gap = np.asarray(np.ma.filled(returned, np.nan))
    except (TypeError, ValueError):
        raise InvalidInput(f"{name} is {returned!r}: {remedy}.") from None
    fits = all(size in (1, count) for size, count in zip(gap.shape, grid.cells, strict=False))
    if gap.ndim not in (0, 2) or not fits or gap.dtype.kind not in "biuf":
        raise InvalidInput(f"{name} has the shape {gap.shape} and the type {gap.dtype}: {remedy}.")
    with np.errstate(over="ignore", invalid="ignore"):
        total = gap.sum()  # much faster than each height
    if not np.isfinite(total) and (undefined := np.count_nonzero(~np.isfinite(gap))):
        raise InvalidInput(f"{name} is not finite at {undefined} points: {remedy}, all finite.")
    return gap


def length_scales_of(shapes: Iterable[Shape]) -> list[LengthScales]:
    """Return the length scales of the shapes that name theirs."""
    return [shape.length_scales for shape in shapes if hasattr(shape, "length_scales")]


# Largest angle [rad] of a tilt: slopes must be small in the theory of half-spaces.
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


@dataclass(frozen=True)
class ShiftedGrid(Grid):
    """The cells of a grid in the frame of a body that has moved by ``shift`` [m] across."""

    shift: float

    @property
    def x(self) -> Array:
        """Cell centres across the width in the body's own frame, shape (nx,) [m]."""
        return np.asarray(super().x - self.shift)


@validated
class MovingShape:
    """A shape on the surface of a body, which moves with it to larger x: see :func:`~contactstudy.solve`.

    At time zero it is not shifted. A contact without a film leaves the motion out, with a warning, and one that rolls
    refuses it. Heights of a measured surface repeat across with the width of the grid.

    Parameters
    ----------
    shape
        Roughness, texture, waves: a shape that has no curvature and neither ends nor crowns a roller.
    body
        Index (0 or 1) of the body in ``Scene.solids`` with which it moves.

    Raises
    ------
    InvalidInput
        For another shape, or another body.
    """

    shape: Shape
    body: BodyIndex = 0

    def check_together(self) -> None:
        """Check that the shape is heights alone."""
        if curvature_of(self.shape) or any(scales.roller for scales in length_scales_of([self.shape])):
            raise InvalidInput(
                f"MovingShape.shape is {self.shape!r}: give heights that shape no roller, such as Roughness."
            )

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of the shape; an AttributeError, as of any shape without them, if it does not name its own."""
        return self.shape.length_scales  # type: ignore[attr-defined, no-any-return]

    def with_extent_of(self, grid: Grid) -> Self:
        """Return this shape, where heights that are given cell by cell get the extent of `grid`."""
        if not hasattr(self.shape, "with_extent_of"):
            return self
        return replace(self, shape=self.shape.with_extent_of(grid))

    def left_out(self, grid: Grid) -> str:
        """Return what a contact without a film leaves out: the motion, and what the shape itself says of `grid`."""
        of_shape = getattr(self.shape, "left_out", lambda _: "")(grid)
        motion = (
            "The heights of a MovingShape stand still in a contact without a film, as they are at time zero: give "
            "Scene.lubrication for their motion."
        )
        return f"{motion} {of_shape}".strip()

    def gap(self, grid: Grid) -> Array:
        """Return the contribution to the gap [m] at time zero."""
        return self.shape.gap(grid)

    def gap_after(self, grid: Grid, shift: float) -> Array:
        """Return the contribution to the gap [m] after the body has moved by ``shift`` [m]."""
        if getattr(self.shape, "is_sampled", False):  # shifted by spline interpolation
            heights = np.broadcast_to(self.shape.gap(grid), grid.cells)
            from scipy import ndimage  # imported late, since it is slow

            return np.asarray(ndimage.shift(heights, (shift / grid.cell_size[0], 0), order=3, mode="grid-wrap"))
        return self.shape.gap(ShiftedGrid(grid.cells, grid.extent, shift))


# Rows on which a shape shows that it varies along the length: a prime number, of which few waves are a multiple.
ROWS = 17


@dataclass(frozen=True)
class ShapesSource:
    """Source of a problem: the heights of its shapes, and the same problem on coarser and finer grids.

    Parameters
    ----------
    shapes
        Shapes that add up.
    ends_along
        Whether one of them ends a roller within the grid.
    problem
        Function that makes the problem on a grid.
    sampled
        A grid whose gap is known already, with it; None to sample every grid.
    """

    shapes: tuple[Shape, ...]
    ends_along: bool
    problem: Callable[[Grid], Problem]
    sampled: tuple[Grid, Array] | None = None

    @property
    def shortest_wavelengths(self) -> tuple[float, float]:
        """Shortest lengths (across, along) [m] of all shapes, by :func:`shortest_wavelengths`."""
        return shortest_wavelengths(self.shapes)

    @property
    def has_length_scales(self) -> bool:
        """True if every shape has ``length_scales``."""
        return all(hasattr(shape, "length_scales") for shape in self.shapes)

    def gap(self, grid: Grid) -> Array:
        """Return the summed gap [m] of all shapes, of shape (x, y) or (x, 1) if nothing varies along the length."""
        if self.sampled is not None and self.sampled[0] == grid:
            return self.sampled[1]
        return summed_gap(self.shapes, grid)

    def gap_without_scales(self, grid: Grid) -> Array:
        """Return the summed gap [m] of the shapes without ``length_scales``, as :meth:`gap`."""
        return summed_gap([shape for shape in self.shapes if not hasattr(shape, "length_scales")], grid)

    def covered_fractions(self, grid: Grid) -> Array | None:
        """Return the length of the shortest roller in each row of `grid` (y,), in cells; None where none ends on it."""
        rollers = [shape.covered_fractions(grid) for shape in self.shapes if hasattr(shape, "covered_fractions")]
        shortest = min(rollers, key=np.sum, default=None)
        return None if shortest is None or not shortest.any() or (shortest == 1).all() else shortest

    def with_problem_step(self, step: Callable[[Problem], Problem]) -> "ShapesSource":
        """Return this source with `step` applied to each problem that it makes."""
        return replace(self, problem=lambda grid: step(self.problem(grid)))


def summed_gap(shapes: Iterable[Shape], grid: Grid) -> Array:
    """Return the summed gap [m] of `shapes`, of shape (x, y) or (x, 1) if nothing varies along the length."""
    return sum((gap_of(shape, grid) for shape in shapes), start=np.zeros((grid.cells[0], 1)))


def check_width(shapes: Iterable[Shape], width: float) -> None:
    """Raise InvalidInput unless a grid of this `width` [m], which is periodic across, holds `shapes` without a seam."""
    for number, shape in enumerate(shapes):
        for scales in length_scales_of([shape]):
            if scales.period_across:
                field = f"The length after which Scene.shapes[{number}] repeats across"
                whole_quotient(field, scales.period_across, width)


def standing_heights(shapes: Iterable[Shape]) -> str:
    """Return the warning that heights which vary across do not travel with a body; empty for other `shapes`."""
    if min((scales.shortest_wavelengths[0] for scales in length_scales_of(shapes)), default=inf) == inf:
        return ""
    return (
        "The heights stand still in the frame of the contact: they slide over what moves through it, where the "
        "resistance of bodies that creep or yield is that of hysteretic sliding (Persson 2001), not of rolling."
    )


def shortest_wavelengths(shapes: Iterable[Shape]) -> tuple[float, float]:
    """Return the shortest wavelengths (across, along) [m] of `shapes`, along also rollers; infinite if none is named."""
    length_scales = length_scales_of(shapes)
    across, along = zip((inf, inf), *(scales.shortest_wavelengths for scales in length_scales), strict=True)
    return min(across), min(*along, *(scales.roller or inf for scales in length_scales), inf)


def unresolved(lengths: tuple[float, float], grid: Grid) -> str:
    """Return which cells are longer than the shortest wavelengths (across, along) [m]; empty where none are.

    The sentence asks for two cells in each wavelength.
    """
    for axis, (cell, length) in enumerate(zip(grid.cell_size, lengths, strict=True)):
        if cell > length * (1 + 1e-9) and grid.cells[axis] > 1:
            count = ceil(2 * grid.extent[axis] / length)
            return (
                f"Grid.cells[{axis}] is {grid.cells[axis]}, whose cells of {readable(cell)} do not resolve lengths of "
                f"{readable(length)}, give {count} or more."
            )
    return ""


def left_out(shapes: Iterable[Shape], grid: Grid) -> Iterator[str]:
    """Yield a sentence for each of `shapes` that are cut off by `grid` or by an extent of their own."""
    for shape in shapes:
        if hasattr(shape, "left_out") and (sentence := shape.left_out(grid)):
            yield sentence
        if grid.cells[1] == 1 and hasattr(shape, "length_scales") and _varies_along(shape, grid):
            yield (
                f"Grid.cells[1] is 1: what varies along the length of a {type(shape).__name__} is left out, give more "
                "cells along."
            )


def _varies_along(shape: Shape, grid: Grid) -> bool:
    """Return whether a shape varies along the length of a `grid` of one row."""
    (shape,) = with_extent_of((shape,), grid)
    gap = gap_of(shape, Grid((grid.cells[0], ROWS), grid.extent))
    return bool(np.ptp(gap, axis=1).any())


def with_extent_of(shapes: tuple[Shape, ...], grid: Grid) -> tuple[Shape, ...]:
    """Return `shapes`, where heights that are given cell by cell get the extent of `grid`."""
    return tuple(shape.with_extent_of(grid) if hasattr(shape, "with_extent_of") else shape for shape in shapes)


def ends_along(shapes: tuple[Shape, ...], grid: Grid) -> bool:
    """Return whether a roller ends within the period of `grid`, so that contact may reach its ends."""
    return any(0 < scales.roller <= grid.length * (1 + 1e-9) for scales in length_scales_of(shapes))

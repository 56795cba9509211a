"""The shapes of a scene together: their gap on any grid, and the problem made there."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from math import ceil, inf

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import readable, whole_quotient
from contactstudy.problem.problem import Problem
from contactstudy.scene.shapes.shape import Shape, gap_of, length_scales_of

# Rows on which a shape shows that it varies along the length.
ROWS = 16


@dataclass(frozen=True)
class ShapesSource:
    """Heights of `shapes`, sampled on any grid, and the problem made there.

    Parameters
    ----------
    shapes
        Shapes that add up.
    ends_along
        Whether one of them ends a roller within the grid.
    problem
        Function that makes the problem on a grid.
    sampled
        A grid with the gap on it, which a problem holds anyway; None to sample every grid.
    """

    shapes: tuple[Shape, ...]
    ends_along: bool
    problem: Callable[[Grid], Problem]
    sampled: tuple[Grid, Array] | None = None

    @property
    def shortest_wavelengths(self) -> tuple[float, float]:
        """Shortest wavelengths (across, along) and rollers [m] of all shapes that name theirs; infinite if none does."""
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
        """Return the length of both bodies within each row of `grid`, in cells; None where none ends."""
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
    """Return what it means that heights which vary across do not travel with a body; empty for other `shapes`."""
    if min((scales.shortest_wavelengths[0] for scales in length_scales_of(shapes)), default=inf) == inf:
        return ""
    return (
        "The heights stand still in the frame of the contact: they slide over what moves through it, where the "
        "resistance of bodies that creep or yield is that of hysteretic sliding (Persson 2001), not of rolling."
    )


def shortest_wavelengths(shapes: Iterable[Shape]) -> tuple[float, float]:
    """Return the shortest wavelengths (across, along) and rollers [m] of `shapes`; infinite where none names one."""
    length_scales = length_scales_of(shapes)
    across, along = zip((inf, inf), *(scales.shortest_wavelengths for scales in length_scales), strict=True)
    return min(across), min(*along, *(scales.roller or inf for scales in length_scales), inf)


def unresolved(lengths: tuple[float, float], grid: Grid) -> str:
    """Return which cells are too large for the shortest wavelengths (across, along) [m]; empty where none are."""
    for axis, (cell, length) in enumerate(zip(grid.cell_size, lengths, strict=True)):
        if cell > length * (1 + 1e-9) and grid.cells[axis] > 1:
            count = ceil(2 * grid.extent[axis] / length)
            return (
                f"Grid.cells[{axis}] is {grid.cells[axis]}, whose cells of {readable(cell)} do not resolve lengths of "
                f"{readable(length)}, give {count} or more."
            )
    return ""


def left_out(shapes: Iterable[Shape], grid: Grid) -> Iterator[str]:
    """Yield a sentence for each of `shapes` of which `grid`, or an extent of its own, holds a part alone."""
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

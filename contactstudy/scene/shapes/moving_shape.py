"""Heights that move with a body through a contact with a film."""

from dataclasses import dataclass, replace
from typing import Any, Self, cast

import numpy as np
from scipy import ndimage

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.validation import BodyIndex, validated
from contactstudy.scene.shapes.shape import LengthScales, Shape, curvature_of, length_scales_of


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
        """Length scales of the shape; none, as an AttributeError says, if it does not name its own."""
        scales: LengthScales = cast(Any, self.shape).length_scales
        return scales

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
        if hasattr(self.shape, "seam"):  # sampled heights, shifted by spline interpolation
            heights = np.broadcast_to(self.shape.gap(grid), grid.cells)
            return np.asarray(ndimage.shift(heights, (shift / grid.cell_size[0], 0), order=3, mode="grid-wrap"))
        return self.shape.gap(ShiftedGrid(grid.cells, grid.extent, shift))

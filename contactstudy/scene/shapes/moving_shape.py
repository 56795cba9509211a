"""Heights that move with a body through a contact with a film."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy import ndimage

from contactstudy.domain.checks import InvalidInput, body_index, suggest_fields
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.scene.shapes.shape import LengthScales, Shape


@dataclass(frozen=True)
class ShiftedGrid(Grid):
    """The cells of a grid in the frame of a body that has moved by ``shift`` [m] across."""

    shift: float

    @property
    def x(self) -> Array:
        """Cell centres across the width in the body's own frame, shape (nx,) [m]."""
        return np.asarray(super().x - self.shift)


@suggest_fields
@dataclass(frozen=True)
class MovingShape:
    """A shape on the surface of a body, which moves with it to larger x: see :func:`~contactstudy.solve`.

    At time zero it is not shifted. In a contact without a film it stays there; one that rolls refuses it. Heights of a
    measured surface repeat across with the width of the grid.

    Parameters
    ----------
    shape
        Roughness, texture, waves: a shape without curvature.
    body
        Index (0 or 1) of the body in ``Scene.solids`` with which it moves.

    Raises
    ------
    InvalidInput
        For a shape with curvature, or another body.
    """

    #: Curvature [1/m]: what moves has none.
    curvature: ClassVar[float] = 0.0

    shape: Shape
    body: int = 0

    def __post_init__(self) -> None:
        body_index("MovingShape.body", self.body)
        if (
            isinstance(self.shape, type)
            or not isinstance(self.shape, Shape)
            or self.shape.curvature
        ):
            raise InvalidInput(
                f"MovingShape.shape is {self.shape!r}: give heights without curvature, such as Roughness."
            )

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of the shape."""
        return getattr(self.shape, "length_scales", LengthScales())

    def gap(self, grid: Grid) -> Array:
        """Return the contribution to the gap [m] at time zero."""
        return self.shape.gap(grid)

    def gap_after(self, grid: Grid, shift: float) -> Array:
        """Return the contribution to the gap [m] after the body has moved by ``shift`` [m]."""
        if hasattr(self.shape, "seam"):  # sampled heights, shifted by spline interpolation
            heights = np.broadcast_to(self.shape.gap(grid), grid.cells)
            return np.asarray(
                ndimage.shift(heights, (shift / grid.cell_size[0], 0), order=3, mode="grid-wrap")
            )
        return self.shape.gap(ShiftedGrid(grid.cells, grid.extent, shift))

"""Misalignment of a roller."""

from math import inf, tan
from typing import Annotated

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import Radians
from contactstudy.domain.validation import Limits, validated
from contactstudy.scene.shapes.shape import LengthScales, no_gap

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

"""Profiles of rollers as drawings and measurements give them: points, tangential arcs, rounded and chamfered ends."""

from math import inf, tan
from typing import Annotated, Literal

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import Metres, Radians
from contactstudy.domain.validation import AT_LEAST_ZERO, FINITE, OR_INFINITE, Limits, validated
from contactstudy.scene.shapes.shape import LengthScales

# Axis along which a profile varies: along the length, or across the contact.
Axis = Literal["along", "across"]


@validated
class ProfilePoints:
    """Profile through points of position and drop, by monotone cubic interpolation.

    Beyond the first and the last point the profile stays at their drop. Along the length the points span a roller of
    their length. Across the drop is beside that of a :class:`Cylinder`. Source of the interpolation: Fritsch & Butland
    (1984), SIAM J. Sci. Stat. Comput. 5, 300.

    Parameters
    ----------
    positions
        Positions [m] that increase, at least two. If the first is 0, they are those of one half, which is mirrored.
    drops
        Drop of the surface at each position [m], into the body; the least one may be any number.
    axis
        Axis of the positions, by default along the length.

    Raises
    ------
    InvalidInput
        If there is not one drop for each position, or the positions do not increase.
    """

    positions: tuple[Annotated[Metres, FINITE], ...]
    drops: tuple[Annotated[Metres, FINITE], ...]
    axis: Axis = "along"

    def check_together(self) -> None:
        """Check that positions increase, with a drop for each."""
        positions, drops = self.positions, self.drops
        if len(positions) != len(drops) or len(drops) < 2:
            raise InvalidInput(
                f"ProfilePoints.drops has {len(drops)} numbers for {len(positions)} positions: give at least two "
                "positions, and one drop for each."
            )
        if min(np.diff(positions)) <= 0:
            raise InvalidInput(f"ProfilePoints.positions is {positions!r}: give positions that increase.")

    @property
    def length(self) -> float:
        """Length that the points span [m], of a half twice that."""
        first, last = self.positions[0], self.positions[-1]
        return 2 * last if first == 0 else last - first

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of a roller of the length of the points; across of a shape known over their width."""
        if self.axis == "across":
            return LengthScales(known_width=self.length)
        return LengthScales(roller=self.length)

    def gap(self, grid: Grid) -> Array:
        """Return the drop at the cell centres [m], of shape (1, ny) or (nx, 1)."""
        from scipy.interpolate import PchipInterpolator  # imported late, since it is slow

        at = np.asarray(grid.x if self.axis == "across" else grid.y)
        first, last = self.positions[0], self.positions[-1]
        # the middle of a whole profile is that of the grid
        at = np.abs(at) if first == 0 else at + (first + last) / 2
        drop = PchipInterpolator(self.positions, self.drops)(np.clip(at, first, last))
        return np.asarray(drop[:, None] if self.axis == "across" else drop[None, :])


@validated
class EndRelief:
    """Profile of a middle part, straight or of a large radius, with arcs or chamfers at both ends.

    An arc continues the middle part in its tangent: a rounded end has the radius of its corner, a profile of two radii
    a radius in the middle and a smaller one beyond. A chamfer has a kink, at which the pressure is singular.

    Parameters
    ----------
    length
        Length of the roller [m], above zero.
    middle
        Length of the middle part [m], at least zero, below `length`.
    end_radius
        Radius of the arcs at both ends [m], infinite, the default, for none.
    end_angle
        Angle of the chamfers from the tangent of the middle part [rad], at least zero and up to 1.5.
    radius
        Radius of the middle part [m], infinite, the default, for a straight one.

    Raises
    ------
    InvalidInput
        If a number is outside these limits, or an arc is longer than its radius.
    """

    length: Metres
    middle: Annotated[Metres, AT_LEAST_ZERO]
    end_radius: Annotated[Metres, OR_INFINITE] = inf
    end_angle: Annotated[Radians, Limits("from 0 to 1.5 rad", lambda x: 0 <= x <= 1.5)] = 0.0
    radius: Annotated[Metres, OR_INFINITE] = inf

    def check_together(self) -> None:
        """Check that the ends have a length, and that their arcs reach over it."""
        if self.middle >= self.length:
            raise InvalidInput(f"EndRelief.middle is {self.middle!r} of a roller of {self.length!r} m: give less.")
        if (self.length - self.middle) / 2 > self.end_radius * (1 + 1e-9):
            raise InvalidInput(
                f"EndRelief.end_radius is {self.end_radius!r}, less than the length of an end, "
                f"{(self.length - self.middle) / 2!r} m: give a longer middle part, or a larger radius."
            )

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of the roller."""
        return LengthScales(roller=self.length)

    def gap(self, grid: Grid) -> Array:
        """Return the profile at the cell centres [m], of shape (1, ny); beyond the ends it stays at their drop."""
        y, half = np.minimum(np.abs(grid.y), self.length / 2), self.middle / 2
        beyond = np.maximum(y - half, 0)
        within = np.minimum(y, half)
        slope = half / self.radius + tan(self.end_angle)
        arc = 0.0
        if self.end_radius < inf:
            # an arc's depth without cancellation; rounding may put its end beyond the radius
            chord = np.minimum(beyond / self.end_radius, 1)
            arc = beyond * chord / (1 + np.sqrt((1 - chord) * (1 + chord)))
        return np.asarray((within**2 / (2 * self.radius) + slope * beyond + arc)[None, :])

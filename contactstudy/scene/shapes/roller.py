"""Rollers: round bodies, the profiles along their length, and where they end."""

from math import expm1, inf, log, pi, tan
from typing import Annotated, ClassVar, Literal, Self

import numpy as np

from contactstudy.analytic import HertzLine
from contactstudy.domain import validation
from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.validation import InvalidInput, valid, validated
from contactstudy.scene.shapes.shape import LengthScales, no_gap

# Axis along which a profile through points varies: along the length, or across the contact.
Axis = Literal["along", "across"]


@validated
class ProfilePoints:
    """Profile through points of position and drop, by monotone cubic interpolation.

    Beyond the first and the last point the profile stays at their drop. Along the length the points span a roller of
    their length. Across the contact the drop adds to that of a :class:`Cylinder`. Source of the interpolation: Fritsch &
    Butland (1984), SIAM J. Sci. Stat. Comput. 5, 300.

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

    positions: tuple[Annotated[validation.Metres, validation.FINITE], ...]
    drops: tuple[Annotated[validation.Metres, validation.FINITE], ...]
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

        position = np.asarray(grid.x if self.axis == "across" else grid.y)
        first, last = self.positions[0], self.positions[-1]
        # the middle of a whole profile is that of the grid
        position = np.abs(position) if first == 0 else position + (first + last) / 2
        drop = PchipInterpolator(self.positions, self.drops)(np.clip(position, first, last))
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

    length: validation.Metres
    middle: Annotated[validation.Metres, validation.AT_LEAST_ZERO]
    end_radius: Annotated[validation.Metres, validation.OR_INFINITE] = inf
    end_angle: Annotated[validation.Radians, validation.Limits("from 0 to 1.5 rad", lambda x: 0 <= x <= 1.5)] = 0.0
    radius: Annotated[validation.Metres, validation.OR_INFINITE] = inf

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


# Radius of a round body [m]: above zero convex, below zero hollow, infinite flat.
Radius = Annotated[validation.Metres, validation.CURVED]


@validated
class Cylinder:
    """Parabolic cylinder about the length axis, ``x^2 / (2 R)``, as in Hertz's theory.

    Two cylinders in one scene are two curved bodies: curvatures add. A roller in an outer raceway is one of its radius
    and one of the raceway's radius below zero.

    Parameters
    ----------
    radius
        Radius R [m]: above zero of a convex body, below zero of a hollow one, infinite of a flat.

    Raises
    ------
    InvalidInput
        If the radius is zero or no number.
    """

    radius: Radius

    @property
    def curvature(self) -> float:
        """Curvature 1 / R [1/m]."""
        return 1 / self.radius

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of a smooth shape."""
        return LengthScales()

    def gap(self, grid: Grid) -> Array:
        """Return ``x^2 / (2 R)`` [m], of shape (nx, 1)."""
        return (grid.x**2 / (2 * self.radius))[:, None]


class _Paraboloid:
    """Paraboloid about the origin, with two curvatures."""

    #: Length scales of a roller whose length is not known.
    length_scales: ClassVar[LengthScales] = LengthScales(roller=inf)

    @property
    def curvatures(self) -> tuple[float, float]:
        """Curvatures (across, along) [1/m]."""
        raise NotImplementedError

    def gap(self, grid: Grid) -> Array:
        """Return ``x^2 / (2 Rx) + y^2 / (2 Ry)`` [m], of shape (x, y)."""
        across, along = self.curvatures
        return np.asarray(grid.x[:, None] ** 2 * (across / 2) + grid.y**2 * (along / 2))


# Limits of the radius of a body that is curved alike both ways, which a flat is not.
ROUND = validation.Limits("above 0 of a ball, below 0 of a hollow body", lambda x: validation.MIN_SIZE <= abs(x) < inf)


@validated
class Sphere(_Paraboloid):
    """Paraboloid about the origin, ``(x^2 + y^2) / (2 R)``, as in Hertz's theory of a sphere.

    Under a :class:`~contactstudy.TotalLoad` without a length it is a point contact. Under a load per length it is one
    with :class:`~contactstudy.ZeroPadding` along the length, and carries that load times the grid's period.

    Parameters
    ----------
    radius
        Radius R [m]: above zero of a ball, below zero of a hollow body.

    Raises
    ------
    InvalidInput
        If the radius is zero, infinite or no number.
    """

    radius: Annotated[validation.Metres, ROUND]

    @property
    def curvatures(self) -> tuple[float, float]:
        """Curvatures (across, along) [1/m]."""
        return 1 / self.radius, 1 / self.radius


@validated
class Ellipsoid(_Paraboloid):
    """Surface with two principal radii, ``x^2 / (2 Rx) + y^2 / (2 Ry)``: a barrel, a raceway's groove, a wheel, a rail.

    Each body of a point contact may have its own: curvatures add. A ball of 5 mm in a groove of 5.2 mm about a shaft of
    20 mm, rolling across, is ``Sphere(5e-3)`` and ``Ellipsoid(20e-3, -5.2e-3)``.

    Parameters
    ----------
    radius
        Radius Rx of the cross-section [m]: above zero convex, below zero hollow, infinite flat.
    radius_along
        Radius Ry along the length [m], of the same kinds.

    Raises
    ------
    InvalidInput
        If a radius is zero or no number.
    """

    radius: Radius
    radius_along: Radius

    @property
    def curvatures(self) -> tuple[float, float]:
        """Curvatures (across, along) [1/m]."""
        return 1 / self.radius, 1 / self.radius_along


@validated
class Crown:
    """Parabolic crown along the length, ``y^2 / (2 R)``.

    Along a periodic length it is a row of crowned rollers, each one period long. Source: Harris & Kotzalas (2006),
    Essential Concepts of Bearing Technology, sect. 6.6.

    Parameters
    ----------
    radius
        Radius R of the crown [m], above zero; infinite, the default, for no crown.
    length
        Length of the roller [m], above zero, over which a :class:`~contactstudy.TotalLoad` is spread; infinite, the
        default, where it is not known. The parabola goes on beyond it.

    Raises
    ------
    InvalidInput
        If a number is not above zero.
    """

    radius: Annotated[validation.Metres, validation.OR_INFINITE] = inf
    length: Annotated[validation.Metres, validation.OR_INFINITE] = inf

    @classmethod
    def of_drop(cls, end_drop: float, length: float) -> Self:
        """Return the crown of a roller of `length` [m] that drops by `end_drop` [m], at least zero, at both ends."""
        drop = valid("Crown end_drop", end_drop, Annotated[validation.Metres, validation.AT_LEAST_ZERO])
        length = valid("Crown length", length, validation.Metres)
        return cls(length**2 / (8 * drop) if drop else inf, length)

    @property
    def curvatures(self) -> tuple[float, float]:
        """Curvatures (across, along) [1/m]."""
        return 0.0, 1 / self.radius

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of the roller; none without either a crown or a length."""
        return LengthScales(roller=self.length if min(self.radius, self.length) < inf else 0.0)

    def gap(self, grid: Grid) -> Array:
        """Return ``y^2 / (2 R)`` [m], of shape (1, ny), or (nx, 1) without a crown."""
        if self.radius == inf:
            return no_gap(grid)
        return (grid.y**2 / (2 * self.radius))[None, :]


@validated
class LundbergProfile:
    """Lundberg's logarithmic profile, ``-A ln(1 - (1 - exp(-d / A)) (2 y / L)^2)``.

    Beyond its ends the profile stays at the end drop; :class:`~contactstudy.FiniteLength` ends a roller shorter
    than the grid. Source: Lundberg (1939), Forschung auf dem Gebiete des Ingenieurwesens 10, 201; the finite drop
    at the ends is from Johns & Gohar (1981), Tribology International 14, 131.

    Parameters
    ----------
    amplitude
        Amplitude A [m], at least zero.
    end_drop
        Drop d at the ends [m], at least zero.
    length
        Length L of the roller [m], above zero.
    straight
        Length of a straight part in the middle [m], less than L, over which there is no drop; the profile takes the
        rest, with 2 y / L counted from its ends.

    Raises
    ------
    InvalidInput
        If a number is outside these limits.
    """

    amplitude: Annotated[validation.Metres, validation.AT_LEAST_ZERO]
    end_drop: Annotated[validation.Metres, validation.AT_LEAST_ZERO]
    length: validation.Metres
    straight: Annotated[validation.Metres, validation.AT_LEAST_ZERO] = 0.0

    def check_together(self) -> None:
        """Check that a part of the roller is profiled."""
        if self.straight >= self.length:
            raise InvalidInput(
                f"LundbergProfile.straight is {self.straight!r}: give less than the length of the roller."
            )

    @classmethod
    def for_load(cls, load_per_length: float, *, contact_modulus: float, radius: float, length: float) -> Self:
        """Return the profile under which a load is spread evenly along the roller.

        With ``A = W / (pi E*)`` and Hertz's half-width a, Hertz's pressure that ends at ``|y| = L / 2`` displaces the
        surface at y by ``A ln(1 / (1 - (2 y / L)^2))`` less than in the middle. At the ends the difference, the end drop
        d, is ``A (ln(L / a) + 1/2)``. Johns & Gohar (1981) write it as ``exp(-d / A) = 0.3033 a / (L / 2)``, where
        0.3033 is ``exp(-1/2) / 2``.

        Parameters
        ----------
        load_per_length
            Load W [N/m].
        contact_modulus
            Contact modulus E* [Pa].
        radius
            Radius of the cylinder [m].
        length
            Length L of the roller [m].

        Raises
        ------
        InvalidInput
            If the roller is shorter than its contact is wide.
        """
        hertz = HertzLine(load_per_length, radius, contact_modulus)
        length = valid("LundbergProfile.length", length, validation.Metres)
        if length < 2 * hertz.half_width:
            raise InvalidInput(
                f"LundbergProfile.length is {length!r}: give a roller longer than its contact is wide, "
                f"{2 * hertz.half_width!r} m."
            )
        amplitude = load_per_length / (pi * contact_modulus)
        return cls(amplitude, amplitude * (log(length / hertz.half_width) + 0.5), length)

    @classmethod
    def iso_16281(cls, diameter: float, length: float) -> Self:
        """Return the logarithmic profile of ISO/TS 16281 for a cylindrical roller.

        The drop is ``0.00035 D ln(1 / (1 - (2 y / L)^2))`` up to a length of 2.5 diameters. A longer roller is
        straight in the middle, and drops by ``0.0005 D ln(1 / (1 - t^2))`` over 1.25 diameters at each end, along which
        t rises from 0 to 1. The standard's drop is infinite at the very end; here it ends at ten amplitudes, which
        agrees within 0.3 % of the amplitude over 99 % of the profiled length.

        Parameters
        ----------
        diameter
            Diameter D of the roller [m].
        length
            Length L of the roller [m].
        """
        diameter = valid("LundbergProfile.diameter", diameter, validation.Metres)
        length = valid("LundbergProfile.length", length, validation.Metres)
        profiled = 2.5 * diameter
        amplitude = diameter * (3.5e-4 if length <= profiled else 5e-4)
        return cls(amplitude, 10 * amplitude, length, max(length - profiled, 0.0))

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of the roller that the profile is made for."""
        return LengthScales(roller=self.length)

    def gap(self, grid: Grid) -> Array:
        """Return the profile at the cell centres [m], of shape (1, ny), or (nx, 1) without a profile."""
        if self.amplitude == 0 or self.end_drop == 0:
            return no_gap(grid)
        profiled = self.length - self.straight
        t = np.maximum(2 * np.abs(grid.y) - self.straight, 0) / profiled
        inside = t < 1
        t = np.where(inside, t, 0.0)
        # in a form that keeps the parabola which it is where A is far above d
        drop = -self.amplitude * np.log1p(expm1(-self.end_drop / self.amplitude) * t**2)
        return np.where(inside, drop, self.end_drop)[None, :]


@validated
class FiniteLength:
    """Roller that ends at ``|y| = length / 2``, with flat, sharp-edged faces.

    Cells whose centre lies beyond an end have the gap `length`, larger than any elastic displacement, so that they never
    touch. An end between two cells is exact. A cell that an end divides carries pressure over its whole area, or none,
    and enters the mean gap with its covered fraction. With ZeroPadding along, a grid as long as the roller ends it too.

    Parameters
    ----------
    length
        Length of the roller [m], above zero.

    Raises
    ------
    InvalidInput
        If the length is not above zero; on a grid whose cells are longer.
    """

    length: validation.Metres

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of the roller."""
        return LengthScales(roller=self.length)

    def gap(self, grid: Grid) -> Array:
        """Return zero on the roller and `length` beyond it [m], of shape (1, ny), or (nx, 1) without an end.

        Raises :class:`~contactstudy.InvalidInput` for cells longer than the roller.
        """
        beyond = np.abs(grid.y) > self.length / 2
        if (cell := grid.cell_size[1]) > self.length * (1 + 1e-9) or beyond.all():
            raise InvalidInput(
                f"FiniteLength.length is {self.length!r}: give cells along the length no longer than that, these are "
                f"{cell!r} m long."
            )
        return np.where(beyond, self.length, 0.0)[None, :] if beyond.any() else no_gap(grid)

    def covered_fractions(self, grid: Grid) -> Array:
        """Return the length of the roller that each row of cells represents, over that of a cell, of shape (ny,).

        A row whose centre lies beyond the end represents nothing; its part on the roller is added to the row beside it.
        """
        within = np.clip((self.length / 2 - np.abs(grid.y)) / grid.cell_size[1] + 0.5, 0.0, 1.0)
        rows = np.arange(len(grid.y))
        on_roller = rows[np.abs(grid.y) <= self.length / 2]
        return np.asarray(np.bincount(np.clip(rows, on_roller[0], on_roller[-1]), within, len(rows)), dtype=np.float64)

"""Rollers: round bodies, profiles along their length, and where they end."""

from dataclasses import dataclass
from math import expm1, inf, log, pi
from typing import Self

import numpy as np

from contactstudy.analytic import HertzLine
from contactstudy.domain.checks import InvalidInput, in_range, in_range_from_zero, set_fields
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import Metres
from contactstudy.scene.shapes.shape import Detail


@dataclass(frozen=True)
class Cylinder:
    """A parabolic cylinder about the length axis, ``x^2 / (2 R)``, as in Hertz's theory.

    ``radius`` R [m], above zero, else :class:`~contactstudy.InvalidInput`. Two cylinders in one scene
    are two curved bodies: curvatures add.
    """

    radius: Metres

    def __post_init__(self) -> None:
        set_fields(self, radius=in_range("Cylinder.radius", self.radius, "give a radius above 0 m"))

    @property
    def curvature(self) -> float:
        """1 / R [1/m]."""
        return 1 / self.radius

    @property
    def detail(self) -> Detail:
        """Smooth."""
        return Detail()

    def gap(self, grid: Grid) -> Array:
        """``x^2 / (2 R)``, shape (nx, 1) [m]."""
        return (grid.x**2 / (2 * self.radius))[:, None]


@dataclass(frozen=True)
class Sphere:
    """A paraboloid about the origin, ``(x^2 + y^2) / (2 R)``, as in Hertz's theory of a sphere.

    ``radius`` R [m], above zero, else :class:`~contactstudy.InvalidInput`. Along a free length it is a
    point contact under the load per length times the grid's period.
    """

    radius: Metres

    def __post_init__(self) -> None:
        set_fields(self, radius=in_range("Sphere.radius", self.radius, "give a radius above 0 m"))

    @property
    def curvature(self) -> float:
        """Zero: it adds no curvature to the line contact."""
        return 0.0

    @property
    def detail(self) -> Detail:
        """A roller whose length is not known."""
        return Detail(roller=inf)

    def gap(self, grid: Grid) -> Array:
        """``(x^2 + y^2) / (2 R)``, shape (x, y) [m]."""
        return np.asarray((grid.x[:, None] ** 2 + grid.y**2) / (2 * self.radius))


HEIGHT = "give a height of 0 m or more"


@dataclass(frozen=True)
class Crown:
    """A parabolic crown along the length, ``y^2 / (2 R)``.

    ``radius`` R of the crown [m], above zero; ``math.inf``, the default, is none. Raises
    :class:`~contactstudy.InvalidInput` for anything else. Along a periodic length it is a row of
    crowned rollers, each one period long.

    Source: Harris & Kotzalas (2006), Essential Concepts of Bearing Technology, sect. 6.6.
    """

    radius: Metres = inf

    def __post_init__(self) -> None:
        if self.radius != inf:
            remedy = "give a radius above 0 m, or inf for no crown"
            set_fields(self, radius=in_range("Crown.radius", self.radius, remedy))

    @classmethod
    def of_drop(cls, end_drop: float, length: float) -> Self:
        """The crown that drops by ``end_drop`` [m], from zero on, at the ends of ``length`` [m]."""
        drop = in_range_from_zero("Crown end_drop", end_drop, HEIGHT)
        length = in_range("Crown length", length, "give the roller's length above 0 m")
        return cls(length**2 / (8 * drop) if drop else inf)

    @property
    def curvature(self) -> float:
        """None of the cross-section."""
        return 0.0

    @property
    def detail(self) -> Detail:
        """A roller of any length."""
        return Detail(roller=inf if self.radius < inf else 0.0)

    def gap(self, grid: Grid) -> Array:
        """``y^2 / (2 R)``, shape (1, length), or (nx, 1) where there is no crown [m]."""
        if self.radius == inf:
            return np.zeros((grid.cells[0], 1))
        return (grid.y**2 / (2 * self.radius))[None, :]


@dataclass(frozen=True)
class LundbergProfile:
    """Lundberg's logarithmic profile, ``-A ln(1 - (1 - exp(-d / A)) (2 y / L)^2)``.

    ``amplitude`` A [m] and ``end_drop`` d [m], what the profile drops by at the ends, both from zero on;
    ``length`` L of the roller [m], above zero. Raises :class:`~contactstudy.InvalidInput` for anything
    else. Beyond its ends the profile stays at the end drop; :class:`~contactstudy.FiniteLength` ends a
    roller shorter than the grid.

    Source: Lundberg (1939), Forschung auf dem Gebiete des Ingenieurwesens 10, 201; the finite drop at the
    ends is Johns & Gohar's (1981), Tribology International 14, 131.
    """

    amplitude: Metres
    end_drop: Metres
    length: Metres

    def __post_init__(self) -> None:
        set_fields(
            self,
            amplitude=in_range_from_zero("LundbergProfile.amplitude", self.amplitude, HEIGHT),
            end_drop=in_range_from_zero("LundbergProfile.end_drop", self.end_drop, HEIGHT),
            length=in_range(
                "LundbergProfile.length", self.length, "give the roller's length above 0 m"
            ),
        )

    @classmethod
    def for_load(
        cls, load_per_length: float, *, contact_modulus: float, radius: float, length: float
    ) -> Self:
        """The profile under which ``load_per_length`` [N/m] is spread evenly along the roller.

        ``contact_modulus`` E* [Pa], ``radius`` R of the cylinder [m], ``length`` L of the roller [m].
        Hertz's pressure, ending at ``|y| = L / 2``, lowers the axis by
        ``A ln(1 / (1 - (2 y / L)^2))`` less than the middle, A = W / (pi E*), and the ends themselves by
        ``A (ln(L / a) + 1/2)``. The factor 0.3033 of Johns & Gohar (1981) is ``exp(-1/2) / 2``.
        Raises :class:`~contactstudy.InvalidInput` for a roller shorter than its contact is wide.
        """
        hertz = HertzLine(load_per_length, radius, contact_modulus)
        length = in_range("LundbergProfile.length", length, "give the roller's length above 0 m")
        if length < 2 * hertz.half_width:
            raise InvalidInput(
                f"LundbergProfile.length is {length!r}: give a roller longer than its contact is wide, "
                f"{2 * hertz.half_width!r} m."
            )
        amplitude = load_per_length / (pi * contact_modulus)
        return cls(amplitude, amplitude * (log(length / hertz.half_width) + 0.5), length)

    @property
    def curvature(self) -> float:
        """None of the cross-section."""
        return 0.0

    @property
    def detail(self) -> Detail:
        """The roller it is made for."""
        return Detail(roller=self.length)

    def gap(self, grid: Grid) -> Array:
        """The profile at the cell centres, shape (1, length), or (nx, 1) where there is none [m]."""
        if self.amplitude == 0 or self.end_drop == 0:
            return np.zeros((grid.cells[0], 1))
        t = np.abs(2 * grid.y / self.length)
        inside = t < 1
        t = np.where(inside, t, 0.0)
        # in a form that keeps the parabola which it is where A is far above d
        drop = -self.amplitude * np.log1p(expm1(-self.end_drop / self.amplitude) * t**2)
        return np.where(inside, drop, self.end_drop)[None, :]


@dataclass(frozen=True)
class FiniteLength:
    """A roller that ends at ``|y| = length / 2``, with flat, sharp-edged faces.

    ``length`` [m], above zero, else :class:`~contactstudy.InvalidInput`. Cells whose centre lies beyond
    the ends stand back by ``length``: more than any elastic displacement, which is a small part of
    the body's own size, and finite, so that averages over blocks of cells stay finite too. The end is
    therefore resolved to a cell, and exactly where it falls between two. Under a scene's load per length
    of the grid, the roller carries that times the grid's period over its own length. Along a free length a
    grid of the roller's own length ends it as well, without a cell to spare.
    """

    length: Metres

    def __post_init__(self) -> None:
        set_fields(
            self,
            length=in_range(
                "FiniteLength.length", self.length, "give the roller's length above 0 m"
            ),
        )

    @property
    def curvature(self) -> float:
        """None."""
        return 0.0

    @property
    def detail(self) -> Detail:
        """The roller."""
        return Detail(roller=self.length)

    def gap(self, grid: Grid) -> Array:
        """Zero on the roller, ``length`` beyond it, shape (1, length), or (nx, 1) without an end [m]."""
        beyond = np.abs(grid.y) > self.length / 2
        if not beyond.any():
            return np.zeros((grid.cells[0], 1))
        return np.where(beyond, self.length, 0.0)[None, :]

"""Machined textures, such as dimples and grooves, and waviness."""

from math import inf, pi
from typing import Annotated, Literal

import numpy as np

from contactstudy.domain import validation
from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.validation import InvalidInput, validated, whole_quotient
from contactstudy.scene.shapes.shape import LengthScales, no_gap

Wavelength = Annotated[validation.Metres, validation.OR_INFINITE]


Profile = Literal["parabolic", "cosine", "flat"]


def flank(profile: Profile, t: Array) -> Array:
    """Return the fraction of the depth of a feature at each fraction `t` of the way from middle (0) to rim (1)."""
    if profile == "flat":
        return np.ones_like(t)
    return np.asarray((1 - t) * (1 + t) if profile == "parabolic" else (1 + np.cos(np.pi * t)) / 2)


@validated
class Dimple:
    """Round dimple of a texture.

    Parameters
    ----------
    depth
        Depth [m], at least zero.
    diameter
        Diameter at the rim [m], above zero.
    profile
        Flank: "parabolic", ``1 - t^2`` on the way t to the rim, as the paraboloid that stands for a sphere in Hertz's
        theory; "cosine", ``(1 + cos(pi t)) / 2``, without a kink at the rim; or "flat", of the full depth up to the rim.
    """

    depth: Annotated[validation.Metres, validation.AT_LEAST_ZERO]
    diameter: validation.Metres
    profile: Profile = "parabolic"

    @property
    def size(self) -> float:
        """Diameter [m]."""
        return self.diameter

    def density(self, pitch: tuple[float, float]) -> float:
        """Return the dimpled fraction of the surface, ``pi d^2 / 4`` over the cell of the lattice."""
        return pi / 4 * (self.diameter / pitch[0]) * (self.diameter / pitch[1])


@validated
class Groove:
    """Straight groove of a texture.

    Parameters
    ----------
    depth
        Depth [m], at least zero.
    width
        Width at the rim [m], above zero.
    profile
        Flank, "parabolic", "cosine" or "flat", as of a :class:`~contactstudy.Dimple`.
    """

    depth: Annotated[validation.Metres, validation.AT_LEAST_ZERO]
    width: validation.Metres
    profile: Profile = "cosine"

    @property
    def size(self) -> float:
        """Width [m]."""
        return self.width

    def density(self, pitch: tuple[float, float]) -> float:
        """Return the grooved fraction of the surface."""
        return self.width / min(pitch)


@validated
class Texture:
    """Dimples on a rectangular lattice, or parallel grooves, one of them centred at the origin.

    Depths are sampled at the cell centres, so that the area of a feature a few cells wide is approximate.

    Parameters
    ----------
    feature
        A :class:`~contactstudy.Dimple` or a :class:`~contactstudy.Groove`.
    pitch
        Distance (across, along) [m] between neighbours. Dimples have two finite pitches, grooves one: ``(p, inf)`` are
        grooves along the length, ``(inf, p)`` across it.

    Raises
    ------
    InvalidInput
        If features overlap, a pitch is missing, or the pitch along does not divide the grid's period.
    """

    feature: Dimple | Groove
    pitch: tuple[Wavelength, Wavelength]

    def check_together(self) -> None:
        """Check that features have the pitches of their kind, and do not overlap."""
        pitch = self.pitch
        finite_pitches = 2 if isinstance(self.feature, Dimple) else 1
        if sum(distance < inf for distance in pitch) != finite_pitches or self.feature.size > min(pitch):
            raise InvalidInput(
                f"Texture.pitch is {pitch!r}: give two pitches for dimples, one and inf for grooves, of at least "
                f"{self.feature.size!r} m, the size of the feature, so that none overlap."
            )

    @property
    def area_density(self) -> float:
        """Textured fraction of the surface."""
        return self.feature.density(self.pitch)

    @property
    def length_scales(self) -> LengthScales:
        """Length scales, since features, and the lands between them, are as fine as they are wide."""
        if self.feature.depth == 0:
            return LengthScales()
        size, (across, along) = self.feature.size, self.pitch
        finest = _narrowest(size, across), _narrowest(size, along)
        period = along if along < inf else 0.0
        # a depth over half the size, on the textured fraction of the surface
        slope = 2 * self.feature.depth / size * self.area_density**0.5
        return LengthScales(finest, period, period_across=across if across < inf else 0.0, slope=slope)

    def gap(self, grid: Grid) -> Array:
        """Return depths [m] at the cell centres, of shape (x, y), or (nx, 1) for grooves along the length."""
        across, along = self.pitch
        whole_quotient("Texture.pitch[1]", along, grid.length)
        if self.feature.depth == 0:
            return no_gap(grid)
        y = grid.y if along < inf else np.zeros(1)
        distance = np.hypot(_from_nearest(grid.x, across)[:, None], _from_nearest(y, along))
        t = distance / (self.feature.size / 2)
        depth = self.feature.depth * flank(self.feature.profile, np.minimum(t, 1))
        return np.where(t < 1, depth, 0.0)


def _narrowest(size: float, pitch: float) -> float:
    """Return the smaller width [m] of a feature and the land beside it; infinite where nothing repeats."""
    if pitch == inf:
        return inf
    return min(size, pitch - size) if pitch > size else size


def _from_nearest(position: Array, pitch: float) -> Array:
    """Return the offset [m] from the nearest multiple of `pitch`; zero where nothing repeats."""
    if pitch == inf:
        return np.zeros_like(position)
    return np.asarray(position - pitch * np.round(position / pitch))


@validated
class Waviness:
    """Plane wave of height, ``amplitude cos(2 pi (x / across + y / along) + phase)``.

    Heights count out of the body, as those of a :class:`~contactstudy.MeasuredSurface`: with an amplitude above zero and
    no phase a crest, which touches first, lies at the origin.

    Parameters
    ----------
    amplitude
        Amplitude [m].
    across, along
        Wavelengths [m], infinite by default: no waves in that direction.
    phase
        Angle at the origin [rad].

    Raises
    ------
    InvalidInput
        If a period of the grid does not hold a whole number of waves along.
    """

    amplitude: Annotated[validation.Metres, validation.ANY_SIGN]
    across: Wavelength = inf
    along: Wavelength = inf
    phase: Annotated[validation.Radians, validation.FINITE] = 0.0

    @property
    def length_scales(self) -> LengthScales:
        """Length scales of the wave."""
        if self.amplitude == 0:
            return LengthScales()
        period = self.along if self.along < inf else 0.0
        slope = np.sqrt(2) * np.pi * abs(self.amplitude) * np.hypot(1 / self.across, 1 / self.along)
        return LengthScales(
            (self.across, self.along),
            period,
            period_across=self.across if self.across < inf else 0.0,
            height=abs(self.amplitude),
            slope=float(slope),
        )

    def gap(self, grid: Grid) -> Array:
        """Return the depth below the mean at the cell centres [m], of shape (x, y), or (nx, 1) without waves along."""
        whole_quotient("Waviness.along", self.along, grid.length)
        y = grid.y if self.amplitude and self.along < inf else np.zeros(1)
        angle = 2 * np.pi * (grid.x[:, None] / self.across + y / self.along) + self.phase
        return np.asarray(-self.amplitude * np.cos(angle))

"""Heights of the undeformed gap; the shapes of a scene add up."""

from dataclasses import dataclass
from math import inf
from typing import Protocol, runtime_checkable

import numpy as np

from contactstudy.domain.arrays import Array
from contactstudy.domain.checks import bearable, bearable_or_zero, divides, finite, keep
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import Metres, Radians
from contactstudy.scene.shapes.detail import Detail


@runtime_checkable
class Shape(Protocol):
    """Anything that opens a gap."""

    @property
    def curvature(self) -> float:
        """Curvature of the mean cross-section at the axis [1/m]; zero where a shape has none."""
        ...

    def gap(self, grid: Grid) -> Array:
        """Undeformed gap [m] at the cell centres; broadcasts to (width, length).

        The shape (width, 1) says that nothing varies along the length.
        """
        ...


@dataclass(frozen=True)
class Cylinder:
    """A parabolic cylinder about the length axis, ``x^2 / (2 R)``, as in Hertz's theory.

    ``radius`` R [m], above zero, else :class:`~contactstudy.InvalidInput`. Two cylinders in one scene
    are two curved bodies: curvatures add.
    """

    radius: Metres

    def __post_init__(self) -> None:
        keep(self, radius=bearable("Cylinder.radius", self.radius, "give a radius above 0 m"))

    @property
    def curvature(self) -> float:
        """1 / R [1/m]."""
        return 1 / self.radius

    @property
    def detail(self) -> Detail:
        """Smooth."""
        return Detail()

    def gap(self, grid: Grid) -> Array:
        """``x^2 / (2 R)``, shape (width, 1) [m]."""
        return (grid.x**2 / (2 * self.radius))[:, None]


@dataclass(frozen=True)
class Waviness:
    """A plane wave of height, ``amplitude cos(2 pi (x / across + y / along) + phase)``.

    ``amplitude`` [m]; wavelengths ``across`` and ``along`` [m], infinite by default, which is none in
    that direction; ``phase`` [rad]. Raises :class:`~contactstudy.InvalidInput` where a period of the
    grid does not hold a whole number of waves along.
    """

    amplitude: Metres
    across: Metres = inf
    along: Metres = inf
    phase: Radians = 0.0

    def __post_init__(self) -> None:
        keep(
            self,
            amplitude=bearable_or_zero("Waviness.amplitude", self.amplitude, "give a height in m"),
            phase=finite("Waviness.phase", self.phase, "give an angle in rad"),
        )
        for name in ("across", "along"):
            if getattr(self, name) != inf:
                length = bearable(
                    f"Waviness.{name}", getattr(self, name), "give a wavelength above 0 m"
                )
                keep(self, **{name: length})

    @property
    def curvature(self) -> float:
        """None on the mean."""
        return 0.0

    @property
    def detail(self) -> Detail:
        """One wave."""
        if self.amplitude == 0:
            return Detail()
        repeat = self.along if self.along < inf else 0.0
        slope = np.sqrt(2) * np.pi * abs(self.amplitude) * np.hypot(1 / self.across, 1 / self.along)
        return Detail(
            (self.across, self.along), repeat, 0.0, height=abs(self.amplitude), slope=float(slope)
        )

    def gap(self, grid: Grid) -> Array:
        """The wave at the cell centres [m], shape (width, length), or (width, 1) without waves along."""
        divides("Waviness.along", self.along, grid.period)
        y = grid.y if self.amplitude and self.along < inf else np.zeros(1)
        angle = 2 * np.pi * (grid.x[:, None] / self.across + y / self.along) + self.phase
        return np.asarray(self.amplitude * np.cos(angle))


@dataclass(frozen=True)
class Sphere:
    """A paraboloid about the origin, ``(x^2 + y^2) / (2 R)``, as in Hertz's theory of a sphere.

    ``radius`` R [m], above zero, else :class:`~contactstudy.InvalidInput`. Along a free length it is a
    point contact under the load per length times the grid's period.
    """

    radius: Metres

    def __post_init__(self) -> None:
        keep(self, radius=bearable("Sphere.radius", self.radius, "give a radius above 0 m"))

    @property
    def curvature(self) -> float:
        """None of a line contact."""
        return 0.0

    @property
    def detail(self) -> Detail:
        """A roller of its own."""
        return Detail(roller=inf)

    def gap(self, grid: Grid) -> Array:
        """``(x^2 + y^2) / (2 R)``, shape (width, length) [m]."""
        return np.asarray((grid.x[:, None] ** 2 + grid.y**2) / (2 * self.radius))

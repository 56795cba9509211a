"""Round bodies: a cylinder, a sphere."""

from dataclasses import dataclass
from math import inf

import numpy as np

from contactstudy.domain.checks import in_range, set_fields
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import Metres
from contactstudy.scene.shapes.detail import Detail


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

"""Plane waves of height."""

from dataclasses import dataclass
from math import inf

import numpy as np

from contactstudy.domain.checks import divides, finite, in_range, in_range_or_zero, set_fields
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.units import Metres, Radians
from contactstudy.scene.shapes.detail import Detail


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
        set_fields(
            self,
            amplitude=in_range_or_zero("Waviness.amplitude", self.amplitude, "give a height in m"),
            phase=finite("Waviness.phase", self.phase, "give an angle in rad"),
        )
        for name in ("across", "along"):
            if getattr(self, name) != inf:
                length = in_range(
                    f"Waviness.{name}", getattr(self, name), "give a wavelength above 0 m"
                )
                set_fields(self, **{name: length})

    @property
    def curvature(self) -> float:
        """Zero in the mean."""
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
        """The wave at the cell centres [m], shape (x, y), or (nx, 1) without waves along."""
        divides("Waviness.along", self.along, grid.period)
        y = grid.y if self.amplitude and self.along < inf else np.zeros(1)
        angle = 2 * np.pi * (grid.x[:, None] / self.across + y / self.along) + self.phase
        return np.asarray(self.amplitude * np.cos(angle))

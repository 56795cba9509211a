"""The pressures a contact may take: never tensile, and carrying the load."""

from dataclasses import dataclass, replace

import numpy as np

from contactstudy.arrays import Array


@dataclass(frozen=True)
class AdmissiblePressures:
    """``p >= 0`` and ``sum(p) = total`` (the load over the cell's area, in the unit of p)."""

    total: float

    def scaled(self, factor: float) -> "AdmissiblePressures":
        """The same set in another unit of pressure, or of area."""
        return replace(self, total=self.total * factor)

    def uniform(self, shape: tuple[int, int]) -> Array:
        """The same pressure everywhere."""
        return np.full(shape, self.total / (shape[0] * shape[1]))

    def clip(self, pressure: Array) -> Array:
        """Tension cut off, in place."""
        return np.maximum(pressure, 0, out=pressure)

    def balance(self, pressure: Array) -> Array:
        """Scaled in place so that it carries the load."""
        pressure *= self.total / pressure.sum()
        return pressure

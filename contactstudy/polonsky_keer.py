"""The conjugate gradient scheme of Polonsky & Keer (1999)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contactstudy.arrays import Array, inner
from contactstudy.pressures import AdmissiblePressures


@dataclass(frozen=True, eq=False)
class Iterate:
    """Where an iteration stopped; all dimensionless."""

    pressure: Array
    displacement: Array
    approach: float
    residual: float
    iterations: int
    convolutions: int


@dataclass(frozen=True)
class PolonskyKeer:
    """Conjugate gradients on the cells in contact, restarted when the contact gains a cell.

    Two convolutions per iteration. Source: Polonsky & Keer (1999), Wear 231, sect. 3.
    """

    def iterate(
        self,
        undeformed_gap: Array,
        displacement: Callable[[Array], Array],
        pressures: AdmissiblePressures,
        residual: Callable[[Array, Array], float],
        *,
        tolerance: float,
        max_iterations: int,
    ) -> Iterate:
        """Iterate until ``residual(pressure, gap) <= tolerance``; all arguments dimensionless."""
        pressure = pressures.uniform(undeformed_gap.shape)
        direction = np.zeros_like(pressure)
        previous, conjugate = 1.0, 0.0
        iteration = 0
        while True:
            moved = displacement(pressure)
            gap = undeformed_gap + moved
            contact = pressure > 0
            approach = float(gap[contact].mean())
            gap -= approach
            left = residual(pressure, gap)
            if not (tolerance < left < np.inf) or iteration == max_iterations:
                convolutions = 2 * iteration + 1
                return Iterate(pressure, moved, approach, left, iteration, convolutions)
            iteration += 1
            descent = np.where(contact, gap, 0.0)
            steepness = inner(descent, descent)
            direction = np.where(contact, gap + conjugate * (steepness / previous) * direction, 0.0)
            previous = steepness
            response = displacement(direction)
            response -= response[contact].mean()
            step = inner(descent, direction) / inner(response, direction)
            pressure = pressures.clip(pressure - step * direction)
            overlap = (pressure == 0) & (gap < 0)
            conjugate = 0.0 if overlap.any() else 1.0
            pressure[overlap] -= step * gap[overlap]
            pressure = pressures.balance(pressure)

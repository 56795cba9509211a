"""The conjugate gradient scheme of Polonsky & Keer (1999)."""

from dataclasses import dataclass

import numpy as np

from contactstudy.arrays import Array, inner
from contactstudy.iterate import Iterate, Stall
from contactstudy.problem import BareProblem


@dataclass(frozen=True)
class PolonskyKeer:
    """Conjugate gradients on the cells in contact, restarted when the contact gains a cell.

    Two convolutions per iteration. ``patience`` is the number of iterations without a halving of the
    residual after which it stops. Source: Polonsky & Keer (1999), Wear 231, sect. 3.
    """

    patience: int = 400

    def iterate(
        self,
        problem: BareProblem,
        *,
        tolerance: float,
        max_iterations: int,
        start: Array | None = None,
    ) -> Iterate:
        """Iterate until ``problem.residual(pressure, gap) <= tolerance``."""
        pressures = problem.pressures
        pressure = pressures.uniform(problem.undeformed_gap.shape) if start is None else start
        direction = np.zeros_like(pressure)
        previous, conjugate = 1.0, 0.0
        stall = Stall(self.patience)
        own = problem.displacement.own
        iteration = 0
        while True:
            moved = problem.displacement(pressure)
            gap = problem.undeformed_gap + moved
            contact = pressure > 0
            approach = float(gap[contact].mean())
            gap -= approach
            left = problem.residual(pressure, gap)
            done = not (tolerance < left < np.inf) or iteration == max_iterations
            if done or stall.sees(left):
                convolutions = 2.0 * iteration + 1
                return Iterate(pressure, moved, approach, left, iteration, convolutions)
            iteration += 1
            descent = np.where(contact, gap, 0.0)
            steepness = inner(descent, descent)
            kept = conjugate * steepness / previous if previous > 0 else 0.0
            direction = np.where(contact, gap + kept * direction, 0.0)
            previous = steepness
            response = problem.displacement(direction)
            response -= response[contact].mean()
            curvature = inner(response, direction)
            # a single cell in contact is level with itself: the others then close their own gaps
            step = inner(descent, direction) / curvature if curvature > 0 else 1 / own
            pressure = pressures.clip(pressure - step * direction)
            overlap = (pressure == 0) & (gap < 0)
            conjugate = 0.0 if overlap.any() else 1.0
            pressure[overlap] -= step * gap[overlap]
            pressure = pressures.balance(pressure)

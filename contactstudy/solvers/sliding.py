"""Full sliding: shear is the coefficient of friction times pressure, everywhere and in one direction."""

from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.devices.arrays import Array
from contactstudy.elasticity.tangential import Correlated
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import Solution, Status, Traction
from contactstudy.solvers.solve import Repeat

# Errors fall by at least 1.7 from one pass to the next where both bodies are elastic and friction is below 1.
MOST_PASSES = 200


@dataclass(frozen=True, eq=False)
class FullSliding:
    """Traction ``coefficient * pressure`` along x on the first body, and its reaction on the second.

    ``coupling`` is the normal displacement under unit shear [m/Pa]; None where both bodies give way
    alike, so that shear does not change the pressure.
    """

    coefficient: float
    coupling: Correlated | None

    def solved(self, problem: Problem, repeat: Repeat) -> Solution:
        """The pressure, in one pass or with the shear of the pass before until it no longer changes.

        The coupling is odd, so that it has no place in a symmetric operator: its displacement is added to the
        gap. The pass is the last whose own shear changes the gap by less than the tolerance.
        """
        found = repeat.solve(problem, repeat.start)
        if self.coupling is None:
            return replace(found, traction=self._traction(found.pressure, 1))
        moved = np.zeros_like(found.gap)
        iterations, convolutions = found.iterations, found.convolutions
        passes, left = 1, np.inf
        while True:
            now = self.coefficient * self.coupling(found.pressure)
            convolutions += 1
            left = _difference(now - moved, found.pressure) / problem.scales.gap
            if left <= repeat.tolerance or passes == MOST_PASSES or not np.isfinite(left):
                break
            moved = now
            shifted = replace(problem, undeformed_gap=problem.undeformed_gap + moved)
            found = repeat.solve(shifted, found.pressure)
            iterations, convolutions = (
                iterations + found.iterations,
                convolutions + found.convolutions,
            )
            passes += 1
        status = found.status
        if status is Status.CONVERGED and not left <= repeat.tolerance:
            status = Status.STALLED
        return replace(
            found,
            problem=problem,
            displacement=found.displacement + moved,
            status=status,
            iterations=iterations,
            convolutions=convolutions,
            residual=max(found.residual, left),
            note=" ".join(filter(None, (found.note, f"{passes} passes over the shear."))),
            traction=self._traction(found.pressure, passes),
        )

    def _traction(self, pressure: Array, passes: int) -> Traction:
        shear = np.stack([self.coefficient * pressure, np.zeros_like(pressure)])
        method = "full sliding" if self.coupling is None else "full sliding, shear lagged"
        return Traction(shear, np.zeros(pressure.shape, dtype=bool), method, passes)


def _difference(change: Array, pressure: Array) -> float:
    """How much a change of the gap is felt: its largest deviation in the contact from its mean there."""
    touching = pressure > 0
    if not touching.any():
        return 0.0
    within = change[touching]
    return float(np.abs(within - within.mean()).max())

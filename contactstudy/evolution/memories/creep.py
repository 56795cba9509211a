"""What a viscoelastic half-space keeps: one field per term of its creep."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import exp, expm1
from typing import ClassVar

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.coefficients import Coefficients
from contactstudy.elasticity.viscoelastic import Creep
from contactstudy.evolution.memories.memory import Contribution, State, Step
from contactstudy.problem.problem import Field


@dataclass(frozen=True)
class CreepMemory:
    """Delayed pressures c_i with ``c_i' = (p - c_i) / lambda_i``, and for a fluid the impulse ``b' = p``.

    The surface moves as under ``J_0 p + sum(J_i c_i) + fluidity b``, whose weights are those of ``creep`` [1/Pa], by
    the influence ``coefficients`` [m]. Exact for a pressure that is linear in a step.
    """

    creep: Creep
    coefficients: Coefficients

    has_stages: ClassVar[bool] = False

    def start(self, shape: tuple[int, int]) -> State:
        """Nothing."""
        names = [f"delayed{number}" for number in range(len(self.creep.terms))]
        names += ["impulse"] * bool(self.creep.fluidity)
        return {name: np.zeros(shape) for name in names}

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """The part of the strain that the past has fixed, and the compliance of a step so long."""
        strain = np.zeros_like(pressure)
        more = 0.0
        for number, (size, time) in enumerate(self.creep.terms):
            kept, before, after = weights(step.duration / time)
            strain += (size * kept) * state[f"delayed{number}"]
            strain += (size * before) * pressure
            more += size * after
        if self.creep.fluidity:
            half = self.creep.fluidity * step.duration / 2
            strain += self.creep.fluidity * state["impulse"] + half * pressure
            more += half
        return Contribution(
            strained={self.coefficients: strain}, compliance={self.coefficients: more}
        )

    def advance(self, state: State, before: Array, after: Array, step: Step) -> State:
        """The delayed pressures and the impulse at the end of the step."""
        new: dict[str, Array] = {}
        for number, (_, time) in enumerate(self.creep.terms):
            kept, first, last = weights(step.duration / time)
            new[f"delayed{number}"] = (
                kept * state[f"delayed{number}"] + first * before + last * after
            )
        if self.creep.fluidity:
            new["impulse"] = state["impulse"] + step.duration / 2 * (before + after)
        return new

    def fields(self, state: State) -> Mapping[str, Field]:
        """None."""
        return {}


def weights(ratio: float) -> tuple[float, float, float]:
    """How the delayed pressure after ``ratio`` = step / lambda is made of itself, p before and p after.

    They add up to 1 and none is negative: ``e, f - e, 1 - f`` with ``e = exp(-ratio)``, ``f = (1 - e) / ratio``.
    """
    kept = exp(-ratio)
    if ratio < 1e-3:  # where the quotient would cancel
        after = ratio / 2 - ratio**2 / 6 + ratio**3 / 24
        return kept, -expm1(-ratio) - after, after
    after = 1 + expm1(-ratio) / ratio
    return kept, -expm1(-ratio) - after, after

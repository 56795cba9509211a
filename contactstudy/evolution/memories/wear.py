"""What a wearing interface keeps: the depth that it has lost."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.evolution.memories.memory import Contribution, State, Step
from contactstudy.problem.problem import Field


@dataclass(frozen=True)
class WearMemory:
    """The worn depth w, ``dw/dt = rate p`` with ``rate`` [m/(Pa s)].

    The pressure before a step acts in its explicit share, the one after in the rest, which adds a constant to
    the operator. The volume is exact: where the load changes within the step, both are scaled to the
    mean load, or what a falling load leaves missing is worn by the pressure before.
    """

    rate: float

    has_stages: ClassVar[bool] = True

    def start(self, shape: tuple[int, int]) -> State:
        """Nothing is worn."""
        return {"worn_depth": np.zeros(shape)}

    def contribution(self, state: State, pressure: Array, step: Step) -> Contribution:
        """The depth worn so far, and what the pressure to come wears off."""
        before, after = self._shares(step)
        worn = state["worn_depth"]
        if before:
            worn = worn + before * pressure
        return Contribution(gap=worn, own=after)

    def advance(self, state: State, before: Array, after: Array, step: Step) -> State:
        """The depth at the end of the step."""
        first, last = self._shares(step)
        worn = state["worn_depth"] + last * after
        return {"worn_depth": worn + first * before if first else worn}

    def fields(self, state: State) -> Mapping[str, Field]:
        """``worn_depth``."""
        return {"worn_depth": Field(("x", "y"), state["worn_depth"], "m", "worn depth")}

    def _shares(self, step: Step) -> tuple[float, float]:
        """Depth over pressure [m/Pa] that the pressure before the step wears off in it, and the one after."""
        (first, last), mean, explicit = step.loads, step.mean_load, step.explicit
        whole = self.rate * step.duration
        carried = explicit * first + (1 - explicit) * last
        if carried >= mean:
            scale = mean / carried if carried else 0.0
            return whole * explicit * scale, whole * (1 - explicit) * scale
        if last == 0:
            return whole * (mean / first if first else 0.0), 0.0
        # no more than half of the rest explicitly, so that it stays stable
        more = min((mean - carried) / first, (1 - explicit) / 2) if first else 0.0
        explicit += more
        return whole * explicit, whole * (mean - explicit * first) / last


def explicit_limit(rate: float, contact_modulus: float, cell: float) -> float:
    """The longest step [s] of an explicit scheme in plane strain: ``1.48 dx / (rate E*)``.

    ``rate`` [m/(Pa s)], E* [Pa], ``cell`` dx [m]. The smallest eigenvalue of the influence matrix of touching cells is
    0.742 dx / E*, and an explicit step must be shorter than twice that over the rate.
    """
    return 1.484 * cell / (rate * contact_modulus)

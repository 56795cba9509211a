"""How an interface changes within a step."""

from enum import Enum
from math import sqrt

# The stage length at which a two-stage scheme of second order damps stiff changes entirely.
STAGE = 1 - 1 / sqrt(2)


class Scheme(Enum):
    """Stages of a step: each a share of its duration, and the share of that which is explicit.

    It matters to wear alone; creep is exact for a pressure that is linear in each stage. All keep the worn volume.
    """

    #: Second order, stable however long the step, two solves.
    #: Source: Alexander (1977), SIAM J. Numer. Anal. 14, sect. 3.
    TWO_STAGE = ((STAGE, 0.0), (1 - STAGE, (1 - 2 * STAGE) / (1 - STAGE)))
    #: First order, stable however long the step, one solve.
    IMPLICIT = ((1.0, 0.0),)
    #: First order, unstable beyond :func:`~contactstudy.evolution.memories.wear.explicit_limit`: for comparison.
    EXPLICIT = ((1.0, 1.0),)

    @property
    def stages(self) -> tuple[tuple[float, float], ...]:
        """(share of the duration, explicit share of the stage), in the order of time."""
        stages: tuple[tuple[float, float], ...] = self.value
        return stages

"""Steady rolling or sliding across."""

from dataclasses import dataclass
from math import inf

from contactstudy.domain.checks import in_range_from_zero, set_fields
from contactstudy.domain.units import MetresPerSecond


@dataclass(frozen=True)
class Rolling:
    """The contact moves to larger x at a constant ``speed`` [m/s] over both bodies, and has done so for ever.

    ``speed`` from 0 on; infinite, the bodies answer as to a sudden load. Heights move with the contact. See
    :func:`~contactstudy.solve_rolling`. Raises :class:`~contactstudy.InvalidInput` for other speeds.
    """

    speed: MetresPerSecond

    def __post_init__(self) -> None:
        if self.speed != inf:
            speed = in_range_from_zero("Rolling.speed", self.speed, "give a speed from 0 m/s on")
            set_fields(self, speed=speed)

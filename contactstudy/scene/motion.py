"""Relative motion of the bodies: steady rolling, and sliding that wears them."""

from dataclasses import dataclass
from math import inf

from contactstudy.domain.checks import InvalidInput, in_range_from_zero, set_fields, whole
from contactstudy.domain.units import MetresPerSecond, PerPascal


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


@dataclass(frozen=True)
class Wear:
    """``dw/ds = coefficient p``: both bodies together lose a depth w [m] along a sliding distance s [m].

    ``coefficient`` k [1/Pa] from 0 on; ``speed`` [m/s] from 0 on, so that ``ds = speed dt``. ``body`` (0 or 1
    of ``Scene.solids``) names the one that wears; the contact is the same whichever it is. The worn profile is
    that of a contact that stays where it is on the body that wears. On a roller that turns, wear spreads over
    the circumference: there give the coefficient times contact width over circumference. A scene with wear
    changes in time: see :func:`~contactstudy.evolve`. Source: Archard (1953).
    Raises :class:`~contactstudy.InvalidInput` for other numbers.
    """

    coefficient: PerPascal
    speed: MetresPerSecond
    body: int = 0

    def __post_init__(self) -> None:
        coefficient = in_range_from_zero(
            "Wear.coefficient", self.coefficient, "give a coefficient from 0 1/Pa on"
        )
        speed = in_range_from_zero("Wear.speed", self.speed, "give a speed from 0 m/s on")
        remedy = "give 0 or 1, the body's place in Scene.solids"
        body = whole("Wear.body", self.body, 0, remedy)
        if body > 1:
            raise InvalidInput(f"Wear.body is {self.body!r}: {remedy}.")
        set_fields(self, coefficient=coefficient, speed=speed, body=body)

    @property
    def rate(self) -> float:
        """Depth per pressure and time [m/(Pa s)]."""
        return self.coefficient * self.speed

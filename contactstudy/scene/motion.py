"""Relative motion of the bodies: steady rolling, and sliding that wears them."""

from dataclasses import dataclass
from math import inf

from contactstudy.domain.checks import answers_typos, body_index, in_range_from_zero, set_fields
from contactstudy.domain.units import MetresPerSecond, PerPascal


@answers_typos
@dataclass(frozen=True)
class Rolling:
    """Steady rolling: the contact moves to larger x at a constant speed over both bodies.

    Heights move with the contact. All transients have decayed; see :func:`~contactstudy.solve_rolling`.

    Parameters
    ----------
    speed
        Speed of the contact [m/s] from zero on. At infinite speed the bodies respond as to a sudden load.

    Raises
    ------
    InvalidInput
        If the speed is negative or not a number.
    """

    speed: MetresPerSecond

    def __post_init__(self) -> None:
        if self.speed != inf:
            speed = in_range_from_zero("Rolling.speed", self.speed, "give a speed from 0 m/s on")
            set_fields(self, speed=speed)


@answers_typos
@dataclass(frozen=True)
class Wear:
    """Sliding wear after Archard (1953), ``dw/ds = coefficient p``.

    Both bodies together lose a depth w [m] along a sliding distance s [m], under the pressure p. The worn profile
    holds for a contact that does not move on the wearing body. On a roller that turns, wear spreads over the
    circumference: multiply the coefficient by the contact width over the circumference. A scene with wear changes
    in time; see :func:`~contactstudy.evolve`.

    Parameters
    ----------
    coefficient
        Wear coefficient k [1/Pa], from zero on.
    speed
        Sliding speed [m/s], from zero on, so that ``ds = speed dt``.
    body
        Index (0 or 1) of the wearing body in ``Scene.solids``; the contact is the same for either.

    Raises
    ------
    InvalidInput
        If a number is outside these limits.
    """

    coefficient: PerPascal
    speed: MetresPerSecond
    body: int = 0

    def __post_init__(self) -> None:
        coefficient = in_range_from_zero(
            "Wear.coefficient", self.coefficient, "give a coefficient from 0 1/Pa on"
        )
        speed = in_range_from_zero("Wear.speed", self.speed, "give a speed from 0 m/s on")
        body = body_index("Wear.body", self.body)
        set_fields(self, coefficient=coefficient, speed=speed, body=body)

    @property
    def rate(self) -> float:
        """Worn depth per pressure and time [m/(Pa s)]."""
        return self.coefficient * self.speed

"""Relative motion of the bodies: steady rolling, and sliding that wears them."""

from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, Protocol

from contactstudy.analytic import HertzLine
from contactstudy.domain.checks import (
    InvalidInput,
    body_index,
    in_range_from_zero,
    positive,
    set_fields,
    suggest_fields,
    whole_number,
)
from contactstudy.domain.units import Metres, MetresPerSecond, Number, PerPascal
from contactstudy.scene.load import ChangingLoad, PiecewiseLinear

if TYPE_CHECKING:
    from contactstudy.scene.lubrication import Lubrication


class RollingPressure(Enum):
    """Choice of the pressure that rolls over a half-space."""

    #: Pressure of the contact solved together with the plastic strain.
    SOLVED = "solved"
    #: Pressure of the elastic contact throughout, as Merwin & Johnson (1963) assume.
    ELASTIC = "elastic"


@suggest_fields
@dataclass(frozen=True)
class Rolling:
    """Rolling: the contact moves to larger x, steadily over both bodies, or repeatedly over one that yields.

    Heights move with the contact.

    Parameters
    ----------
    speed
        Speed of the contact [m/s], at least zero, all transients decayed. At infinite speed the bodies respond
        instantaneously. Passes over a body that yields do not depend on it.
    passes
        Number of passes over a body that yields, at least 1; None rolls steadily.
    pressure
        Pressure of the passes.
    distance
        Distance of each pass [m]. None rolls until the plastic strain left behind is steady.
    steady
        A pass is steady when the plastic strain that it leaves changes by less than this many yield strains (Y / E)
        while the contact rolls by its half-width.

    Raises
    ------
    InvalidInput
        If the speed is negative or not a number, if neither speed nor passes are given, or for other numbers outside
        these limits.
    """

    speed: MetresPerSecond | None = None
    passes: int | None = None
    pressure: RollingPressure = RollingPressure.SOLVED
    distance: Metres | None = None
    steady: Number = 5e-3

    def __post_init__(self) -> None:
        if self.speed is None and self.passes is None:
            raise InvalidInput("Rolling.speed is None: give a speed of at least 0 m/s, or passes.")
        if self.speed not in (None, inf):
            speed = in_range_from_zero(
                "Rolling.speed", self.speed, "give a speed of at least 0 m/s"
            )
            set_fields(self, speed=speed)
        if self.passes is not None:
            whole_number(
                "Rolling.passes", self.passes, 1, "give a whole number of passes of at least 1"
            )
        if self.distance is not None:
            positive("Rolling.distance", self.distance, "give a distance above 0 m, or None")
        positive("Rolling.steady", self.steady, "give a part of the yield strain, such as 5e-3")


# Fewest widths of the contact by which it rolls while the load changes: what it rolls over is steady after one or two.
MIN_WIDTHS = 10.0


def check_slow(name: str, speed: float, load: ChangingLoad, hertz: HertzLine | None) -> None:
    """Raise InvalidInput for a `load` that changes too fast for rolling by `name` to be steady at each instant."""
    if hertz is None:
        return
    duration = getattr(load, "period", inf) / 4
    if isinstance(load, PiecewiseLinear):
        steps = zip(pairwise(load.times), pairwise(load.values), strict=True)
        duration = min((end - start for (start, end), (a, b) in steps if a != b), default=inf)
    widths = abs(speed) * duration / (2 * hertz.half_width)
    if widths < MIN_WIDTHS:
        raise InvalidInput(
            f"Scene.load changes within {duration:g} s together with {name}, while the contact rolls by {widths:.2g} of "
            f"its widths: rolling is steady under a load that changes over {MIN_WIDTHS:g} or more, give slower changes, "
            "or a higher speed."
        )


class WearContact(Protocol):
    """Properties of a scene that wear reads."""

    @property
    def load(self) -> object:
        """Load of the scene."""

    @property
    def rolling(self) -> Rolling | None:
        """Rolling, or None."""

    @property
    def friction(self) -> object | None:
        """Friction, or None."""

    @property
    def lubrication(self) -> "Lubrication | None":
        """Film, or None."""


@suggest_fields
@dataclass(frozen=True)
class Wear:
    """Sliding wear after Archard (1953), ``dw/ds = coefficient p``.

    Both bodies together lose a depth w [m] along a sliding distance s [m], under the pressure p; on a boundary film
    under the pressure of asperities. A body that turns through the contact wears alike all round, so that only its
    profile along the length changes. A scene with wear changes in time; see :func:`~contactstudy.solve`.

    Parameters
    ----------
    coefficient
        Specific wear rate k [1/Pa], the wear coefficient over the hardness, at least zero.
    speed
        Sliding speed [m/s], at least zero, so that ``ds = speed dt``; zero where slip or a film gives the sliding.
    body
        Index (0 or 1) of the wearing body in ``Scene.solids``; the contact is the same for either.
    circumference
        Circumference [m] of the wearing body where it rolls through the contact; None where it does not.

    Raises
    ------
    InvalidInput
        If a number is outside these limits; in a scene whose motion contradicts it, or whose bodies do not touch.
    """

    coefficient: PerPascal
    speed: MetresPerSecond
    body: int = 0
    circumference: Metres | None = None

    def __post_init__(self) -> None:
        coefficient = in_range_from_zero(
            "Wear.coefficient", self.coefficient, "give a coefficient of at least 0 1/Pa"
        )
        speed = in_range_from_zero("Wear.speed", self.speed, "give a speed of at least 0 m/s")
        body = body_index("Wear.body", self.body)
        set_fields(self, coefficient=coefficient, speed=speed, body=body)
        if self.circumference is not None:
            positive("Wear.circumference", self.circumference, "give a length above 0 m, or None")

    def check(self, scene: WearContact) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the motion of `scene` gives another sliding or turning."""
        film, drives = scene.lubrication, getattr(scene.friction, "is_steady", False)
        turns = drives or scene.rolling is not None
        why = "Scene.friction" if drives else "Scene.rolling"
        if film is not None:
            if film.boundary is None:
                raise InvalidInput(
                    "Scene.wear together with a film that has no boundary film: it keeps the bodies apart, so that "
                    "nothing wears, give Lubrication.boundary, or leave wear out."
                )
            turns, why = film.contact_speeds[self.body] != 0, "Scene.lubrication"
        if turns != (self.circumference is not None):
            problem = (
                f"None, and the wearing body turns by {why}, so that it wears alike all round: give its circumference"
                if turns
                else f"{self.circumference!r}, and the wearing body does not turn: leave it out"
            )
            raise InvalidInput(f"Wear.circumference is {problem}.")
        if self.speed != 0 and (film is not None or drives):
            raise InvalidInput(
                f"Wear.speed is {self.speed!r} together with {why}, which gives the sliding: give a speed of 0 m/s."
            )
        if (turns or film is not None) and isinstance(scene.load, ChangingLoad):
            raise InvalidInput(
                f"Scene.load changes in time together with Scene.wear and {why}: wear is followed from one steady "
                "contact to the next, give a LineLoad."
            )

    @property
    def rate(self) -> float:
        """Worn depth per pressure and time [m/(Pa s)]."""
        return self.coefficient * self.speed

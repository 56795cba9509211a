"""Rolling of the bodies: steady, or repeated over one that yields."""

from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from math import inf

from contactstudy.analytic import HertzLine
from contactstudy.domain.checks import (
    InvalidInput,
    check_fields,
    in_range_from_zero,
    instance,
    positive,
    suggest_fields,
    whole_number,
)
from contactstudy.domain.units import Metres, MetresPerSecond, Number
from contactstudy.scene.loads.load_history import ChangingLoad, PiecewiseLinear
from contactstudy.scene.shapes.shape import Shape


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

    Heights stand still in the frame of the contact: those that vary across slide over the body that creeps or yields.

    Parameters
    ----------
    speed
        Speed of the contact [m/s], at least zero. Rolling is steady, after all transients. At infinite speed the bodies
        respond instantaneously. None with passes, which do not depend on it.
    passes
        Number of passes over a body that yields, at least 1; None rolls steadily.
    pressure
        :class:`RollingPressure` of the passes.
    distance
        Distance of each pass [m]. None rolls until the plastic strain left behind is steady.
    steady
        A pass is steady when the plastic strain that it leaves changes by less than this many yield strains (Y / E)
        while the contact rolls by its half-width.

    Raises
    ------
    InvalidInput
        If neither speed nor passes are given, or both, if a setting of passes is given without passes, or if a value is
        outside these limits; in a scene with heights that move with a body.
    """

    speed: MetresPerSecond | None = None
    passes: int | None = None
    pressure: RollingPressure = RollingPressure.SOLVED
    distance: Metres | None = None
    steady: Number = 5e-3

    def __post_init__(self) -> None:
        if self.speed is None and self.passes is None:
            raise InvalidInput("Rolling.speed is None: give a speed of at least 0 m/s, or passes.")
        if self.speed is not None and self.passes is not None:
            raise InvalidInput(
                f"Rolling.speed is {self.speed!r} with passes, which do not depend on it: leave one of them out."
            )
        if self.speed not in (None, inf):
            check_fields(self, speed=(in_range_from_zero, "give a speed of at least 0 m/s"))
        if self.passes is not None:
            whole_number(
                "Rolling.passes", self.passes, 1, "give a whole number of passes of at least 1"
            )
        if self.distance is not None:
            positive("Rolling.distance", self.distance, "give a distance above 0 m, or None")
        positive("Rolling.steady", self.steady, "give a part of the yield strain, such as 5e-3")
        remedy = "give RollingPressure.SOLVED or RollingPressure.ELASTIC"
        instance("Rolling.pressure", self.pressure, RollingPressure, remedy)
        if self.passes is None:
            for name in ("pressure", "distance", "steady"):
                if (value := getattr(self, name)) != getattr(Rolling, name):
                    raise InvalidInput(
                        f"Rolling.{name} is {value!r} without passes, to which alone it applies: give passes, or leave "
                        "it out."
                    )


def check_standing(name: str, shapes: tuple[Shape, ...]) -> None:
    """Raise InvalidInput for heights among the `shapes` that move with a body, together with rolling by `name`."""
    for number, shape in enumerate(shapes):
        if hasattr(shape, "gap_after"):
            raise InvalidInput(
                f"Scene.shapes[{number}] moves with a body together with {name}: heights that travel through the "
                "contact make no steady state, give heights that are fixed in its frame."
            )


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

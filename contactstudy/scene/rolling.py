"""Rolling of the bodies: steady, or repeated over one that yields."""

from itertools import pairwise
from math import inf
from typing import Annotated, Literal

from contactstudy.analytic import HertzLine
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.units import Metres, MetresPerSecond, Number
from contactstudy.domain.validation import FROM_ZERO_TO_INFINITE, at_least, validated
from contactstudy.scene.loads.load_history import ChangingLoad, PiecewiseLinear
from contactstudy.scene.shapes.shape import Shape
from contactstudy.scene.solids.bodies import SceneContext

RollingPressure = Literal["solved", "elastic"]


@validated
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
        Pressure of the passes: "solved" together with the plastic strain, or that of the "elastic" contact throughout,
        as Merwin & Johnson (1963) assume.
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

    speed: Annotated[MetresPerSecond, FROM_ZERO_TO_INFINITE] | None = None
    passes: Annotated[int, at_least(1)] | None = None
    pressure: RollingPressure = "solved"
    distance: Metres | None = None
    steady: Number = 5e-3

    def check_together(self) -> None:
        """Check that rolling is either steady or by passes, and that a setting of passes has them."""
        if self.speed is None and self.passes is None:
            raise InvalidInput("Rolling.speed is None: give a speed of at least 0 m/s, or passes.")
        if self.speed is not None and self.passes is not None:
            raise InvalidInput(
                f"Rolling.speed is {self.speed!r} with passes, which do not depend on it: leave one of them out."
            )
        if self.passes is None:
            for name in ("pressure", "distance", "steady"):
                if (value := getattr(self, name)) != getattr(Rolling, name):
                    raise InvalidInput(
                        f"Rolling.{name} is {value!r} without passes, to which alone it applies: give passes, or leave "
                        "it out."
                    )

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for heights in `scene` that move with a body."""
        check_standing("Scene.rolling", scene.shapes)


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

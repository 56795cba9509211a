"""Rolling of the bodies: steady, repeated over one that yields, or steady with friction, stick and slip."""

from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from math import inf, isinf
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from contactstudy.analytic import HertzLine
from contactstudy.domain import validation
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.domain.validation import InvalidInput, at_least, validated
from contactstudy.elasticity.tangential import shear_response
from contactstudy.scene import friction
from contactstudy.scene.loads import ChangingLoad, PiecewiseLinear, turning_values
from contactstudy.scene.shapes.shape import LengthScales, Shape, gap_of, length_scales_of
from contactstudy.scene.solids.bodies import SceneContext
from contactstudy.scene.solids.inelastic import rolling_bodies
from contactstudy.solvers.solution import Creepage
from contactstudy.solvers.tractive_rolling import ShearPressureCoupling, TractiveShear

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

    speed: Annotated[validation.MetresPerSecond, validation.FROM_ZERO_TO_INFINITE] | None = None
    passes: Annotated[int, at_least(1)] | None = None
    pressure: RollingPressure = "solved"
    distance: validation.Metres | None = None
    steady: validation.Number = 5e-3

    def check_together(self) -> None:
        """Check that rolling is either steady or by passes, and that a setting of passes has them."""
        if (self.speed is None) == (self.passes is None):
            raise InvalidInput(
                f"Rolling.speed is {self.speed!r} and its passes {self.passes!r}: give a speed of at least 0 m/s, or "
                "passes, which do not depend on one."
            )
        if self.passes is None:
            for name in ("pressure", "distance", "steady"):
                if (value := getattr(self, name)) != getattr(Rolling, name):
                    raise InvalidInput(
                        f"Rolling.{name} is {value!r} without passes, to which alone it applies: give passes, or leave "
                        "it out."
                    )


# A contact at rest has PartialSlip.
NOT_ZERO = validation.Limits("other than 0", lambda x: validation.MIN_SIZE <= abs(x) <= validation.MAX_SIZE)
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


# Warning of traction under heights that vary across, which a real surface would carry through the contact.
STATIONARY_HEIGHTS = "The heights are fixed in the frame of the contact: traction under moving heights is not computed."


@validated
class TractiveRolling:
    """Steady rolling with creepage: a part of the contact sticks, the rest slips.

    The contact moves over both bodies, to larger x at a positive speed, and material enters it ahead. Heights are fixed
    in the frame of the contact: profiles, roller ends, circumferential lay. Creepage is the relative rigid-body velocity
    of the second body against the first over the rolling speed, so that a positive creepage makes a positive tangential
    traction on the first body. Between dissimilar bodies traction changes the pressure, and they slip under the normal
    load alone. Bodies that creep follow pressure and traction with their delay, which makes a rolling resistance.

    Parameters
    ----------
    coefficient
        Coefficient of friction, above 0 and below 1.
    longitudinal
        Creepage along x; None where a force is given.
    tangential
        Force along x on the first body, over the length that the load acts on [N/m], of either sign, less than the
        coefficient times the load. The longitudinal creepage follows from it. None where `longitudinal` is given.
    lateral
        Creepage along y.
    spin
        Rotation of the second body against the first about z, over the distance rolled [1/m]. Its slip grows along the
        length, so that a roller must end or be crowned on the grid.
    speed
        Speed of rolling [m/s], not 0; negative if the contact moves to smaller x. Power is proportional to its size,
        and how far a body creeps in the contact follows from it.
    total
        Force along x on the first body over the whole length of a roller [N], in place of `tangential`.

    Raises
    ------
    InvalidInput
        For other values; in a scene with bodies that yield, heights that move with a body, a load that changes too
        fast to roll steadily, or spin of an endless contact.
    """

    #: Friction transmits a traction while the contact rolls steadily.
    is_steady: ClassVar[bool] = True
    #: A part of the contact may stick.
    sticks: ClassVar[bool] = True

    coefficient: friction.FrictionCoefficient
    longitudinal: Annotated[validation.Number, validation.ANY_SIGN] | None = None
    tangential: Annotated[validation.NewtonsPerMetre, validation.ANY_SIGN] | None = None
    lateral: Annotated[validation.Number, validation.ANY_SIGN] = 0.0
    spin: Annotated[validation.PerMetre, validation.ANY_SIGN] = 0.0
    speed: Annotated[validation.MetresPerSecond, NOT_ZERO] = 1.0
    total: Annotated[validation.Newtons, validation.ANY_SIGN] | None = None

    def check_together(self) -> None:
        """Check that one creepage or force along x is given, and that the contact rolls."""
        given = [n for n in ("longitudinal", "tangential", "total") if getattr(self, n) is not None]
        if len(given) != 1:
            raise InvalidInput(
                f"TractiveRolling has {' and '.join(given) or 'none'} of longitudinal, tangential and total: give one, "
                "the creepage along x, the force along x [N/m], or that on the whole of a roller [N]."
            )

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if steady rolling is not defined in this scene."""
        friction.shearable(scene.solids)
        least = scene.largest_load
        if isinstance(scene.load, ChangingLoad):
            check_slow("TractiveRolling", self.speed, scene.load, scene.hertz)
            least = min(turning_values(scene.load))
        self._refuse_endless(_rollers(scene))
        friction.check_force(scene, self, least, "less, or a longitudinal creepage")

    def solver(self, scene: SceneContext, grid: Grid, paddings: Paddings, datum: float) -> TractiveShear:
        """Return the solver of this scene on a grid.

        Raises
        ------
        InvalidInput
            If the padding across wraps, so that material that leaves the contact would enter it again, or if it spins
            and no roller ends or is crowned on the grid.
        """
        gaps = [np.atleast_2d(gap_of(shape, grid)) for shape in _rollers(scene)]
        self._refuse_endless([np.ptp(gap, axis=1) for gap in gaps])
        if paddings[0].wraps:
            raise InvalidInput(
                f"padding[0] is {paddings[0]!r} together with TractiveRolling: material that leaves the contact would "
                "enter it again one period later: give ZeroPadding across."
            )
        solids = rolling_bodies(scene.solids, (self.speed, self.speed))
        bodies, force = friction.shearable(solids), friction.force_per_length(self, scene)
        has_waves = any(not isinf(scales.shortest_wavelengths[0]) for scales in length_scales_of(scene.shapes))
        coupling = friction.shear_coupling(solids, "xy", grid, paddings, datum)
        return TractiveShear(
            self.coefficient,
            Creepage(self.longitudinal or 0.0, self.lateral, self.spin),
            None if force is None else friction.mean_over_grid(force, scene, grid, paddings),
            self.speed,
            cache(lambda on: shear_response(bodies, on, paddings, datum)),
            ShearPressureCoupling(*coupling) if coupling else None,
            STATIONARY_HEIGHTS if has_waves else "",  # heights of a real surface would travel with it
        )

    def _refuse_endless(self, rollers: Sequence[Any]) -> None:
        """Raise InvalidInput for spin without `rollers` that end or are crowned, or where their drops [m] are 0."""
        if self.spin and not any(map(np.any, rollers)):
            raise InvalidInput(
                f"TractiveRolling.spin is {self.spin!r} in a contact without end, where its slip grows along the length "
                "without limit: give a roller that ends or is crowned on the grid, such as a FiniteLength or a Crown."
            )


def _rollers(scene: SceneContext) -> list[Shape]:
    """Return the shapes that may end or crown a roller."""
    unknown = LengthScales(roller=inf)  # taken for a shape that does not name its length scales
    return [s for s in scene.shapes if getattr(s, "length_scales", unknown).roller]

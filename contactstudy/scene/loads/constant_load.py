"""Constant loads that press the bodies together, and what may be given in place of one: an approach, or a pull-off."""

from math import e, exp, inf, isclose, pi
from typing import Annotated, ClassVar

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.domain.units import Metres, Newtons, NewtonsPerMetre, Number, readable
from contactstudy.domain.validation import ANY_SIGN, Limits, valid, validated
from contactstudy.scene.solids.bodies import SceneContext


@validated
class LineLoad:
    """Constant normal load per length of the contact.

    Parameters
    ----------
    per_length
        Load [N/m] over the length of the roller, of an endless one over that of the grid, above zero; together with
        :class:`~contactstudy.Adhesion` of any sign.

    Raises
    ------
    InvalidInput
        If the load is no finite number; in a scene without adhesion, if it is not above zero.
    """

    per_length: Annotated[NewtonsPerMetre, ANY_SIGN]

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` unless the load, or an attraction, presses the bodies together."""
        if scene.adhesion is None:
            valid("LineLoad.per_length", self.per_length, NewtonsPerMetre)

    @property
    def largest(self) -> float:
        """Load [N/m], which is its own maximum."""
        return self.per_length


@validated
class TotalLoad:
    """Constant normal load on the whole length of a roller.

    Parameters
    ----------
    total
        Load [N], above zero; together with :class:`~contactstudy.Adhesion` of any sign.
    length
        Length of the roller [m], over which the load is spread in Hertz's values. None takes that of the shortest
        roller among the shapes, such as a :class:`~contactstudy.LundbergProfile` or :class:`~contactstudy.FiniteLength`.
        A point contact, of a :class:`~contactstudy.Sphere` or an :class:`~contactstudy.Ellipsoid`, needs none.

    Raises
    ------
    InvalidInput
        If the load is no finite number or the length is not above zero; in a scene, if no shape has a length and there
        is none here, if both differ, or if the load is not above zero and there is no adhesion.
    """

    total: Annotated[Newtons, ANY_SIGN]
    length: Metres | None = None

    def length_on(self, shortest: float | None) -> float:
        """Return the length of the roller [m]: that given, or else that of the `shortest` roller among the shapes."""
        length = self.length or shortest
        if length is None:
            raise InvalidInput(
                "Scene.load is a TotalLoad, and no shape has the length of a roller: give TotalLoad.length [m], a "
                "FiniteLength among the shapes, or for a point contact shapes that are convex both ways, such as Sphere "
                "or Ellipsoid."
            )
        if not isclose(length, shortest or length):
            raise InvalidInput(
                f"TotalLoad.length is {length!r}, and the shortest roller among the shapes is {shortest!r} m long: "
                "leave it out, or give the shapes that length."
            )
        return length

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for a load that pulls without adhesion, and without a length."""
        if scene.adhesion is None:
            valid("TotalLoad.total", self.total, Newtons)
        _ = scene.roller_length


ConstantLoad = LineLoad | TotalLoad

# Distance from the axis at which the surface does not move, over the equivalent radius, where none is given.
DATUM_OVER_RADIUS = 2.0


@validated
class Approach:
    """Approach of the bodies, given in place of a load: the load is a result.

    It is relative to the undeformed gap, which is 0 m at the axis of a cylinder. Under a line load the approach grows
    without limit with the distance of the reference point, so that it is defined only together with a `datum`. A larger
    datum is a softer spring in series with the contact.

    Parameters
    ----------
    approach
        Approach [m], of any sign.
    datum
        Distance from the axis at which the surface does not move [m], at least half the width of the grid; None is twice
        the equivalent radius, from which every approach under a given load counts too, and the width of the grid without
        a curved shape. It is for a contact of which one axis alone has infinitely many images.

    Raises
    ------
    InvalidInput
        If a number is not finite, or the datum is not above 0 m; on a grid that is more than twice as wide as the datum,
        or with one where no axis or both have infinitely many images; with ExactPeriodicity along both axes, if the
        approach is not below the mean undeformed gap.
    """

    #: Largest given load [N/m]: none is given.
    largest: ClassVar[float] = 0.0

    approach: Annotated[Metres, ANY_SIGN]
    datum: Metres | None = None

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for an effect of `scene` that needs a given load."""
        named = {
            "Scene.hardness": scene.hardness != inf,
            "Scene.rolling": scene.rolling is not None,
            "Scene.lubrication": scene.lubrication is not None,
            scene.time_dependent_field: scene.time_dependent_field is not None,
        }
        for field, conflicts in named.items():
            if conflicts:
                raise InvalidInput(
                    f"Scene.load is an Approach together with {field}, which needs a given load: give a LineLoad."
                )

    def check_on(self, gap: Array, grid: Grid, paddings: Paddings, datum: float) -> None:
        """Raise InvalidInput for a given datum without an effect, one too near, and an approach that no pressure makes.

        The `gap` (x, y) [m] is undeformed, the `datum` [m] the one in use.
        """
        endless = sum(each.window is None for each in paddings)
        if self.datum is not None and endless != 1:
            raise InvalidInput(
                f"Approach.datum is {self.datum!r}, and {endless} axes have infinitely many images, so that it has "
                "no effect: leave it out, or give ExactPeriodicity along one axis."
            )
        if endless and datum < grid.extent[0] / 2:
            raise InvalidInput(
                f"Approach.datum is {self.datum!r}: give at least half the width of the grid, "
                f"{readable(grid.extent[0] / 2)}, or parts of the surface would rise under pressure."
            )
        # displacements count from their mean, which leaves no finite pressure there
        mean, rounding = float(gap.mean()), 4 * float(np.finfo(gap.dtype).eps * np.abs(gap).max())
        if endless == 2 and self.approach >= mean - rounding:
            raise InvalidInput(
                f"Scene.load is {self!r} with ExactPeriodicity along both axes, where displacements count from their "
                f"mean and no pressure brings the bodies closer than their mean undeformed gap of {readable(mean)}: "
                "give a smaller approach, or a LineLoad."
            )

    def estimated_load(self, contact_modulus: float, radius: float) -> float:
        """Return the load [N/m] of a smooth cylinder of a `radius` [m] at this approach; 0 if it does not touch.

        ``approach = u (2 ln(2 datum / a) + 1)`` with ``u = W / (pi E*)`` and ``a^2 = 4 u R``, Johnson (1985), sect. 5.6,
        solved by Lambert's function. Beyond its largest approach, ``datum^2 / R``, the load is that there.
        """
        if self.approach <= 0:
            return 0.0
        from scipy.special import lambertw  # imported late, since it is slow

        largest = (self.datum or DATUM_OVER_RADIUS * radius) ** 2 / radius
        turns = -lambertw(-min(self.approach / largest, 1.0) / e, -1).real
        return float(pi * contact_modulus * largest * exp(1 - turns))


@validated
class PullOff:
    """Separation of an adhesive contact, in place of a load: the pull-off load is a result.

    The contact is loaded to `preload` and then unloaded. The load at which it separates is found by bisection; each
    trial starts from the last state in equilibrium.

    Parameters
    ----------
    preload
        Load [N/m] from which the bodies are pulled apart, of any sign; above 0 for bodies that come from afar.
    error
        Difference of the last load in equilibrium and the first without, over the latter.

    Raises
    ------
    InvalidInput
        If the load is no finite number, or the error not between 1e-6 and 1; in a scene without adhesion.
    """

    preload: Annotated[NewtonsPerMetre, ANY_SIGN]
    error: Annotated[Number, Limits("from 1e-6 and below 1", lambda x: 1e-6 <= x < 1)] = 4e-3

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for a `scene` without adhesion, with a history, or that rolls."""
        if scene.adhesion is None:
            raise InvalidInput(
                "Scene.load is a PullOff without adhesion: give Scene.adhesion, such as Adhesion(work=0.05)."
            )
        if scene.time_dependent_field is not None:
            raise InvalidInput(
                f"Scene.load is a PullOff together with {scene.time_dependent_field}, which has a history: give a "
                "LoadHistory that falls until contact is lost."
            )
        if scene.rolling is not None:
            raise InvalidInput(
                "Scene.load is a PullOff together with Scene.rolling: elastic bodies that roll part at the load at "
                "which they do at rest, leave rolling out."
            )

    @property
    def per_length(self) -> float:
        """Load [N/m] from which the bodies are pulled apart."""
        return self.preload

    largest = per_length

"""Constant loads that press the bodies together."""

from math import isclose
from typing import Annotated

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.units import Metres, Newtons, NewtonsPerMetre
from contactstudy.domain.validation import ANY_SIGN, valid, validated
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

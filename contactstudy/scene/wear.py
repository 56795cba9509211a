"""Sliding wear of the bodies."""

from typing import Annotated

from contactstudy.domain import validation
from contactstudy.domain.validation import InvalidInput, validated
from contactstudy.scene.solids.bodies import SceneContext


@validated
class Wear:
    """Sliding wear after Archard (1953), ``dw/ds = coefficient p``.

    A body loses a depth w [m] along a sliding distance s [m], under the pressure p; on a boundary film under the
    pressure of asperities. Its coating becomes thinner, and its plastic strain comes nearer to the surface; of a coating
    that is worn through the answer ends with the status WORN_THROUGH. A body that turns through the contact wears alike
    all round, so that only its profile along the length changes. A scene with wear changes in time; see
    :func:`~contactstudy.solve`.

    Parameters
    ----------
    coefficient
        Specific wear rate k [1/Pa], the wear coefficient over the hardness, at least zero.
    speed
        Sliding speed [m/s], at least zero, so that ``ds = speed dt``; zero only where slip or a film gives it.
    body
        Index (0 or 1) of the wearing body in ``Scene.solids``.
    circumference
        Circumference [m] of the wearing body, or length of its track, where it moves through the contact, as in rolling
        and as a ring below a block; None where the contact stands still on it. Beside friction that says which body
        that is (:class:`~contactstudy.Sliding`), and beside rolling or a film, both must agree.

    Raises
    ------
    InvalidInput
        If a number is outside these limits; in a scene whose motion contradicts it, or whose bodies do not touch.
    """

    coefficient: Annotated[validation.PerPascal, validation.AT_LEAST_ZERO]
    speed: Annotated[validation.MetresPerSecond, validation.AT_LEAST_ZERO]
    body: validation.BodyIndex = 0
    circumference: validation.Metres | None = None

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the motion of `scene` gives another sliding or turning."""
        film, drives = scene.lubrication, scene.has_tractive_rolling
        standing = getattr(scene.friction, "standing", None)
        turns = self.circumference is not None or drives or scene.rolling is not None
        why = "Scene.rolling" if standing is None and not drives else "Scene.friction"
        if standing is not None:
            turns = standing != self.body
        if film is not None:
            turns, why = film.contact_speeds[self.body] != 0, "Scene.lubrication"
        if turns != (self.circumference is not None):
            problem = (
                f"None, and the wearing body turns by {why}, so that it wears alike all round: give its circumference"
                if turns
                else f"{self.circumference!r}, and the wearing body does not turn: leave it out"
            )
            raise InvalidInput(f"Wear.circumference is {problem}.")
        slips = film is not None or drives or getattr(scene.friction, "times", None) is not None
        if self.speed == 0 and not slips:
            raise InvalidInput(
                "Wear.speed is 0, and nothing else in the scene gives a sliding, so that nothing wears: give a speed "
                "above 0 m/s, Fretting with times, TractiveRolling or a film, or leave wear out."
            )

    @property
    def rate_per_pressure(self) -> float:
        """Wear rate per pressure ``k v`` [m/(Pa s)]."""
        return self.coefficient * self.speed

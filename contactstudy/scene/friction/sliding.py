"""Full sliding by Coulomb's law."""

from math import log
from typing import Annotated

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.domain.units import Number
from contactstudy.domain.validation import FROM_ZERO_BELOW_ONE, BodyIndex, validated
from contactstudy.scene.friction.friction_law import (
    are_similar,
    dundurs,
    shear_coupling,
)
from contactstudy.scene.solids.bodies import SceneContext, creeps
from contactstudy.solvers.friction.laws import FullSliding


@validated
class Sliding:
    """Full sliding: the second body slides to larger x over the first one.

    The tangential traction is the coefficient times the pressure, along +x on the first body, along -x on the second.
    Between elastically dissimilar bodies (Dundurs' beta) traction makes the pressure asymmetric; between similar ones
    the pressure is that without friction.

    Parameters
    ----------
    coefficient
        Coefficient of friction, at least 0 and below 1.
    standing
        Index (0 or 1) in ``Scene.solids`` of the body on which the contact stands still, such as a slider or a block: it
        wears in place, and does not creep from one place to the next. None for a contact that moves over both bodies.

    Raises
    ------
    InvalidInput
        For other coefficients; in a scene with repeated rolling, or with dissimilar bodies one of which creeps or that
        roll.
    """

    coefficient: Annotated[Number, FROM_ZERO_BELOW_ONE]
    standing: BodyIndex | None = None

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the coupling of these bodies is not supported."""
        beta = dundurs(scene.solids)
        if scene.rolling is not None and scene.rolling.passes is not None:
            raise InvalidInput(
                f"Scene.rolling has {scene.rolling.passes} passes together with Sliding: traction in repeated rolling "
                "is not supported, leave one of them out."
            )
        if are_similar(scene.solids) or self.coefficient == 0:
            return
        if any(map(creeps, scene.solids)):
            raise InvalidInput(
                f"Scene.solids are elastically dissimilar (Dundurs' beta {beta:.3g}) together with Sliding, and one "
                "creeps: creep of their coupling is not supported, give equal bodies, or an incompressible one on a "
                "rigid one."
            )
        if scene.rolling is not None:
            raise InvalidInput(
                f"Scene.solids are elastically dissimilar (Dundurs' beta {beta:.3g}) together with Sliding and "
                "Scene.rolling: both make the pressure asymmetric, and the combination is not supported: give bodies of "
                "one material, or TractiveRolling."
            )

    def solver(self, scene: SceneContext, gap: Array, grid: Grid, paddings: Paddings, datum: float) -> FullSliding:
        """Return the solver of this scene on a grid, with the coupling of traction and normal displacement."""
        if self.coefficient == 0:
            return FullSliding(self.coefficient, None)
        coupling = shear_coupling(scene.solids, "x", grid, paddings, datum)
        return FullSliding(self.coefficient, coupling[0] if coupling else None)

    def explanation(self, scene: SceneContext) -> str:
        """Return a sentence on the solves: one if the bodies are elastically similar, else a sequence of them."""
        beta = dundurs(scene.solids)
        if are_similar(scene.solids) or self.coefficient == 0:
            return (
                "friction: full sliding of elastically similar bodies, so the pressure is that without "
                "friction, in one solve."
            )
        return (
            f"friction: full sliding of dissimilar bodies (Dundurs' beta {beta:.3g}), solved with the traction of "
            f"the previous solve, in about {_outer_iterations(abs(beta) * self.coefficient)} outer iterations."
        )


def _outer_iterations(product: float) -> int:
    """Return the outer iterations to a tolerance of 1e-8, each of which leaves about the product of beta and mu."""
    return max(2, round(log(1e-8) / log(min(max(1.1 * product, 1e-8), 0.9))))

"""Partial slip under a tangential force."""

from typing import Annotated, ClassVar

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.domain.units import Newtons, NewtonsPerMetre, Pascals
from contactstudy.domain.validation import FINITE, BodyIndex, validated
from contactstudy.scene.friction.fretting import Fretting
from contactstudy.scene.friction.friction_law import (
    FrictionCoefficient,
    bulk_compliance,
    check_force,
    check_similar,
    check_static,
    check_tangential_response,
    force_per_length,
)
from contactstudy.scene.solids.bodies import SceneContext
from contactstudy.solvers.friction.fretting import PartialSlipShear


@validated
class PartialSlip:
    """Partial slip under a tangential force that friction holds back.

    The bodies are pressed first, then loaded tangentially, and never unloaded. The traction is that of
    :class:`~contactstudy.Fretting` with this one force, whose answer also has the slip and the energy lost.

    Parameters
    ----------
    coefficient
        Coefficient of friction, above 0 and below 1.
    tangential
        Force along x on the first body, over the length that the load acts on [N/m]; of either sign, less than the
        coefficient times the load, and beside adhesion times the sum of the load and of the attraction.
    total
        The same on the whole length of a roller [N], in place of `tangential`.
    bulk_stress
        Stress of one whole body along x [Pa], tension positive, which rises with the force (fretting fatigue). A strain
        of ``(1 - nu^2) / E`` times this adds to the slip, and its stress to that below the surface.
    bulk_body
        Index (0 or 1) of the body with the bulk stress.

    Raises
    ------
    InvalidInput
        For other values; in a scene with elastically dissimilar bodies, a change in time, or rolling.
    """

    sticks: ClassVar[bool] = True

    coefficient: FrictionCoefficient
    tangential: Annotated[NewtonsPerMetre, FINITE] | None = None
    total: Annotated[Newtons, FINITE] | None = None
    bulk_stress: Annotated[Pascals, FINITE] = 0.0
    bulk_body: BodyIndex = 0

    def check_together(self) -> None:
        """Check that one force is given."""
        if (self.tangential is None) == (self.total is None):
            raise InvalidInput(
                "PartialSlip.tangential and PartialSlip.total are both given or both None: give a force along x [N/m], "
                "or on the whole of a roller [N]."
            )

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the contact cannot stick, or its traction is not supported."""
        check_static(scene, "PartialSlip")
        check_tangential_response(scene, "PartialSlip", ", or Sliding")
        check_similar(scene, "PartialSlip", ", or Sliding")
        check_force(scene, self, scene.largest_load, "a smaller force, or Sliding")
        if self.bulk_stress:
            bulk_compliance(scene, self.bulk_body, "PartialSlip.bulk_stress")

    def solver(self, scene: SceneContext, gap: Array, grid: Grid, paddings: Paddings, datum: float) -> PartialSlipShear:
        """Return the solver of this scene on a grid: that of fretting with one force."""
        force = force_per_length(self, scene)
        assert force is not None
        stresses = (self.bulk_stress,) if self.bulk_stress else None
        fretting = Fretting(self.coefficient, (force,), bulk_stresses=stresses, bulk_body=self.bulk_body)
        return PartialSlipShear(fretting.solver(scene, gap, grid, paddings, datum))

    def explanation(self, scene: SceneContext) -> str:
        """Return a sentence on the solves of the traction."""
        return (
            "friction: partial slip by Newton's method, 20 to 60 applications of the response to both components of "
            "traction, four transforms each, in addition to the normal solve."
        )

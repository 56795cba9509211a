"""Partial slip under a tangential force."""

from math import inf
from typing import Annotated, ClassVar

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.domain.units import Newtons, NewtonsPerMetre, Pascals
from contactstudy.domain.validation import FINITE, BodyIndex, validated
from contactstudy.elasticity.tangential import shear_response
from contactstudy.scene.friction.friction_law import (
    FrictionCoefficient,
    bulk_compliance,
    check_force,
    check_similar,
    check_static,
    check_tangential_response,
    force_per_length,
    has_proportional_compliances,
    mean_over_grid,
    shearable,
)
from contactstudy.scene.loads.resulting_load import Approach
from contactstudy.scene.solids.bodies import SceneContext, is_layered
from contactstudy.solvers.friction.bulk_stress import BulkStress
from contactstudy.solvers.friction.laws import CiavarellaJaeger, PartialSlipShear


@validated
class PartialSlip:
    """Partial slip under a tangential force that friction holds back.

    The bodies are pressed first, then loaded tangentially, and never unloaded. Traction is found by Ciavarella and
    Jaeger's superposition where that is exact: under a load on half-spaces without adhesion or a hardness, where the
    gap does not vary along an exactly periodic length, or Poisson's ratio is 0. Else both components of traction are
    solved for.

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

    def solver(
        self, scene: SceneContext, gap: Array, grid: Grid, paddings: Paddings, datum: float
    ) -> CiavarellaJaeger | PartialSlipShear:
        """Return superposition where it is exact for this gap, else the problem of two components."""
        force = force_per_length(self, scene)
        assert force is not None
        if not self.bulk_stress and self.superposes(
            scene, varies=bool((gap != gap[:, :1]).any()), paddings=paddings
        ):
            return CiavarellaJaeger(
                self.coefficient, force / (self.coefficient * scene.largest_load)
            )
        response = shear_response(shearable(scene.solids), grid, paddings, datum)
        mean = mean_over_grid(force, scene, grid, paddings)
        bulk = None
        if self.bulk_stress:
            compliance = bulk_compliance(scene, self.bulk_body, "PartialSlip.bulk_stress", paddings)
            bulk = BulkStress(self.bulk_stress, self.bulk_body, compliance)
        return PartialSlipShear(self.coefficient, mean, response, bulk)

    def explanation(self, scene: SceneContext, *, varies: bool, paddings: Paddings) -> str:
        """Return a sentence on the solves: two normal contacts where they are exact, else two components of traction."""
        if not self.bulk_stress and self.superposes(scene, varies=varies, paddings=paddings):
            is_plane = not varies and paddings[1].window is None
            return (
                "friction: partial slip by Ciavarella and Jaeger's superposition, two solves, which is exact as "
                + ("nothing varies along the length." if is_plane else "Poisson's ratio is 0.")
            )
        return (
            "friction: partial slip for both components of traction, since "
            + (
                "a bulk stress stretches a body;"
                if self.bulk_stress
                else "a hardness limits the pressure;"
                if scene.hardness != inf
                else "adhesion adds to the pressure;"
                if scene.adhesion is not None
                else "an approach is given in place of a load;"
                if isinstance(scene.load, Approach)
                else "the tangential compliance of a coating differs from its normal one;"
                if any(map(is_layered, scene.solids))
                else "something varies along the length, or is not periodic along it, and Poisson's ratio is not 0;"
            )
            + " 20 to 60 applications of four transforms each, in addition to the normal solve."
        )

    @staticmethod
    def superposes(scene: SceneContext, *, varies: bool, paddings: Paddings) -> bool:
        """Return whether two normal contacts make up the traction exactly."""
        # a pressure that is capped or attracted is no difference of two contacts, and the second needs a load
        is_elastic = scene.hardness == inf and scene.adhesion is None
        is_loaded = not isinstance(scene.load, Approach)
        return (
            is_elastic
            and is_loaded
            and has_proportional_compliances(scene.solids, varies=varies, paddings=paddings)
        )

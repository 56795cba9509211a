"""Elastic-plastic half-space."""

import math
from collections.abc import Mapping
from typing import Annotated

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.units import Pascals
from contactstudy.domain.validation import AT_LEAST_ZERO, OR_INFINITE, validated
from contactstudy.elasticity.coefficients import Coefficients
from contactstudy.scene.solids.bodies import HalfSpace, PoissonRatio, SceneContext


@validated
class ElasticPlasticHalfSpace:
    """Half-space that yields by the criterion of von Mises, with linear hardening.

    A scene with one has a history: see :func:`~contactstudy.solve`.

    Parameters
    ----------
    youngs_modulus
        Young's modulus [Pa], above zero and finite.
    poisson_ratio
        Poisson's ratio, above -1 and up to 0.5.
    yield_stress
        Yield stress in tension [Pa], above zero; infinite for an elastic half-space.
    hardening_modulus
        Stress over plastic strain in tension [Pa], at least zero, by which the yield surface grows
        (isotropic hardening).
    kinematic_modulus
        The same [Pa] for a yield surface that moves (Prager's rule). With both moduli at zero the body is
        perfectly plastic.

    Raises
    ------
    InvalidInput
        If a number is outside these limits; in a scene with a hardness, steady rolling, or outputs beside passes.
    """

    youngs_modulus: Pascals
    poisson_ratio: PoissonRatio
    yield_stress: Annotated[Pascals, OR_INFINITE]
    hardening_modulus: Annotated[Pascals, AT_LEAST_ZERO] = 0.0
    kinematic_modulus: Annotated[Pascals, AT_LEAST_ZERO] = 0.0

    @property
    def instantaneous(self) -> HalfSpace:
        """Elastic half-space that responds like this one until it yields."""
        return HalfSpace(self.youngs_modulus, self.poisson_ratio)

    @property
    def compliance(self) -> float:
        """Compliance before yielding, (1 - nu^2) / E [1/Pa]."""
        return self.instantaneous.compliance

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Return Boussinesq's coefficients, valid before yielding, with their weight [1/Pa]."""
        return self.instantaneous.response(datum)

    @property
    def yields(self) -> bool:
        """True if some finite load makes the body yield."""
        return self.yield_stress < math.inf

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for an effect that is not supported together with plastic strain."""
        if not self.yields:
            return
        if scene.hardness < math.inf:
            raise InvalidInput(
                f"Scene.hardness is {scene.hardness!r} together with a body that yields, which limits the pressure "
                "by itself: leave the hardness out, or give an elastic HalfSpace."
            )
        if scene.rolling is not None and scene.rolling.passes is None:
            raise InvalidInput(
                f"Scene.rolling is {scene.rolling!r}, which is steady, together with a body that yields, whose strain "
                "has a history: give Rolling its passes, or leave rolling out."
            )
        if scene.rolling is not None and scene.outputs:
            raise InvalidInput(
                f"Scene.outputs are {scene.outputs!r} together with passes over a body that yields, whose residual "
                "stress is in the answer: leave them out."
            )

"""A half-space with a coating."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.domain.checks import (
    InvalidInput,
    check_fields,
    in_range,
    instance,
    suggest_fields,
)
from contactstudy.domain.units import Metres
from contactstudy.elasticity.coating import CoatingCoefficients
from contactstudy.elasticity.coefficients import BoussinesqCoefficients, Coefficients
from contactstudy.elasticity.kernels.layer.response import LayerResponse
from contactstudy.scene.solids.bodies import HalfSpace

if TYPE_CHECKING:
    from contactstudy.elasticity.tangential import ShearCompliance
    from contactstudy.scene.solids.stress_model import StressModel

# Up to this ratio of shear moduli the coefficients are verified.
LARGEST_RATIO = 1e4
# Wave number, times the half-width of a contact, of a wave of pressure under which the compliance is about the same.
EQUIVALENT_WAVE_NUMBER = 1.2


@suggest_fields
@dataclass(frozen=True)
class CoatedHalfSpace:
    """Layer of one material, bonded to a half-space of another; their interface neither slips nor opens.

    Parameters
    ----------
    coating, substrate
        Materials of the layer and of the half-space below it.
    thickness
        Thickness of the coating [m], above zero.

    Raises
    ------
    InvalidInput
        If the coating is rigid or more than 1e4 times as stiff as its substrate, or the thickness is not above zero.
    """

    coating: HalfSpace
    thickness: Metres
    substrate: HalfSpace

    def __post_init__(self) -> None:
        for name in ("coating", "substrate"):
            field = f"CoatedHalfSpace.{name}"
            solid = getattr(self, name)
            instance(field, solid, HalfSpace, "give a HalfSpace")
            if solid.free_faces < math.inf:
                raise InvalidInput(
                    f"{field} is {solid!r}: free faces of a coated body are not computed, leave free_faces out, or the "
                    "coating."
                )
        remedy = "give a thickness above 0 m, or the substrate alone for none"
        check_fields(self, thickness=(in_range, remedy))
        if math.isinf(self.coating.youngs_modulus):
            raise InvalidInput(
                "CoatedHalfSpace.coating is rigid: give it a finite Young's modulus, or a rigid HalfSpace as the body."
            )
        if (ratio := self._layer.shear_ratio) > LARGEST_RATIO:
            raise InvalidInput(
                f"CoatedHalfSpace.coating is {ratio:.3g} times as stiff as the substrate: give a ratio of "
                f"shear moduli up to {LARGEST_RATIO:g}."
            )

    @property
    def compliance(self) -> float:
        """Compliance of the coating alone [1/Pa], which holds in contacts far narrower than the coating is thick."""
        return self.coating.compliance

    def compliance_at(self, half_width: float) -> float:
        """Return the approximate contribution [1/Pa] to 1/E* in a contact of `half_width` [m].

        It lies between that of the coating, far below the thickness, and that of the substrate, far above. The width
        of a line contact follows from it within a tenth for moduli a factor of 3 apart, within a quarter for 8.
        """
        if self.coating == self.substrate:
            return self.compliance
        k = EQUIVALENT_WAVE_NUMBER * self.thickness / half_width
        remainder = float(np.real(self._layer.remainder(np.array([k])))[0])
        ratio = 1 + self._layer.contrast * math.exp(-2 * k) + remainder
        # that of a thin incompressible coating on a rigid substrate is lost in rounding
        return self.compliance * max(ratio, np.finfo(np.float64).eps)

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Return the coefficients of a half-space of the coating's material, and the change by the substrate."""
        alone = self.coating.response(datum)
        if self.coating == self.substrate:
            return alone
        weight = alone[BoussinesqCoefficients(datum)]
        return {**alone, CoatingCoefficients(self._layer, self.thickness, datum): weight}

    def shear_compliance(self, datum: float) -> "ShearCompliance":
        """Return the displacement under traction of a half-space of the coating, and the change by the substrate."""
        # imported only where there is friction
        from contactstudy.elasticity.coating import CoatingShearCoefficients

        alone = self.coating.shear_compliance(datum)
        if self.coating == self.substrate:
            return alone
        along = self.coating.compliance / math.pi
        normal = along / (2 * (1 - self.coating.poisson_ratio))
        return {
            name: {
                **of_coating,
                CoatingShearCoefficients(self._layer, self.thickness, name, datum): (
                    normal if name in ("x", "y") else along
                ),
            }
            for name, of_coating in alone.items()
        }

    @property
    def stress_model(self) -> "StressModel":
        """The stress in the coating and in the substrate."""
        # imported only for scenes with stress
        from contactstudy.scene.solids.coated_stress import CoatedStress
        from contactstudy.scene.solids.stress_model import HalfSpaceStress

        if self.coating == self.substrate:
            return HalfSpaceStress(self.coating.poisson_ratio)
        return CoatedStress(self._layer, self.thickness)

    @property
    def _layer(self) -> LayerResponse:
        """Response of the layer to a wave, by the ratio of the shear moduli and Poisson's ratios."""
        coating, substrate = (
            solid.youngs_modulus / (2 * (1 + solid.poisson_ratio))
            for solid in (self.coating, self.substrate)
        )
        ratios = self.coating.poisson_ratio, self.substrate.poisson_ratio
        return LayerResponse(coating / substrate, *ratios)

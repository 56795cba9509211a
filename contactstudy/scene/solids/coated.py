"""A half-space with a coating and layers between them, and the stress in it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.domain.validation import InvalidInput, Metres, validated
from contactstudy.elasticity.coating import CoatingCoefficients
from contactstudy.elasticity.convolution import BoussinesqCoefficients, Coefficients
from contactstudy.elasticity.kernels.layer_response import FAMILIES, DisplacementWaves, LayerResponse, StressWaves
from contactstudy.elasticity.kernels.layer_waves import WaveCoefficients
from contactstudy.scene.solids.bodies import HalfSpace
from contactstudy.scene.solids.stress_model import StressCoefficients

if TYPE_CHECKING:
    from contactstudy.elasticity.tangential import ShearCompliance
    from contactstudy.scene.solids.stress_model import StressModel

# Smaller weights are rounding.
LEAST_WEIGHT = 1e-14
# The lower side of an interface, over its depth.
BELOW = 1 + 1e-12


@dataclass(frozen=True)
class CoatedStress:
    """Layers on a half-space, as a body that is under stress.

    It begins with a half-space of the material at a depth, below the layers above it. Each interface below changes the
    stress from that on a half-space of one material to that on a half-space of the next: at the depth mirrored in the
    interface, by the stress under the strain in the one less that in the other, and by a remainder that decays within
    the depth of the interface. At the depth of an interface the stress is that of the layer above it.

    Parameters
    ----------
    responses
        For each interface the materials above it and that below.
    depths
        Depths of the interfaces [m].
    """

    responses: tuple[LayerResponse, ...]
    depths: tuple[float, ...]

    @property
    def interface_depths(self) -> tuple[float, ...]:
        """Depths [m] just above and just below each interface, where stress jumps."""
        return tuple(side for depth in self.depths for side in (depth, depth * BELOW))

    def coefficients(self, traction: str, component: str, depth: float) -> tuple[tuple[Coefficients, float], ...]:
        """Return coefficients with their weights of a stress `component` at a `depth` [m] under a surface `traction`."""
        # the interface above the depth, whose lower material that is; the first one for a depth in the outer layer
        above = max(sum(face < depth for face in self.depths) - 1, 0)
        terms: dict[Coefficients, float] = {}

        def half_space(name: str, depth: float, ratio: float, weight: float) -> None:
            coefficients = StressCoefficients(FAMILIES[traction][name], depth, ratio)
            terms[coefficients] = terms.get(coefficients, 0.0) + weight

        for interface in range(above, len(self.depths)):
            thickness = self.depths[interface]
            waves = StressWaves(self.responses[interface], depth / thickness, traction)
            terms[WaveCoefficients(waves, thickness, component)] = 1.0
            if interface == above:
                half_space(component, depth, waves.poisson_ratio, 1.0)
            if waves.in_layer and component in ("xx", "yy", "xy"):
                image = thickness * waves.decay_rate
                for sign, below in ((1, waves.materials), (-1, waves.materials.above)):
                    shear_ratio, here, ratio_below = waves.ratios(below)
                    for name, weight in _strained(component, shear_ratio, here, ratio_below).items():
                        half_space(name, image, ratio_below, sign * weight)
        return tuple(item for item in terms.items() if abs(item[1]) > LEAST_WEIGHT)


def _strained(name: str, ratio: float, nu1: float, nu2: float) -> dict[str, float]:
    """Return the stress `name` under the strain of a half-space, as weights of the stresses in that.

    The `ratio` of the shear moduli is that over the half-space's, nu1 and nu2 are Poisson's ratios here and there.
    """
    if name == "xy":
        return {"xy": ratio}
    a, b = nu2 / (1 + nu2), nu1 / (1 - nu1)
    both = b * (1 - 2 * a) - a
    transverse = "yy" if name == "xx" else "xx"
    return {name: ratio * (1 + both), transverse: ratio * both, "zz": b - ratio * a * (1 + 2 * b)}


# Up to this ratio of shear moduli the coefficients are verified.
LARGEST_RATIO = 1e4
# Wave number, times the half-width of a contact, of a wave of pressure under which the compliance is about the same.
EQUIVALENT_WAVE_NUMBER = 1.2


@validated
class CoatedHalfSpace:
    """Layers of several materials, bonded to a half-space; their interfaces neither slip nor open.

    Parameters
    ----------
    coating, substrate
        Materials of the layer at the surface and of the half-space at the bottom.
    thickness
        Thickness of the coating [m], above zero.
    interlayers
        Layers between coating and substrate, from above: a :class:`HalfSpace` each, with its ``thickness`` [m].

    Raises
    ------
    InvalidInput
        If a layer is rigid, has no thickness above zero, or one material is more than 1e4 times as stiff as another
        below it.
    """

    coating: HalfSpace
    thickness: Metres
    substrate: HalfSpace
    interlayers: tuple[HalfSpace, ...] = ()

    def check_together(self) -> None:
        """Check that every layer has a thickness and a stiffness that the coefficients are verified for."""
        names = "coating", *(f"interlayers[{number}]" for number in range(len(self.interlayers))), "substrate"
        solids, softest = (self.coating, *self.interlayers, self.substrate), math.inf
        for name, solid in reversed(list(zip(names, solids, strict=True))):
            field, shear = f"CoatedHalfSpace.{name}", _shear_modulus(solid)
            if solid.free_faces < math.inf or solid.hardness_profile is not None:
                raise InvalidInput(
                    f"{field} is {solid!r}: free_faces and a hardness_profile are those of an uncoated body, leave them "
                    "out, and give a yield_stress."
                )
            if name in names[1:-1] and math.isinf(solid.thickness):
                raise InvalidInput(f"{field} is {solid!r}, without a thickness: give it one [m].")
            if name != "substrate" and math.isinf(shear):
                raise InvalidInput(
                    f"{field} is rigid: give it a finite Young's modulus, or a rigid HalfSpace as the body."
                )
            softest = min(softest, shear)
            if name != "substrate" and (ratio := shear / softest) > LARGEST_RATIO:
                raise InvalidInput(
                    f"{field} is {ratio:.3g} times as stiff as what is below: give a ratio of shear moduli up to "
                    f"{LARGEST_RATIO:g}."
                )

    @property
    def layers(self) -> tuple[HalfSpace, ...]:
        """The coating and the layers between it and the substrate, each with its thickness."""
        return replace(self.coating, thickness=self.thickness), *self.interlayers

    @property
    def parts(self) -> dict[str, tuple[str, HalfSpace, float, float]]:
        """Words, material, and depths from and to [m] of each layer and the substrate, by the names of numbers."""
        names = [f"interlayer_{number}" for number in range(len(self.interlayers))]
        parts: dict[str, tuple[str, HalfSpace, float, float]] = {}
        depth = 0.0
        for name, layer in zip(("coating", *names), self.layers, strict=True):
            said = f"interlayers[{name[11:]}]" if name in names else "the coating"
            parts[name] = said, layer, depth, (depth := depth + layer.thickness)
        return parts | {"substrate": ("the substrate", self.substrate, depth, math.inf)}

    @property
    def compliance(self) -> float:
        """Compliance of the coating alone [1/Pa], which holds in contacts far narrower than the coating is thick."""
        return self.coating.compliance

    def compliance_at(self, half_width: float) -> float:
        """Return the approximate contribution [1/Pa] to 1/E* in a contact of `half_width` [m].

        It lies between that of the coating, far below the thickness, and that of the substrate, far above. The width
        of a line contact follows from it within a tenth for moduli a factor of 3 apart, within a quarter for 8.
        """
        if not self.interfaces:
            return self.compliance
        response, depth = self.interfaces[-1]
        k = np.array([EQUIVALENT_WAVE_NUMBER * depth / half_width])
        ratio = float(np.real(response.compliances(k))[0, 0])
        # that of a thin incompressible coating on a rigid substrate is lost in rounding
        return self.compliance * max(ratio, np.finfo(np.float64).eps)

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Return the coefficients of a half-space of the coating's material, and the change by each material below."""
        alone = self.coating.response(datum)
        weight = alone[BoussinesqCoefficients(datum)]
        return {**alone, **dict.fromkeys(self._changes("pressure", "z", datum), weight)}

    def shear_compliance(self, datum: float) -> "ShearCompliance":
        """Return the displacement under traction of a half-space of the coating, and the change by each one below."""
        along = self.coating.compliance / math.pi
        normal = along / (2 * (1 - self.coating.poisson_ratio))
        return {
            name: {
                **of_coating,
                **dict.fromkeys(self._changes("traction", name, datum), normal if name in ("x", "y") else along),
            }
            for name, of_coating in self.coating.shear_compliance(datum).items()
        }

    def _changes(self, load: str, name: str, datum: float) -> list[Coefficients]:
        """Return the coefficients of the displacement `name` by each material below the coating, under a `load`."""
        return [
            CoatingCoefficients(DisplacementWaves(response, load), depth, name, datum)
            for response, depth in self.interfaces
        ]

    @property
    def stress_model(self) -> "StressModel":
        """The stress in the layers and in the substrate."""
        # imported only for scenes with stress
        from contactstudy.scene.solids.stress_model import HalfSpaceStress

        if not self.interfaces:
            return HalfSpaceStress(self.coating.poisson_ratio)
        responses, depths = zip(*self.interfaces, strict=True)
        return CoatedStress(responses, depths)

    @cached_property
    def interfaces(self) -> tuple[tuple[LayerResponse, float], ...]:
        """The materials above and just below each interface between unlike ones, and its depth [m]."""
        materials, depths, depth = [replace(self.coating, thickness=math.inf)], [], 0.0
        for layer, below in pairwise((*self.layers, self.substrate)):
            depth += layer.thickness
            if (material := replace(below, thickness=math.inf)) != materials[-1]:
                materials.append(material)
                depths.append(depth)
        ratios = [_shear_modulus(self.coating) / _shear_modulus(material) for material in materials[1:]]
        poisson_ratios = [material.poisson_ratio for material in materials]
        return tuple(
            (
                LayerResponse(
                    tuple(ratios[:number]),
                    tuple(poisson_ratios[: number + 1]),
                    tuple(above / depth for above in depths[:number]),
                ),
                depth,
            )
            for number, depth in enumerate(depths, 1)
        )


def _shear_modulus(solid: HalfSpace) -> float:
    """Return the shear modulus [Pa] of a material."""
    return solid.youngs_modulus / (2 * (1 + solid.poisson_ratio))

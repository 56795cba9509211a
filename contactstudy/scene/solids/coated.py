"""A half-space with a coating, and interlayers between both, and the stress in it.

An interface is where two unlike materials meet. A layered body responds as a half-space of the coating's material, and
each interface adds the change by the material below it, whose coefficients are sums over waves.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.domain.validation import InvalidInput, Metres, validated
from contactstudy.elasticity.coating import CoatingCoefficients
from contactstudy.elasticity.convolution import BoussinesqCoefficients, Coefficients
from contactstudy.elasticity.kernels.layer_response import DisplacementWaves, LayerResponse, StressWaves
from contactstudy.elasticity.kernels.layer_waves import WaveCoefficients
from contactstudy.elasticity.kernels.stress import FAMILIES, HalfSpaceStress, StressCoefficients
from contactstudy.scene.solids.bodies import HalfSpace

if TYPE_CHECKING:
    from contactstudy.elasticity.tangential import ShearCompliance

# Least weight of influence coefficients, beside others of about 1: smaller ones are rounding.
LEAST_WEIGHT = 1e-14
# Depth of the lower side of an interface over that of the interface: stress jumps there, and the interface itself
# belongs to the layer above it.
BELOW = 1 + 1e-12


@dataclass(frozen=True)
class CoatedStress:
    """Stress in layers on a half-space, under a load on one cell of the surface.

    The stress at a depth is a sum. It begins with that in a half-space of the material at this depth, and the change
    from it by the layers above, which the waves of the interface next above are. Each interface below the depth adds the
    change by the material below it: from the layers above the interface on a half-space of the upper material, to the
    same layers on one of the lower material. This change is a closed form, and a remainder that decays within the depth
    of the interface. The closed form is taken at the depth mirrored in the interface. It is the stress of the material
    at the depth under the strain of a half-space of the material below, less that under the strain of a half-space of
    the material above.

    Parameters
    ----------
    responses
        For each interface, from the surface down, the materials above it and the one below.
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
        """Return coefficients with their weights of a stress `component` at a `depth` [m], tension positive.

        The `traction` is "pressure", or tangential traction "across" or "along"; the `component` is xx, yy, zz, yz, xz
        or xy.
        """
        # the interface next above the depth, which gives the material there; the first one for a depth in the coating
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
                image = thickness * waves.decay_rate  # the depth mirrored in the interface
                for sign, below in ((1, waves.materials), (-1, waves.materials.above)):
                    shear_ratio, here, ratio_below = waves.ratios(below)
                    for name, weight in _strained(component, shear_ratio, here, ratio_below).items():
                        half_space(name, image, ratio_below, sign * weight)
        return tuple(item for item in terms.items() if abs(item[1]) > LEAST_WEIGHT)


def _strained(name: str, ratio: float, nu1: float, nu2: float) -> dict[str, float]:
    """Return the stress `name` (xx, yy or xy) in a material under the lateral strain and the zz of a half-space.

    It is a sum of stresses in the half-space, returned as weights by their names, by Hooke's law in both materials. The
    `ratio` is the shear modulus of the material over that of the half-space, `nu1` Poisson's ratio of the material and
    `nu2` that of the half-space.
    """
    if name == "xy":
        return {"xy": ratio}
    # strain is (stress - a (xx + yy + zz)) / 2 G, and stress 2 G (strain + b of the strains xx + yy) + b zz
    a, b = nu2 / (1 + nu2), nu1 / (1 - nu1)
    both = b * (1 - 2 * a) - a
    transverse = "yy" if name == "xx" else "xx"
    return {name: ratio * (1 + both), transverse: ratio * both, "zz": b - ratio * a * (1 + 2 * b)}


# Largest ratio of the shear moduli of a material and of one below it, up to which the coefficients are verified.
LARGEST_RATIO = 1e4
# Wave number, times the half-width of a contact, of a wave of pressure under which a layered body has about the
# compliance that it has in the contact: chosen on line contacts of coatings, as accurate as `compliance_at` states.
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
        """Name, material, top and bottom [m] of each layer and the substrate, by the prefix of its quantities."""
        names = {"coating": "the coating"}
        names |= {f"interlayer_{number}": f"interlayers[{number}]" for number in range(len(self.interlayers))}
        parts: dict[str, tuple[str, HalfSpace, float, float]] = {}
        depth = 0.0
        for (name, words), layer in zip(names.items(), self.layers, strict=True):
            parts[name] = words, layer, depth, (depth := depth + layer.thickness)
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
        ratio = float(np.real(response.compliances(k))[0, 0])  # along the normal by pressure, over the coating's
        # the ratio of a thin incompressible coating on a rigid substrate is lost in rounding
        return self.compliance * max(ratio, np.finfo(np.float64).eps)

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Return the coefficients [m] of a half-space of the coating's material, and of the change by each interface.

        Each has its weight [1/Pa]; `datum` [m] as of :meth:`HalfSpace.response`.
        """
        alone = self.coating.response(datum)
        weight = alone[BoussinesqCoefficients(datum)]
        return {**alone, **dict.fromkeys(self._changes("pressure", "z", datum), weight)}

    def shear_compliance(self, datum: float) -> "ShearCompliance":
        """Return the compliance under traction of a half-space of the coating, and the change by each interface."""
        # weights (1 - nu^2) / (pi E) of displacement along the surface, 1 / (4 pi G) along the normal
        along = self.coating.compliance / math.pi
        normal = along / (2 * (1 - self.coating.poisson_ratio))
        total = {name: dict(weights) for name, weights in self.coating.shear_compliance(datum).items()}
        for name, weights in total.items():
            changes = self._changes("traction", name, datum)
            weights |= dict.fromkeys(changes, normal if name in ("x", "y") else along)
        return total

    def _changes(self, load: str, name: str, datum: float) -> list[Coefficients]:
        """Return the coefficients of the change of a displacement by each interface.

        The `load` is "pressure" or "traction"; the displacement `name` is "z" under pressure, and a key of
        ``ShearCompliance`` under traction.
        """
        return [
            CoatingCoefficients(DisplacementWaves(response, load), depth, name, datum)
            for response, depth in self.interfaces
        ]

    @property
    def stress_model(self) -> HalfSpaceStress | CoatedStress:
        """The stress in the layers and in the substrate."""
        if not self.interfaces:
            return HalfSpaceStress(self.coating.poisson_ratio)
        responses, depths = zip(*self.interfaces, strict=True)
        return CoatedStress(responses, depths)

    @cached_property
    def interfaces(self) -> tuple[tuple[LayerResponse, float], ...]:
        """Materials above and below each interface, by the coating's shear modulus over theirs, and its depth [m]."""
        materials, depths = [replace(self.coating, thickness=math.inf)], []
        for _, part, top, _ in self.parts.values():
            if (material := replace(part, thickness=math.inf)) != materials[-1]:
                materials.append(material)
                depths.append(top)
        ratios = [_shear_modulus(self.coating) / _shear_modulus(material) for material in materials[1:]]
        poisson_ratios = tuple(material.poisson_ratio for material in materials)
        interfaces = []
        for number, depth in enumerate(depths, 1):
            depths_over_this = tuple(above / depth for above in depths[:number])
            response = LayerResponse(tuple(ratios[:number]), poisson_ratios[: number + 1], depths_over_this)
            interfaces.append((response, depth))
        return tuple(interfaces)


def _shear_modulus(solid: HalfSpace) -> float:
    """Return the shear modulus [Pa] of a material."""
    return solid.youngs_modulus / (2 * (1 + solid.poisson_ratio))

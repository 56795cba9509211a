"""Stress in layers and in their substrate, as coefficients of cells under pressure and tangential traction."""

from dataclasses import dataclass

from contactstudy.elasticity.coefficients import Coefficients
from contactstudy.elasticity.kernels.layer.response import LayerResponse
from contactstudy.elasticity.kernels.layer.stress import LayerStress
from contactstudy.elasticity.kernels.layer.stress_waves import FAMILIES, StressWaves
from contactstudy.elasticity.kernels.layer.wave_coefficients import WaveCoefficients
from contactstudy.scene.solids.stress_model import StressCoefficients

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
    def faces(self) -> tuple[float, ...]:
        """Depths [m] on either side of each interface, where stress jumps."""
        return tuple(face for depth in self.depths for face in (depth, depth * BELOW))

    def coefficients(self, traction: str, component: str, depth: float) -> tuple[tuple[Coefficients, float], ...]:
        """Return coefficients with their weights of a stress `component` at a `depth` [m] under a surface `traction`."""
        # the interface above the depth, whose lower material that is; the first one for a depth in the outer layer
        above = max(sum(face < depth for face in self.depths) - 1, 0)
        found: dict[Coefficients, float] = {}

        def half_space(name: str, depth: float, ratio: float, weight: float) -> None:
            coefficients = StressCoefficients(FAMILIES[traction][name], depth, ratio)
            found[coefficients] = found.get(coefficients, 0.0) + weight

        for interface in range(above, len(self.depths)):
            thickness = self.depths[interface]
            stress = LayerStress(self.responses[interface], depth / thickness)
            waves = StressWaves(stress, traction)
            found[WaveCoefficients(waves, thickness, component)] = 1.0
            if interface == above:
                half_space(component, depth, stress.poisson_ratio, 1.0)
            if stress.in_layer and component in ("xx", "yy", "xy"):
                image = thickness * stress.decay_rate
                for sign, below in ((1, stress.materials), (-1, stress.materials.above)):
                    shear_ratio, here, ratio_below = stress.ratios(below)
                    for name, weight in _strained(component, shear_ratio, here, ratio_below).items():
                        half_space(name, image, ratio_below, sign * weight)
        return tuple(item for item in found.items() if abs(item[1]) > LEAST_WEIGHT)


def _strained(name: str, ratio: float, nu1: float, nu2: float) -> dict[str, float]:
    """Return the stress `name` under the strain of a half-space, as weights of the stresses in that.

    The `ratio` of the shear moduli is that over the half-space's, nu1 and nu2 are Poisson's ratios here and there.
    """
    if name == "xy":
        return {"xy": ratio}
    a, b = nu2 / (1 + nu2), nu1 / (1 - nu1)
    both = b * (1 - 2 * a) - a
    transverse = "yy" if name == "xx" else "xx"
    return {
        name: ratio * (1 + both),
        transverse: ratio * both,
        "zz": b - ratio * a * (1 + 2 * b),
    }

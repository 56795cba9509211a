"""Stress in a coating and in its substrate, as coefficients of cells under pressure and tangential traction."""

from dataclasses import dataclass

from contactstudy.elasticity.coefficients import Coefficients
from contactstudy.elasticity.kernels.layer.response import LayerResponse
from contactstudy.elasticity.kernels.layer.stress import LayerStress
from contactstudy.elasticity.kernels.layer.stress_waves import FAMILIES, StressWaves
from contactstudy.elasticity.kernels.layer.wave_coefficients import WaveCoefficients
from contactstudy.scene.solids.stress_model import StressCoefficients

# The substrate's side of the interface, over the thickness.
BELOW = 1 + 1e-12


@dataclass(frozen=True)
class CoatedStress:
    """Layer of one material on a half-space of another, as a body that is under stress.

    The stress in the layer is the sum of that in a half-space of its material; at the depth mirrored in the interface,
    of the layer's stress under the strain in a half-space of the substrate, less that in a half-space of the layer; and
    of a remainder that decays within the thickness. Below the interface it is that in a half-space of the substrate and
    a remainder. At the depth of the interface it is that of the layer; only a larger depth is in the substrate.

    Parameters
    ----------
    materials
        Ratio of the moduli and Poisson's ratios.
    thickness
        Thickness of the layer [m].
    """

    materials: LayerResponse
    thickness: float

    @property
    def faces(self) -> tuple[float, ...]:
        """Depths [m] on either side of the interface, where stress jumps."""
        return self.thickness, self.thickness * BELOW

    def coefficients(
        self, traction: str, component: str, depth: float
    ) -> tuple[tuple[Coefficients, float], ...]:
        """Return coefficients with their weights of a stress `component` at a `depth` [m] under a surface `traction`."""
        stress = LayerStress(self.materials, depth / self.thickness)
        remainder = WaveCoefficients(StressWaves(stress, traction), self.thickness, component)
        layer = self.materials
        nu1, nu2 = layer.coating_poisson_ratio, layer.substrate_poisson_ratio

        def half_space(name: str, depth: float, ratio: float) -> StressCoefficients:
            return StressCoefficients(FAMILIES[traction][name], depth, ratio)

        if not stress.in_layer:
            return (half_space(component, depth, nu2), 1.0), (remainder, 1.0)
        direct = (half_space(component, depth, nu1), 1.0), (remainder, 1.0)
        weights = self._strained(component)
        if not weights:  # what does not depend on the material
            return direct
        image = self.thickness * stress.decay_rate
        return (
            *direct,
            (half_space(component, image, nu1), -1.0),
            *((half_space(field, image, nu2), weight) for field, weight in weights.items()),
        )

    def _strained(self, name: str) -> dict[str, float]:
        """Return the layer's stress `name` under the substrate's strain, as weights of the substrate's stresses."""
        layer = self.materials
        ratio = layer.shear_ratio
        nu1, nu2 = layer.coating_poisson_ratio, layer.substrate_poisson_ratio
        if name == "xy":
            return {"xy": ratio}
        if name not in ("xx", "yy"):
            return {}
        a, b = nu2 / (1 + nu2), nu1 / (1 - nu1)
        both = b * (1 - 2 * a) - a
        transverse = "yy" if name == "xx" else "xx"
        return {
            name: ratio * (1 + both),
            transverse: ratio * both,
            "zz": b - ratio * a * (1 + 2 * b),
        }

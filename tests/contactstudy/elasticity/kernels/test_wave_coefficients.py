import numpy as np
import pytest

from contactstudy.elasticity.kernels.layer.displacement_waves import DisplacementWaves, Subtracted
from contactstudy.elasticity.kernels.layer.stress import LayerStress
from contactstudy.elasticity.kernels.layer.stress_waves import StressWaves
from contactstudy.elasticity.kernels.layer.wave_coefficients import WaveCoefficients, WaveResponse
from tests.contactstudy.elasticity.kernels.layer_materials import LAYERS


@pytest.mark.parametrize(
    ("waves", "name"),
    [
        (StressWaves(LayerStress(LAYERS["stiff"], 0.5), "across"), "xy"),
        (StressWaves(LayerStress(LAYERS["very soft"], 1.5), "pressure"), "xx"),
        (DisplacementWaves(LAYERS["stiff"], Subtracted.NONE, "traction"), "x"),
        (DisplacementWaves(LAYERS["two on a rigid base"], Subtracted.NONE, "pressure"), "z"),
    ],
)
def test_a_long_cell_on_a_thin_layer_is_the_sum_of_its_parts(
    waves: WaveResponse, name: str
) -> None:
    coefficients, (nx, ny), (width, period) = WaveCoefficients(waves, 0.1, name), (30, 6), (30, 18)
    parts = 5, 15

    def response(m: int, n: int) -> np.ndarray:
        dx, dy = width / (m * nx), period / (n * ny)
        x, y = dx * np.arange(m * nx), dy * np.arange(n * ny)
        return coefficients.lattice(x[:, None], y, dx, dy, width, period)

    fine, summed = response(*parts), np.zeros((nx, ny))
    for i in range(-(parts[0] // 2), parts[0] // 2 + 1):
        for j in range(-(parts[1] // 2), parts[1] // 2 + 1):
            summed += np.roll(fine, (i, j), (0, 1))[:: parts[0], :: parts[1]]
    np.testing.assert_allclose(response(1, 1), summed, atol=1e-12 * np.abs(summed).max())

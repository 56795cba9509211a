import numpy as np
import pytest

from contactstudy.elasticity.coating import CoatingCoefficients
from contactstudy.elasticity.kernels.layer_cell_alone import WaveResponse
from contactstudy.elasticity.kernels.layer_response import LayerStress
from contactstudy.elasticity.kernels.layer_waves import DisplacementWaves, StressWaves, Subtracted, WaveCoefficients
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
def test_a_long_cell_on_a_thin_layer_is_the_sum_of_its_parts(waves: WaveResponse, name: str) -> None:
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


# the far field of far stiffer layers begins beyond so many images
@pytest.mark.parametrize("name", ["stiff", "very soft", "rubber on a rigid base", "alike"])
@pytest.mark.parametrize(
    ("thickness", "period", "images"),
    [(0.06, 1.0, 2000), (0.4, 1.0, 2000), (1.7, 1.0, 2000), (0.4, 60.0, 400)],
)
def test_a_row_is_the_sum_of_its_images(name: str, thickness: float, period: float, images: int) -> None:
    """Those far away are felt as lines: what is left of them falls as the square of their number, but for a constant."""
    coating = CoatingCoefficients(LAYERS[name], thickness, "z", 1.0)
    dx, dy = 0.3, 0.25
    x, y = np.array([[0.0], [0.3], [2.7]]), np.array([0.0, 0.25, 0.5])
    away = (y[:, None] + period * np.arange(-images, images + 1)).ravel()
    cells = coating.cell(x, away, dx, dy).reshape(3, 3, -1)
    half = images // 2
    few, many = cells[:, :, half:-half].sum(axis=2), cells.sum(axis=2)
    # half a step beyond the last image
    ratio = ((images + 0.5) / (half + 0.5)) ** 2
    summed, row = (ratio * many - few) / (ratio - 1), coating.row(x, y, dx, dy, period)
    np.testing.assert_allclose(row - row[0, 0], summed - summed[0, 0], atol=1e-11 * np.abs(cells).max() * images**0.5)


@pytest.mark.parametrize("name", LAYERS)
def test_a_row_of_cells_many_periods_wide_is_the_sum_of_its_parts(name: str) -> None:
    coating, width = CoatingCoefficients(LAYERS[name], 0.2, "z", 1.0), 15.0
    x, y = np.array([[0.0], [1.0]]) * width, 0.125 * np.arange(5)
    whole = coating.row(x, y, width, 0.125, 1.0)
    parts = (x + width * np.array([-1.0, 0.0, 1.0]) / 3).reshape(-1, 1)
    summed = coating.row(parts, y, width / 3, 0.125, 1.0).reshape(2, 3, 5).sum(axis=1)
    np.testing.assert_allclose(whole, summed, atol=1e-12 * np.abs(whole).max())

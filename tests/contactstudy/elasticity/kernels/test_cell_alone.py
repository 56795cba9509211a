import numpy as np
import pytest
from scipy.special import j0, j1

from contactstudy.elasticity.kernels.displacement_cell import mean_gauss_rule
from contactstudy.elasticity.kernels.layer_cell_alone import WaveResponse, cell_alone
from contactstudy.elasticity.kernels.layer_response import LayerStress, composite
from contactstudy.elasticity.kernels.layer_waves import DisplacementWaves, StressWaves, Subtracted
from tests.contactstudy.elasticity.kernels.layer_materials import LAYERS

CELLS = (0.0, 0.0, 0.8, 1.3), (0.4, -1.95, 0.8, 1.3), (50.0, -30.0, 2.0, 3.0)


def by_quadrature(waves: WaveResponse, cell: tuple[float, float, float, float]) -> dict[str, float]:
    """Over the cell, and over the numbers and the directions of all waves; all lengths in thicknesses."""
    x, y, dx, dy = cell
    nodes, weights = np.array(mean_gauss_rule(12)).T
    last = 42 / waves.decay_rate
    ends = 1e-6 * 2.0 ** np.arange(17)
    k, weight = composite(np.concatenate([[0.0], ends[ends < last], np.arange(0.2, last, 0.2)]))
    points = 1j * (y + dy / 2 * nodes) + (x + dx / 2 * nodes)[:, None]
    # s along x: a field turns m times as the point goes about the load
    s, turn = np.abs(points).ravel(), (points / np.abs(points)).ravel()
    phase = np.multiply.outer(s, k)
    bessel = [j0(phase), j1(phase)]
    for m in (1, 2):
        bessel.append(2 * m / phase * bessel[m] - bessel[m - 1])
    found = {}
    for name, parts in waves.harmonics(k).items():
        field = np.zeros(s.size)
        for m, part in parts.items():
            radial = bessel[m] @ np.real(part * 1j**m * k * weight)
            field += radial * ((turn**m).real if waves.parity(name)[1] > 0 else (turn**m).imag)
        over_cell = weights @ field.reshape(points.shape) @ weights
        found[name] = float(over_cell * dx * dy / (2 * np.pi))
    return found


def responses(name: str) -> list[WaveResponse]:
    layers = LAYERS[name]
    return [
        *(DisplacementWaves(layers, Subtracted.NONE, load) for load in ("pressure", "traction")),
        *(
            StressWaves(LayerStress(layers, depth), load)
            for depth, load in (
                (0.0, "pressure"),
                (0.6, "across"),
                (1.5, "along"),
                (40.0, "across"),
            )
        ),
    ]


@pytest.mark.parametrize("name", LAYERS)
def test_a_cell_is_the_integral_over_it_and_over_all_waves(name: str) -> None:
    for waves in responses(name):
        own = max(abs(value) for value in by_quadrature(waves, CELLS[0]).values())
        for cell in CELLS:
            x, y, dx, dy = cell
            for field, wanted in by_quadrature(waves, cell).items():
                found = cell_alone(waves, field, np.array(x), np.array(y), dx, dy)
                assert abs(float(found) - wanted) <= 1e-11 * own


@pytest.mark.parametrize("name", LAYERS)
@pytest.mark.parametrize("size", [(200.0, 3e3), (0.3, 900.0)])
def test_cells_add_up(name: str, size: tuple[float, float]) -> None:
    # at edges and corners too, where fields along one axis are largest
    (dx, dy), middles, waves = size, np.array([0.0, 0.5, 1.0]), responses(name)[3]
    for field in waves.harmonics(np.ones(1)):
        whole = cell_alone(waves, field, dx * middles[:, None], dy * middles, dx, dy)
        parts = np.zeros((3, 3))
        for left in (-0.25, 0.25):
            for below in (-0.25, 0.25):
                x, y = dx * middles[:, None] + dx * left, dy * middles + dy * below
                parts += cell_alone(waves, field, x, y, dx / 2, dy / 2)
        np.testing.assert_allclose(parts, whole, atol=1e-12 * np.abs(whole).max())

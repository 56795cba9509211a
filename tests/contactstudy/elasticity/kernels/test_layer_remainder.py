import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.special import j0, j1

from contactstudy.elasticity.coating import CoatingCoefficients
from contactstudy.elasticity.kernels.layer.remainder import remainder_cell
from contactstudy.elasticity.kernels.layer.response import LayerResponse
from tests.contactstudy.elasticity.kernels.layer_materials import LAYERS


def panels(ends: np.ndarray, points: int) -> tuple[np.ndarray, np.ndarray]:
    nodes, weights = leggauss(points)
    middle, half = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
    return (middle[:, None] + half[:, None] * nodes).ravel(), (half[:, None] * weights).ravel()


def by_quadrature(
    layer: LayerResponse, x: float, y: float, dx: float, dy: float
) -> dict[str, float]:
    """Over the cell and over all waves, in thicknesses, by what each wave has along and across the distance."""
    k, weight = panels(
        np.concatenate([[0.0], np.geomspace(1e-6, 0.25, 30), np.arange(0.5, 20.1, 0.25)]), 12
    )
    pressed, along, coupling, across = np.real(layer.remainders(k)) * weight
    across = across / (1 - layer.poisson_ratios[0])
    u, weights_x = panels(np.linspace(x - dx / 2, x + dx / 2, 3), 16)
    v, weights_y = panels(np.linspace(y - dy / 2, y + dy / 2, 3), 16)
    r = np.hypot(u[:, None], v)
    kr, c, s = np.multiply.outer(r, k), u[:, None] / r, v / r
    zeroth, first = j0(kr), j1(kr)
    mean, turning = zeroth @ (along + across) / 2, (2 * first / kr - zeroth) @ (along - across) / 2
    fields = {
        "z": zeroth @ pressed,
        "x": c * (first @ coupling),
        "y": s * (first @ coupling),
        "xx": mean - (c * c - s * s) * turning,
        "yy": mean + (c * c - s * s) * turning,
        "xy": -2 * c * s * turning,
    }
    return {name: float(weights_x @ field @ weights_y) for name, field in fields.items()}


@pytest.mark.parametrize("name", LAYERS)
def test_a_cell_is_the_integral_over_it_and_over_all_waves(name: str) -> None:
    layer, h = LAYERS[name], 2.5e-6
    own = by_quadrature(layer, 0.4, 0.5, 0.8, 1.3)
    for x, y, dx, dy in (
        (0.0, 0.0, 0.8, 1.3),
        (0.4, -1.95, 0.8, 1.3),
        (-7.2, 0.0, 0.6, 2.4),
        (3.0, 21.0, 3.0, 1.0),
    ):
        for field, wanted in by_quadrature(layer, x, y, dx, dy).items():
            found = remainder_cell(
                layer, field, h, np.array(x * h), np.array(y * h), dx * h, dy * h
            )
            # of the quadrature, whose rounding is that of the largest value
            assert abs(float(found) / h - wanted) <= 1e-11 * max(abs(own[field]), abs(own["xx"]))


@pytest.mark.parametrize("name", LAYERS)
@pytest.mark.parametrize("size", [(2e3, 3e3), (40.0, 1e4), (0.3, 900.0)])
@pytest.mark.parametrize("field", ["z", "x", "xx", "xy"])
def test_cells_add_up(name: str, size: tuple[float, float], field: str) -> None:
    # at edges and corners too, where fields along one axis are largest
    layer, (dx, dy), middles = LAYERS[name], size, np.array([0.0, 0.5, 1.0])
    whole = remainder_cell(layer, field, 1.0, dx * middles[:, None], dy * middles, dx, dy)
    parts = np.zeros((3, 3))
    for left in (-0.25, 0.25):
        for below in (-0.25, 0.25):
            x, y = dx * middles[:, None] + dx * left, dy * middles + dy * below
            parts += remainder_cell(layer, field, 1.0, x, y, dx / 2, dy / 2)
    np.testing.assert_allclose(parts, whole, atol=1e-12 * np.abs(whole).max())


# the far field of far stiffer layers begins beyond so many images
@pytest.mark.parametrize("name", ["stiff", "very soft", "rubber on a rigid base", "alike"])
@pytest.mark.parametrize("thickness", [0.06, 0.4, 1.7])
def test_a_row_is_the_sum_of_its_images(name: str, thickness: float) -> None:
    """Those far away are felt as lines: what is left of them falls as the square of their number, but for a constant."""
    coating = CoatingCoefficients(LAYERS[name], thickness, "z", 1.0)
    dx, dy, period, images = 0.3, 0.25, 1.0, 2000
    x, y = np.array([[0.0], [0.3], [2.7]]), np.array([0.0, 0.25, 0.5])
    away = (y[:, None] + period * np.arange(-images, images + 1)).ravel()
    cells = coating.cell(x, away, dx, dy).reshape(3, 3, -1)
    half = images // 2
    few, many = cells[:, :, half:-half].sum(axis=2), cells.sum(axis=2)
    # half a step beyond the last image
    ratio = ((images + 0.5) / (half + 0.5)) ** 2
    summed, row = (ratio * many - few) / (ratio - 1), coating.row(x, y, dx, dy, period)
    np.testing.assert_allclose(
        row - row[0, 0], summed - summed[0, 0], atol=1e-11 * np.abs(cells).max() * images**0.5
    )


@pytest.mark.parametrize("name", LAYERS)
def test_a_row_of_cells_many_periods_wide_is_the_sum_of_its_parts(name: str) -> None:
    coating, width = CoatingCoefficients(LAYERS[name], 0.2, "z", 1.0), 15.0
    x, y = np.array([[0.0], [1.0]]) * width, 0.125 * np.arange(5)
    whole = coating.row(x, y, width, 0.125, 1.0)
    parts = (x + width * np.array([-1.0, 0.0, 1.0]) / 3).reshape(-1, 1)
    summed = coating.row(parts, y, width / 3, 0.125, 1.0).reshape(2, 3, 5).sum(axis=1)
    np.testing.assert_allclose(whole, summed, atol=1e-12 * np.abs(whole).max())

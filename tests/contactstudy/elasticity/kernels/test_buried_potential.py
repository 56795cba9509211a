import numpy as np
import pytest
from mpmath import asinh, atan, mp, mpf, sqrt

from contactstudy.elasticity.kernels.displacement_cell import boussinesq_cell
from contactstudy.elasticity.kernels.displacement_periodic import boussinesq_cell_periodic
from contactstudy.elasticity.kernels.layer.buried_potential import (
    buried_cell,
    buried_lattice,
    buried_row,
)
from tests.fifty_digits import over_decades, stored


def corner(x: mpf, y: mpf, c: mpf) -> mpf:
    r = sqrt(x * x + y * y + c * c)
    lines = x * asinh(y / sqrt(x * x + c * c)) + y * asinh(x / sqrt(y * y + c * c))
    return lines - c * atan(x * y / (c * r))


@stored
def judged_buried_cell(x: float, y: float, dx: float, dy: float, depth: float) -> mpf:
    with mp.workdps(50):
        ends = [[mpf(a) + s * mpf(d) / 2 for s in (1, -1)] for a, d in ((x, dx), (y, dy))]
        signed = (
            (s * t, ends[0][i], ends[1][j])
            for i, s in enumerate((1, -1))
            for j, t in enumerate((1, -1))
        )
        return sum(sign * corner(u, v, mpf(depth)) for sign, u, v in signed)


def test_a_cell_is_its_closed_form_at_any_aspect_depth_and_distance() -> None:
    chance = np.random.default_rng(5)
    for _ in range(600):
        dx, x, y = (over_decades(chance, -3, high) for high in (3, 4, 4))
        depth = over_decades(chance, -4, 5) * chance.choice([dx, 1.0])
        x, y = x * dx * chance.choice([0, 1, 1]), y * chance.choice([0, 1, 1])
        wanted = float(judged_buried_cell(x, y, dx, 1.0, depth))
        # the error that is stated
        assert float(buried_cell(x, y, dx, 1.0, depth)) == pytest.approx(wanted, rel=1e-14)


def test_without_depth_it_is_the_loaded_cell_itself() -> None:
    x, y = np.arange(6.0)[:, None] * 0.7, np.arange(7.0) * 1.3
    loaded = boussinesq_cell(x, y, 0.7, 1.3)
    np.testing.assert_allclose(buried_cell(x, y, 0.7, 1.3, 1e-30), loaded, rtol=1e-14)
    period = 12 * 1.3
    row = boussinesq_cell_periodic(x, y, 0.7, 1.3, period)
    images = buried_row(x, y, 0.7, 1.3, period, 1e-30)
    np.testing.assert_allclose(images, row, atol=1e-13 * np.abs(row).max())


@pytest.mark.parametrize("depth", [0.02, 0.3, 4.0])
@pytest.mark.parametrize("cells", [(16, 16), (40, 3), (2, 30)])
@pytest.mark.parametrize("extent", [(1.0, 1.0), (3.0, 0.7), (0.4, 1.9)])
def test_a_lattice_is_its_fourier_sum(
    depth: float, cells: tuple[int, int], extent: tuple[float, float]
) -> None:
    (dx, dy), (width, period) = (a / n for a, n in zip(extent, cells, strict=True)), extent
    x, y = (np.array([0, 1, n // 2]) * d for n, d in zip(cells, (dx, dy), strict=True))
    waves = [
        2 * np.pi / a * np.arange(-int(6 * a / depth) - 1, int(6 * a / depth) + 2) for a in extent
    ]
    q = np.hypot(waves[0][:, None], waves[1])
    mean = q == 0
    spectrum = 2 * np.pi * np.exp(-q * depth) / np.where(mean, 1, q) * ~mean
    shapes = [np.sinc(k * d / (2 * np.pi)) for k, d in zip(waves, (dx, dy), strict=True)]
    spectrum = spectrum * shapes[0][:, None] * shapes[1] * (dx * dy / (width * period))
    wanted = (
        np.cos(np.multiply.outer(x, waves[0])) @ spectrum @ np.cos(np.multiply.outer(waves[1], y))
    )
    found = buried_lattice(x[:, None], y, dx, dy, width, period, depth)
    # of the lattice of the same cells on the surface: the rounding of its sums
    scale = dx * dy / min(extent)
    np.testing.assert_allclose(found, wanted, atol=1e-12 * max(scale, np.abs(wanted).max()))


def test_a_row_is_its_lattice_beside_far_neighbours() -> None:
    """Rows W apart are felt as lines: their logarithm is ``-ln |2 sin(pi (x + i c) / W)|^2``."""
    depth, period, width, dx, dy = 0.3, 1.0, 900.0, 0.25, 0.125
    x, y = np.arange(5)[:, None] * dx, np.arange(5) * dy
    lattice = buried_lattice(x, y, dx, dy, width, period, depth)
    row = buried_row(x, y, dx, dy, period, depth)
    lines = (
        -2 * np.log(2 * np.abs(np.sin(np.pi * (x + 1j * depth) / width)))
        + 2 * np.pi * depth / width
    )
    alone = -np.log(x**2 + depth**2)
    # the two differ by lines W away, alike over the cell to (dx / W)^2
    difference = dx * dy / period * (lines - alone)
    np.testing.assert_allclose(
        lattice - row, np.broadcast_to(difference, row.shape), atol=(dx / width) ** 2
    )

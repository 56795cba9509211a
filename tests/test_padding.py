import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactstudy as cs
from contactstudy.influence import boussinesq_cell

GRID = cs.Grid(cells=(6, 5), extent=(1.2, 0.8))
EPS = np.finfo(float).eps


def dense(grid: cs.Grid, images: range) -> np.ndarray:
    """The paper's eq. (5) word for word: all pairs of cells, all images."""
    x, y = (a.ravel() for a in np.meshgrid(grid.x, grid.y, indexing="ij"))
    offsets = x[:, None] - x, y[:, None] - y
    return sum(
        boussinesq_cell(offsets[0], offsets[1] + m * grid.period, *grid.cell) for m in images
    )


def applied(grid: cs.Grid, padding: cs.Padding) -> np.ndarray:
    """The operator as a matrix, one unit pressure at a time; E* = 1/pi, so that it is I itself."""
    operator = cs.convolution(1 / np.pi, grid, padding, datum=1.0)
    units = np.eye(grid.cells[0] * grid.cells[1]).reshape(-1, *grid.cells)
    return np.stack([operator(unit).ravel() for unit in units], axis=1)


@pytest.mark.parametrize("images", [0, 1, 4])
def test_superposition_is_equation_five(images: int) -> None:
    expected = dense(GRID, range(-images, images + 1))
    assert_allclose(applied(GRID, cs.Superposition(images)), expected, rtol=16 * EPS * (images + 1))


def test_superposition_of_no_images_is_zero_padding() -> None:
    for nx, ny in ((6, 5), (7, 1), (2, 2)):
        grid = cs.Grid(cells=(nx, ny), extent=(1.0, 1.0))
        zero = applied(grid, cs.ZeroPadding())
        assert (applied(grid, cs.Superposition(0)) == zero).all()


@pytest.mark.parametrize("cells", [(6, 5), (5, 6), (4, 1), (3, 2)])
def test_folded_duplication_is_the_literal_copy(cells: tuple[int, int]) -> None:
    """Figure 2 of the paper: zeros behind the width, a copy of the pressure behind the length."""
    grid = cs.Grid(cells=cells, extent=(1.2, 0.8))
    (nx, ny), (dx, dy) = cells, grid.cell
    pressure = np.random.default_rng(5).random(cells)
    copied = np.zeros((2 * nx, 2 * ny))
    copied[:nx, :ny] = copied[:nx, ny:] = pressure
    around = np.fft.fftfreq(2 * nx, 1 / (2 * nx)) * dx, np.fft.fftfreq(2 * ny, 1 / (2 * ny)) * dy
    coefficients = boussinesq_cell(around[0][:, None], around[1][None], dx, dy)
    moved = np.fft.ifft2(np.fft.fft2(copied) * np.fft.fft2(coefficients)).real[:nx, :ny]
    operator = cs.convolution(1 / np.pi, grid, cs.DuplicatedPadding(), datum=1.0)
    assert_allclose(operator(pressure), moved, rtol=32 * EPS)


def test_exact_periodicity_is_what_superposition_tends_to() -> None:
    """Truncation leaves terms of (x^2, y^2) / D^2 after the rigid shift ln(2 n + 1) L."""
    exact = applied(GRID, cs.ExactPeriodicity())
    area = GRID.cell_area
    for images in (10, 100):
        reach = (2 * images + 1) * GRID.period
        shifted = applied(GRID, cs.Superposition(images)) - 2 * area / GRID.period * np.log(reach)
        bound = 2 * area / GRID.period * 1.2**2 / (reach / 2) ** 2
        assert np.abs(shifted - exact).max() < bound


def test_exact_periodicity_counts_displacement_from_its_datum() -> None:
    """Moving the datum by a factor e moves everything by twice the line load over pi E*."""
    one = cs.convolution(1 / np.pi, GRID, cs.ExactPeriodicity(), datum=1.0)
    far = cs.convolution(1 / np.pi, GRID, cs.ExactPeriodicity(), datum=np.e)
    pressure = np.ones(GRID.cells)
    assert_allclose(far(pressure) - one(pressure), 2 * GRID.extent[0], rtol=1e-13)


@pytest.mark.parametrize(
    ("padding", "reach"),
    [
        (cs.ZeroPadding(), 0.5),
        (cs.DuplicatedPadding(), 1.0),
        (cs.Superposition(6), 6.5),
        (cs.ExactPeriodicity(), np.inf),
    ],
)
def test_reach_is_counted_in_periods(padding: cs.Padding, reach: float) -> None:
    assert padding.reach(3.0) == 3 * reach


@pytest.mark.parametrize("images", [-1, 1.5, True, None, "6"])
def test_images_are_a_whole_number_from_zero_on(images: object) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Superposition\.images is .*from 0 on\.$"):
        cs.Superposition(images=images)  # type: ignore[arg-type]

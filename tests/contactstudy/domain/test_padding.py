from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactstudy as cs
from contactstudy.elasticity.kernels.displacement_cell import boussinesq_cell


@dataclass(frozen=True)
class Images:
    """The periods seen, counted from the domain's own or from the one nearest to the field point."""

    window: range
    of_point: bool = False

    def offset(self, offset: np.ndarray, period: float) -> np.ndarray:
        return offset - period * np.round(offset / period) if self.of_point else offset


NONE = Images(range(1))
GRID = cs.Grid(cells=(6, 5), extent=(1.2, 0.8))
EPS = np.finfo(float).eps


def rounding_error(field: np.ndarray) -> float:
    """What a transform pair may be off by: a rounding of the largest at each of its steps, of which there
    are some log2 of the cells there and back, and as many again for the sum over images.
    """
    return 4 * EPS * np.log2(4 * field.size) * float(np.abs(field).max())


def dense(grid: cs.Grid, along: Images, across: Images = NONE) -> np.ndarray:
    """All pairs of cells, all images: with a range along, the paper's eq. (5) word for word."""
    cells = np.stack(np.meshgrid(grid.x, grid.y, indexing="ij"), axis=-1).reshape(-1, 2)
    x, y = np.moveaxis(cells[:, None] - cells, -1, 0)
    width, period = grid.extent
    x, y = across.offset(x, width), along.offset(y, period)
    return sum(
        boussinesq_cell(x + k * width, y + m * period, *grid.cell_size) for k in across.window for m in along.window
    )


def applied(grid: cs.Grid, padding: cs.Padding | cs.Paddings) -> np.ndarray:
    """The operator as a matrix, one unit pressure at a time; E* = 1/pi, so that it is I itself."""
    operator = cs.convolution(1 / np.pi, grid, padding, datum=1.0)
    units = np.eye(grid.cells[0] * grid.cells[1]).reshape(-1, *grid.cells)
    return np.stack([operator(unit).ravel() for unit in units], axis=1)


def around(images: int, *, of_point: bool = False) -> Images:
    return Images(range(-images, images + 1), of_point)


@pytest.mark.cases(3)
@pytest.mark.parametrize(
    ("padding", "along", "across"),
    [
        *((cs.Superposition(n), around(n), NONE) for n in (0, 1, 4)),
        *((cs.CircularSuperposition(n), around(n, of_point=True), NONE) for n in (0, 1, 4)),
        (
            (cs.CircularSuperposition(1), cs.Superposition(2)),
            around(2),
            around(1, of_point=True),
        ),
    ],
    ids=str,
)
def test_superposition_is_equation_five_counted_from_the_domain_or_from_the_observer(
    padding: cs.Padding | cs.Paddings, along: Images, across: Images
) -> None:
    expected = dense(GRID, along, across)
    assert_allclose(applied(GRID, padding), expected, rtol=0, atol=rounding_error(expected))


@pytest.mark.parametrize("images", [4, 10])
def test_only_a_circular_sum_leaves_a_uniform_pressure_uniform(images: int) -> None:
    pressure = np.ones(GRID.cells)
    moved = cs.convolution(1.0, GRID, cs.CircularSuperposition(images), datum=1.0)(pressure)
    assert np.ptp(moved, axis=1).max() < rounding_error(moved)
    moved = cs.convolution(1.0, GRID, cs.Superposition(images), datum=1.0)(pressure)
    # a window off centre by y lacks ln(1 - y^2 / D^2) of the line load's potential
    off_centre = 0.4 / (images + 0.5)
    lacking = -GRID.extent[0] / np.pi * np.log(1 - off_centre**2)
    assert np.ptp(moved, axis=1).max() == pytest.approx(lacking, rel=0.1)


@pytest.mark.parametrize("cells", [(6, 5), (5, 6), (4, 1), (3, 2)])
def test_folded_duplication_is_the_literal_copy(cells: tuple[int, int]) -> None:
    """Figure 2 of the paper: zeros behind the width, a copy of the pressure behind the length."""
    grid = cs.Grid(cells=cells, extent=(1.2, 0.8))
    (nx, ny), (dx, dy) = cells, grid.cell_size
    pressure = np.random.default_rng(5).random(cells)
    copied = np.zeros((2 * nx, 2 * ny))
    copied[:nx, :ny] = copied[:nx, ny:] = pressure
    around = np.fft.fftfreq(2 * nx, 1 / (2 * nx)) * dx, np.fft.fftfreq(2 * ny, 1 / (2 * ny)) * dy
    coefficients = boussinesq_cell(around[0][:, None], around[1][None], dx, dy)
    moved = np.fft.ifft2(np.fft.fft2(copied) * np.fft.fft2(coefficients)).real[:nx, :ny]
    operator = cs.convolution(1 / np.pi, grid, cs.DuplicatedPadding(), datum=1.0)
    assert_allclose(operator(pressure), moved, rtol=0, atol=rounding_error(moved))


@pytest.mark.parametrize("kind", [cs.Superposition, cs.CircularSuperposition])
def test_exact_periodicity_is_what_superposition_tends_to(
    kind: type[cs.Superposition] | type[cs.CircularSuperposition],
) -> None:
    """Truncation leaves terms of (x^2, y^2) / D^2 after the rigid shift ln(2 n + 1) L."""
    exact = applied(GRID, cs.ExactPeriodicity())
    logarithm = 2 * GRID.cell_area / GRID.length
    for images in (10, 100, 1000, 10_000):
        reach = (2 * images + 1) * GRID.length
        shifted = applied(GRID, kind(images)) - logarithm * np.log(reach)
        # of the last images the sums of the coefficients lose no digits
        bound = logarithm * GRID.extent[0] ** 2 / (reach / 2) ** 2 + 1e-13
        assert np.abs(shifted - exact).max() < bound

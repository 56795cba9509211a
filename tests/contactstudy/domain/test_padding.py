from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactstudy as cs
from contactstudy.analytic import image_error
from contactstudy.elasticity.kernels.displacement import boussinesq_cell
from tests.conftest import LineContact


@dataclass(frozen=True)
class Images:
    """The periods seen, counted from the domain's own or from the one nearest to the field point."""

    count: int = 0
    of_point: bool = False

    @property
    def window(self) -> range:
        return range(-self.count, self.count + 1)

    def offset(self, offset: np.ndarray, period: float) -> np.ndarray:
        return offset - period * np.round(offset / period) if self.of_point else offset


GRID = cs.Grid(cells=(6, 5), extent=(1.2, 0.8))
EPS = np.finfo(float).eps


def rounding_error(field: np.ndarray) -> float:
    """What a transform pair may be off by: a rounding of the largest at each of its steps, of which there
    are some log2 of the cells there and back, and as many again for the sum over images.
    """
    return 4 * EPS * np.log2(4 * field.size) * float(np.abs(field).max())


def dense(grid: cs.Grid, along: Images, across: Images) -> np.ndarray:
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


def test_superposition_is_equation_five_counted_from_the_domain_or_from_the_observer() -> None:
    cases: tuple[tuple[cs.Padding | cs.Paddings, Images, Images], ...] = (
        (cs.Superposition(0), Images(), Images()),
        (cs.Superposition(4), Images(4), Images()),
        (cs.CircularSuperposition(4), Images(4, of_point=True), Images()),
        ((cs.CircularSuperposition(1), cs.Superposition(2)), Images(2), Images(1, of_point=True)),
    )
    for padding, along, across in cases:
        expected = dense(GRID, along, across)
        assert_allclose(applied(GRID, padding), expected, rtol=0, atol=rounding_error(expected))


def test_only_a_circular_sum_leaves_a_uniform_pressure_uniform() -> None:
    pressure, images = np.ones(GRID.cells), 10
    moved = cs.convolution(1.0, GRID, cs.CircularSuperposition(images), datum=1.0)(pressure)
    assert np.ptp(moved, axis=1).max() < rounding_error(moved)
    moved = cs.convolution(1.0, GRID, cs.Superposition(images), datum=1.0)(pressure)
    # a window off centre by y lacks ln(1 - y^2 / D^2) of the line load's potential
    lacking = -GRID.extent[0] / np.pi * np.log(1 - (0.4 / (images + 0.5)) ** 2)
    assert np.ptp(moved, axis=1).max() == pytest.approx(lacking, rel=0.1)


def test_folded_duplication_is_the_literal_copy() -> None:
    """Figure 2 of the paper: zeros behind the width, a copy of the pressure behind the length."""
    (nx, ny), (dx, dy) = GRID.cells, GRID.cell_size
    pressure = np.random.default_rng(5).random(GRID.cells)
    copied = np.zeros((2 * nx, 2 * ny))
    copied[:nx, :ny] = copied[:nx, ny:] = pressure
    around = np.fft.fftfreq(2 * nx, 1 / (2 * nx)) * dx, np.fft.fftfreq(2 * ny, 1 / (2 * ny)) * dy
    coefficients = boussinesq_cell(around[0][:, None], around[1][None], dx, dy)
    moved = np.fft.ifft2(np.fft.fft2(copied) * np.fft.fft2(coefficients)).real[:nx, :ny]
    operator = cs.convolution(1 / np.pi, GRID, cs.DuplicatedPadding(), datum=1.0)
    assert_allclose(operator(pressure), moved, rtol=0, atol=rounding_error(moved))


@pytest.mark.parametrize("kind", [cs.Superposition, cs.CircularSuperposition])
def test_exact_periodicity_is_what_superposition_tends_to(
    kind: type[cs.Superposition] | type[cs.CircularSuperposition],
) -> None:
    """Truncation leaves terms of (x^2, y^2) / D^2 after the rigid shift ln(2 n + 1) L."""
    exact = applied(GRID, cs.ExactPeriodicity())
    logarithm = 2 * GRID.cell_area / GRID.length
    for images in (10, 10_000):
        reach = (2 * images + 1) * GRID.length
        shifted = applied(GRID, kind(images)) - logarithm * np.log(reach)
        # of the last images the sums of the coefficients lose no digits
        assert np.abs(shifted - exact).max() < logarithm * GRID.extent[0] ** 2 / (reach / 2) ** 2 + 1e-13


def errors(contact: LineContact, padding: cs.Padding, cells: tuple[int, int], period: float) -> tuple[float, ...]:
    """Signed peak error, largest error, variation along the length, L1 error."""
    grid = contact.grid(cells, period)
    solution = cs.solve(contact.scene.problem(grid, padding), tolerance=1e-10)
    pressure = solution.pressure / contact.hertz.peak_pressure
    error = np.abs(pressure - contact.hertz.pressure(grid.x)[:, None] / contact.hertz.peak_pressure)
    near = np.argsort(np.abs(grid.x), kind="stable")[:2]
    fraction = grid.cell_size[0] / (np.pi / 2 * contact.hertz.half_width)
    peak, varying = pressure[near].mean() - 1, np.ptp(pressure, axis=1).max()
    return float(peak), float(error.max()), float(varying), float(error.sum(axis=0).mean() * fraction)


def test_paddings_cost_what_was_published(line_contact: LineContact) -> None:
    """To half a unit in the last digit of the figures; exact periodicity leaves only the grid and the tolerance."""
    for padding, published in (
        (cs.ExactPeriodicity(), ((0.0, 1e-5), (0.0, 9e-3), (0.0, 1e-10))),
        (cs.DuplicatedPadding(), ((1.92e-2, 5e-5), (0.167, 5e-4), (0.0, 1e-10))),
        (cs.Superposition(images=6), ((5.0e-4, 5e-6), (0.016, 5e-4), (0.017, 5e-4))),
        (cs.ZeroPadding(), ((0.138, 5e-4), (5.27, 5e-3), (5.40, 5e-3))),
    ):
        found = errors(line_contact, padding, (128, 128), 2.4)
        for value, (expected, half_unit) in zip(found[:3], published, strict=True):
            assert value == pytest.approx(expected, abs=half_unit)


def test_peak_error_follows_the_square_of_the_reach(line_contact: LineContact) -> None:
    """Within 10 % from a reach of 3 a on, the grid's own error taken off."""
    for padding, period in (
        (cs.DuplicatedPadding(), 3.0),
        (cs.Superposition(images=1), 2.4),
        (cs.CircularSuperposition(10_000), 1e-3),
    ):
        truncated, *_ = errors(line_contact, padding, (96, 48), period)
        whole, *_ = errors(line_contact, cs.ExactPeriodicity(), (96, 1), period)
        assert truncated - whole == pytest.approx(image_error(1.0, padding.reach(period)), rel=0.1)


def test_cell_centres_are_symmetric_to_the_last_bit() -> None:
    grid = cs.Grid(cells=(7, 10), extent=(0.3, 0.7))
    assert (grid.x == -grid.x[::-1]).all()
    assert (grid.y == -grid.y[::-1]).all()
    assert_allclose(np.diff(grid.y), 0.07, rtol=1e-14)
    assert_allclose(grid.x[-1] + grid.cell_size[0] / 2, 0.15, rtol=1e-15)


def test_cells_may_be_a_billion_times_as_long_as_wide_or_a_million_times_as_wide() -> None:
    for extent, beyond in (((2.0, 1e9), (2.0, 1.1e9)), ((2e6, 1.0), (2.2e6, 1.0))):
        assert cs.Grid(cells=(2, 1), extent=extent).extent == extent
        with pytest.raises(cs.InvalidInput, match=r"^Grid\.extent is .* times as"):
            cs.Grid(cells=(2, 1), extent=beyond)

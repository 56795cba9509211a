"""Stress and tangential displacement by one cell, a row of cells and a lattice of them."""

import mpmath as mp
import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from numpy.testing import assert_allclose, assert_array_equal

from contactstudy.elasticity.kernels.stress import (
    BOUSSINESQ,
    CERRUTI_ACROSS,
    CERRUTI_ALONG,
    COMPONENTS,
    FAMILIES,
    SURFACE,
    CellKernel,
    StressCoefficients,
    plane_strain,
    strip,
)
from contactstudy.elasticity.tangential import CerrutiCoefficients
from tests.contactstudy.elasticity.kernels.test_displacement import over_decades

NU = 0.3
EXACT = 1e-12  # what the docstrings promise, of the largest component, up to an aspect of 10
NAMES = list(COMPONENTS)
SHEARED = {kernel.name: kernel for family in (CERRUTI_ACROSS, CERRUTI_ALONG) for kernel in family.values()}
# h -> 0 by a polynomial through sums of 200 ... 6400 images: what is left is of order h^6
IMAGES = 200 * 2 ** np.arange(6)


def six(x: float, y: float, z: float, dx: float, dy: float) -> np.ndarray:
    return np.array([float(StressCoefficients(c, z, NU).cell(x, y, dx, dy)) for c in BOUSSINESQ.values()])


def to_the_limit(sums: list[np.ndarray], steps: np.ndarray) -> np.ndarray:
    """Neville: the polynomial through all sums, at a step of zero."""
    table = list(sums)
    for level in range(1, len(table)):
        for k in range(len(table) - level):
            a, b = steps[k], steps[k + level]
            table[k] = (a * table[k + 1] - b * table[k]) / (a - b)
    return table[0]


def summed_images(component: CellKernel, x: float, z: float, dx: float, dy: float, period: float) -> np.ndarray:
    """Single cells by the hundred, extrapolated to infinitely many."""
    m = np.arange(1, IMAGES[-1] + 1)
    images = sum(StressCoefficients(component, z, NU).cell(x, Y[:, None] + s * m * period, dx, dy) for s in (1, -1))
    running = np.cumsum(images, axis=-1)
    own = StressCoefficients(component, z, NU).cell(x, Y, dx, dy)
    return own + to_the_limit([running[..., n - 1] for n in IMAGES], 1 / (IMAGES + 0.5))


def corner(name: str, x: mp.mpf, y: mp.mpf, z: mp.mpf) -> mp.mpf:
    """Love (1929): the field's integral over both coordinates, in the arctangents of his paper."""
    r, nu = mp.sqrt(x * x + y * y + z * z), mp.mpf(NU)
    if name in ("yy", "yz"):
        return corner({"yy": "xx", "yz": "xz"}[name], y, x, z)
    solid, arch = mp.atan(x * y / (z * r)), z * x * y / ((x * x + z * z) * r)
    return {
        "xx": -2 * nu * solid + arch - (1 - 2 * nu) * (mp.atan(y / x) - mp.atan(z * y / (x * r))),
        "zz": -solid - arch - z * x * y / ((y * y + z * z) * r),
        "xz": z * z * y / ((x * x + z * z) * r),
        "xy": -z / r - (1 - 2 * nu) * mp.log(r + z),
    }[name]


def judged_stress(component: float, *arguments: float) -> mp.mpf:
    """The difference of corners, which loses up to 20 of 50 digits."""
    with mp.workdps(50):
        x, y, z, dx, dy = (mp.mpf(a) for a in arguments)
        signed = (
            a * b * corner(NAMES[int(component)], x + a * dx / 2, y + b * dy / 2, z) for a in (1, -1) for b in (1, -1)
        )
        return mp.fsum(signed) / (2 * mp.pi)


def by_quadrature(kernel: CellKernel, x: float, y: float, z: float, dx: float, dy: float) -> float:
    """The integral over a cell of point loads."""
    nodes, weights = leggauss(60)
    u, v = x + dx / 2 * nodes[:, None], y + dy / 2 * nodes
    r = np.sqrt(u * u + v * v + z * z)
    return float((weights[:, None] * weights * kernel.point(u, v, z, r, NU)).sum() * dx * dy / (8 * np.pi))


def test_stress_under_a_pressed_cell_is_exact_at_any_distance_depth_and_aspect() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        x, y, z = over_decades(rng, -2, 6, 3) * np.append([1.0, 1.0], over_decades(rng, -6, 0, 1))
        [dy] = over_decades(rng, -2, 2, 1)
        expected = [float(judged_stress(n, x, y, z, 1.0, dy)) for n in range(len(NAMES))]
        assert_allclose(six(x, y, z, 1.0, dy), expected, rtol=0, atol=EXACT * np.abs(expected).max())


@pytest.mark.parametrize("name", SHEARED)
def test_stress_under_a_sheared_cell_is_the_integral_of_point_loads(name: str) -> None:
    kernel, chance = SHEARED[name], np.random.default_rng(1)
    for _ in range(8):
        x, y, z, dx, dy = chance.uniform((-2, -2, 0.5, 0.3, 0.3), 2)
        largest = max(abs(by_quadrature(other, 0.3, 0.2, z, dx, dy)) for other in SHEARED.values())
        computed = float(StressCoefficients(kernel, z, NU).cell(x, y, dx, dy))
        assert abs(computed - by_quadrature(kernel, x, y, z, dx, dy)) <= EXACT * largest


@pytest.mark.parametrize("name", SURFACE)
def test_fields_on_the_surface_are_integrals_of_point_loads(name: str) -> None:
    for x, y in ((0.9, 0.2), (0.1, 1.7), (3.0, -2.0)):
        wanted = 2 * np.pi * by_quadrature(SURFACE[name], x, y, 0.0, 0.5, 0.4)
        computed = CerrutiCoefficients(name, 1.0).cell(np.array(x), np.array(y), 0.5, 0.4)
        assert float(computed) == pytest.approx(wanted, rel=1e-12)


def test_stress_on_the_surface_is_that_of_love_with_its_parity() -> None:
    """Under the cell no shear, and for a square xx = yy = -(1 + 2 nu) / 2."""
    xx, yy, zz, yz, xz, xy = six(0.0, 0.0, 0.0, 1.0, 1.0)
    assert_allclose((xx, yy), -(1 + 2 * NU) / 2, rtol=1e-15)
    assert zz == pytest.approx(-1.0, abs=1e-15)
    assert (yz, xz, xy) == (0, 0, 0)
    beside = six(0.8, 0.2, 0.0, 1.0, 1.0)
    assert_allclose(beside[[2, 3, 4]], 0, atol=1e-16)
    assert beside[0] + beside[1] == pytest.approx(0, abs=1e-15)
    across, along = np.array([kernel.parity for kernel in BOUSSINESQ.values()]).T
    assert_array_equal(six(-7.0, 0.7, 0.4, 1.0, 0.7), across * six(7.0, 0.7, 0.4, 1.0, 0.7))
    assert_array_equal(six(7.0, -0.7, 0.4, 1.0, 0.7), along * six(7.0, 0.7, 0.4, 1.0, 0.7))


Y = np.array([0.0, 0.13, 0.41, 0.65])
ROWS = [(0.0, 0.01, 0.1, 0.1), (0.5, 0.3, 0.02, 0.1), (1.0, 2.0, 0.1, 0.1),
        (3.0, 0.3, 0.1, 0.3), (7.5, 0.5, 0.1, 0.1), (2.0, 0.1, 5.0, 0.1), (7.8, 0.3, 0.1, 0.1)]  # fmt: skip


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("row", ROWS, ids=str)
def test_row_is_the_sum_of_its_images(row: tuple[float, float, float, float], family: str) -> None:
    """Also of those six periods and more from the axis, where nothing varies along it."""
    x, z, dx, dy = row
    kernels = FAMILIES[family].values()
    expected = np.stack([summed_images(kernel, *row, 1.3) for kernel in kernels])
    computed = [StressCoefficients(kernel, z, NU).row(x, Y, dx, dy, 1.3)[0] for kernel in kernels]
    # far away images cancel that are each as large as the nearest of them
    largest = max(np.abs(expected).max(), np.abs(six(x, 0.0, z, dx, dy)).max())
    assert_allclose(computed, expected, rtol=0, atol=EXACT * largest)


def test_cells_of_one_period_are_a_strip_with_its_textbook_stress() -> None:
    """Johnson (1985), eqs. 2.30: by the angles to both edges."""
    x, z, a, count, period = np.array([0.0, 0.4, 1.5, -2.0]), 0.6, 0.5, 6, 1.3
    right, left = np.arctan2(z, x - a), np.arctan2(z, x + a)
    turn, waves = right - left, np.sin(2 * right) - np.sin(2 * left)
    expected = {
        "xx": -(2 * turn + waves) / (2 * np.pi),
        "zz": -(2 * turn - waves) / (2 * np.pi),
        "xz": (np.cos(2 * right) - np.cos(2 * left)) / (2 * np.pi),
        "yy": -2 * NU * turn / np.pi,
    }
    y = np.arange(count) * period / count
    for name, component in BOUSSINESQ.items():
        cells = StressCoefficients(component, z, NU).row(x, y, 2 * a, period / count, period)
        endless = plane_strain(component, strip(x, z, 2 * a), NU)
        assert_allclose(endless, expected.get(name, 0 * x), rtol=0, atol=1e-15)
        assert_allclose(cells.sum(axis=1), endless, rtol=0, atol=1e-14)
    for component in (*CERRUTI_ACROSS.values(), *CERRUTI_ALONG.values()):
        cells = StressCoefficients(component, z, NU).row(x, y, 2 * a, period / count, period)
        endless = plane_strain(component, strip(x, z, 2 * a), NU)
        assert_allclose(cells.sum(axis=1), endless, rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", NAMES)
def test_lattice_is_the_sum_of_rows_but_for_its_mean(name: str) -> None:
    """Under uniform pressure the body does not spread, ``xx = yy = -nu / (1 - nu)``, at any depth."""
    width, period, cell = 2.0, 1.3, (0.2, 0.3, 0.2)
    x, y = np.array([0.1, 0.7]), np.array([0.2, 0.6])
    computed = StressCoefficients(BOUSSINESQ[name], cell[0], NU).lattice(x, y, *cell[1:], width, period)
    strips, rows = np.array([20, 40, 80, 160, 320]), np.arange(1, 321)
    images = np.stack(
        [
            sum(
                StressCoefficients(BOUSSINESQ[name], cell[0], NU).row(x + s * m * width, y, *cell[1:], period)
                for s in (1, -1)
            )
            for m in rows.tolist()
        ]
    )
    running = np.cumsum(images, axis=0)
    own = StressCoefficients(BOUSSINESQ[name], cell[0], NU).row(x, y, *cell[1:], period)
    summed = own + to_the_limit([running[n - 1] for n in strips], 1 / (strips + 0.5))
    fraction = 0.3 * 0.2 / (width * period)
    held = {"xx": fraction * (1 - 2 * NU) / (1 - NU), "yy": NU * fraction * (1 - 2 * NU) / (1 - NU)}
    assert_allclose(computed, summed + held.get(name, 0.0), rtol=0, atol=1e-11 * 0.3 * 0.2)
    mean = {"xx": -NU / (1 - NU), "yy": -NU / (1 - NU), "zz": -1.0}.get(name, 0.0)
    deep = StressCoefficients(BOUSSINESQ[name], 1e3, NU).lattice(x, y, *cell[1:], width, period)
    assert_allclose(deep, mean * fraction, rtol=0, atol=1e-12 * fraction)


@pytest.mark.cases(1)
@pytest.mark.parametrize("family", [CERRUTI_ACROSS, CERRUTI_ALONG], ids=["across", "along"])
def test_a_sheared_lattice_is_in_equilibrium_and_turns_with_its_axes(family: dict[str, CellKernel]) -> None:
    """Below the surface the mean shear is what acts on it; all other means vanish."""
    cells, extent, depth = (2, 3), (2.0, 5.0), 0.6
    dx, dy = (a / n for a, n in zip(extent, cells, strict=True))
    x, y = np.arange(cells[0])[:, None] * dx, np.arange(cells[1]) * dy
    for name, kernel in family.items():
        lattice = StressCoefficients(kernel, depth, NU).lattice(x, y, dx, dy, *extent)
        turned = StressCoefficients(kernel.swap_axes(), depth, NU).lattice(
            y.reshape(-1, 1), x.reshape(1, -1), dy, dx, *extent[::-1]
        )
        assert_allclose(lattice, turned.T, atol=1e-12)
        carried = -1.0 if name == ("xz" if family is CERRUTI_ACROSS else "yz") else 0.0
        assert lattice.sum() == pytest.approx(carried, abs=1e-11)


@pytest.mark.parametrize("name", [*SURFACE, "yy"])
@pytest.mark.parametrize("extent", [(4.0, 3.0), (2.0, 5.0)])
def test_a_lattice_of_fields_on_the_surface_has_their_transforms(name: str, extent: tuple[float, float]) -> None:
    """Wave by wave on the grid: aliases of the cells' own waves fall like the cube of their number."""
    cells, aliases = (16, 20), 60
    dx, dy = (a / n for a, n in zip(extent, cells, strict=True))
    x, y = np.arange(cells[0])[:, None] * dx, np.arange(cells[1]) * dy
    computed = np.fft.fft2(CerrutiCoefficients(name, 1.0).lattice(x, y, dx, dy, *extent))
    for wave in ((1, 0), (0, 2), (3, 5), (2, -1)):
        i = np.arange(-aliases, aliases + 1)
        kx = 2 * np.pi / extent[0] * (wave[0] + i[:, None] * cells[0])
        ky = 2 * np.pi / extent[1] * (wave[1] + i * cells[1])
        q = np.hypot(kx, ky)
        shape = {
            "x": -1j * kx / q**2,
            "y": -1j * ky / q**2,
            "xx": (1 - (kx / q) ** 2) / q,
            "yy": (1 - (ky / q) ** 2) / q,
            "xy": -kx * ky / q**3,
        }[name]
        size = np.sinc(kx * dx / (2 * np.pi)) * np.sinc(ky * dy / (2 * np.pi))
        # sinc sinc / q, or sinc sinc, summed beyond the last alias
        assert abs(computed[wave] - (2 * np.pi * shape * size).sum()) <= 2e-4 * np.abs(computed).max()

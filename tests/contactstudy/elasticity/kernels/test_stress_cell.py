import mpmath as mp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from contactstudy.elasticity.kernels.layer_waves import FAMILIES
from contactstudy.elasticity.kernels.stress_cell import (
    COMPONENTS,
    GAUSS_ZONES,
    CellKernel,
    stress_cell,
    strip,
)
from contactstudy.elasticity.kernels.stress_periodic import (
    PLANE_STRAIN_PERIODS,
    plane_strain,
    stress_cell_doubly_periodic,
    stress_cell_periodic,
)
from tests.fifty_digits import over_decades, stored

NU = 0.3
EXACT = 1e-12  # what the docstrings promise, of the largest component, up to an aspect of 10
NAMES = list(COMPONENTS)
# h -> 0 by a polynomial through sums of 200 ... 6400 images: what is left is of order h^6
IMAGES = 200 * 2 ** np.arange(6)


def six(x: float, y: float, z: float, dx: float, dy: float) -> np.ndarray:
    return np.array([float(stress_cell(c, x, y, z, dx, dy, NU)) for c in COMPONENTS.values()])


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
    images = sum(stress_cell(component, x, Y[:, None] + s * m * period, z, dx, dy, NU) for s in (1, -1))
    running = np.cumsum(images, axis=-1)
    own = stress_cell(component, x, Y, z, dx, dy, NU)
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


@stored
def judged_stress(component: float, *arguments: float) -> mp.mpf:
    """The difference of corners, which loses up to 20 of 50 digits."""
    with mp.workdps(50):
        x, y, z, dx, dy = (mp.mpf(a) for a in arguments)
        signed = (
            a * b * corner(NAMES[int(component)], x + a * dx / 2, y + b * dy / 2, z) for a in (1, -1) for b in (1, -1)
        )
        return mp.fsum(signed) / (2 * mp.pi)


def test_coefficient_is_exact_at_any_distance_depth_and_aspect() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        x, y, z = over_decades(rng, -2, 6, 3) * (1.0, 1.0, over_decades(rng, -6, 0))
        dy = over_decades(rng, -2, 2)
        expected = [float(judged_stress(n, x, y, z, 1.0, dy)) for n in range(len(NAMES))]
        assert_allclose(six(x, y, z, 1.0, dy), expected, rtol=0, atol=EXACT * np.abs(expected).max())


@pytest.mark.parametrize("start", [start for start, _ in GAUSS_ZONES])
@pytest.mark.parametrize("aspect", [1.0, 0.01, 100.0])
def test_zones_join(start: float, aspect: float) -> None:
    rng = np.random.default_rng(1)
    for direction in rng.standard_normal((20, 3)):
        x, y, z = np.abs(direction) / np.linalg.norm(direction) * start * max(1.0, aspect)
        before, after = (six(*(np.array((x, y, z)) * (1 + side)), 1.0, aspect) for side in (-1e-15, 1e-15))
        allowed = EXACT * max(1, aspect / 10, 0.1 / aspect) * np.abs(after).max()
        assert_allclose(after, before, rtol=0, atol=allowed)


@pytest.mark.parametrize("name", NAMES)
def test_parity_is_exact(name: str) -> None:
    component = COMPONENTS[name]
    x, y = np.array([0.2, 0.9, 7.0, 60.0])[:, None], np.array([0.1, 0.7, 30.0])
    base = stress_cell(component, x, y, 0.4, 1.0, 0.7, NU)
    across, along = component.parity
    assert_array_equal(stress_cell(component, -x, y, 0.4, 1.0, 0.7, NU), across * base)
    assert_array_equal(stress_cell(component, x, -y, 0.4, 1.0, 0.7, NU), along * base)


def test_pressure_is_what_the_surface_carries() -> None:
    """Under the cell (Love 1929): no shear, and for a square xx = yy = -(1 + 2 nu) / 2."""
    xx, yy, zz, yz, xz, xy = six(0.0, 0.0, 0.0, 1.0, 1.0)
    assert_allclose((xx, yy), -(1 + 2 * NU) / 2, rtol=1e-15)
    assert zz == pytest.approx(-1.0, abs=1e-15)
    assert (yz, xz, xy) == (0, 0, 0)
    beside = six(0.8, 0.2, 0.0, 1.0, 1.0)
    assert_allclose(beside[[2, 3, 4]], 0, atol=1e-16)
    assert beside[0] + beside[1] == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize("at", [(0.3, 0.1), (0.8, 0.2), (6.0, 3.0)])
def test_surface_is_the_limit_of_small_depths(at: tuple[float, float]) -> None:
    surface = six(*at, 0.0, 1.0, 1.0)
    errors = [np.abs(six(*at, depth, 1.0, 1.0) - surface).max() for depth in (1e-4, 1e-5, 1e-6)]
    assert_allclose(np.array(errors[:-1]) / errors[1:], 10, rtol=0.01)


Y = np.array([0.0, 0.13, 0.41, 0.65])
ROWS = [
    (0.0, 0.01, 0.1, 0.1),
    (0.5, 0.3, 0.02, 0.1),
    (1.0, 2.0, 0.1, 0.1),
    (3.0, 0.3, 0.1, 0.3),
    (7.5, 0.5, 0.1, 0.1),
    (2.0, 0.1, 5.0, 0.1),
]


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("row", ROWS, ids=str)
def test_row_is_the_sum_of_its_images(row: tuple[float, float, float, float], family: str) -> None:
    x, z, dx, dy = row
    kernels = FAMILIES[family].values()
    expected = np.stack([summed_images(one, *row, 1.3) for one in kernels])
    found = [stress_cell_periodic(one, x, Y, z, dx, dy, 1.3, NU)[0] for one in kernels]
    # far away images cancel that are each as large as the nearest of them
    largest = max(np.abs(expected).max(), np.abs(six(x, 0.0, z, dx, dy)).max())
    assert_allclose(found, expected, rtol=0, atol=EXACT * largest)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("z", [0.02, 0.1])
def test_row_turns_into_plane_strain(z: float, family: str) -> None:
    x = np.sqrt((PLANE_STRAIN_PERIODS * 1.3) ** 2 - z**2) + 0.05 + np.array([-1e-13, 1e-13])
    rows = (stress_cell_periodic(one, x, Y, z, 0.1, 0.1, 1.3, NU) for one in FAMILIES[family].values())
    before, after = np.stack(list(rows), axis=1)
    largest = max(np.abs(after).max(), np.abs(six(x[0], 0.0, z, 0.1, 0.1)).max())
    assert_allclose(before, after, rtol=0, atol=EXACT * largest)


@pytest.mark.parametrize("name", NAMES)
def test_cells_of_one_period_are_a_strip(name: str) -> None:
    x, count, period = np.array([0.0, 0.3, 2.0, 9.0]), 6, 1.3
    y = np.arange(count) * period / count
    cells = stress_cell_periodic(COMPONENTS[name], x, y, 0.2, 0.3, period / count, period, NU)
    endless = plane_strain(COMPONENTS[name], strip(x, 0.2, 0.3), NU)
    assert_allclose(cells.sum(axis=1), endless, rtol=0, atol=1e-14)


def test_strip_has_its_textbook_stress() -> None:
    """Johnson (1985), eqs. 2.30: by the angles to both edges."""
    x, z, a = np.array([0.0, 0.4, 1.5, -2.0]), 0.6, 0.5
    one, two = np.arctan2(z, x - a), np.arctan2(z, x + a)
    turn, waves = one - two, np.sin(2 * one) - np.sin(2 * two)
    seen = strip(x, z, 2 * a)
    expected = {
        "xx": -(2 * turn + waves) / (2 * np.pi),
        "zz": -(2 * turn - waves) / (2 * np.pi),
        "xz": (np.cos(2 * one) - np.cos(2 * two)) / (2 * np.pi),
        "yy": -2 * NU * turn / np.pi,
        "yz": 0 * x,
        "xy": 0 * x,
    }
    for name, value in expected.items():
        assert_allclose(plane_strain(COMPONENTS[name], seen, NU), value, rtol=0, atol=1e-15)


EXTENTS = [(2.0, 1.3), (0.2, 3.0)]


@pytest.mark.cases(1)
@pytest.mark.parametrize(("width", "period"), EXTENTS)
def test_uniform_pressure_compresses_without_spreading(width: float, period: float) -> None:
    """Uniaxial strain: ``xx = yy = -nu / (1 - nu)``."""
    x, y = np.arange(2) * width / 2, np.arange(2) * period / 2
    cell = 0.2, width / 2, period / 2
    means = [stress_cell_doubly_periodic(c, x, y, *cell, width, period, NU).sum() for c in COMPONENTS.values()]
    lateral = -NU / (1 - NU)
    assert_allclose(means, [lateral, lateral, -1, 0, 0, 0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_lattice_is_the_sum_of_rows_but_for_its_mean(name: str) -> None:
    width, period, cell = 2.0, 1.3, (0.2, 0.3, 0.2)
    x, y = np.array([0.1, 0.7]), np.array([0.2, 0.6])
    found = stress_cell_doubly_periodic(COMPONENTS[name], x, y, *cell, width, period, NU)
    strips, rows = np.array([20, 40, 80, 160, 320]), np.arange(1, 321)
    images = np.stack(
        [
            sum(stress_cell_periodic(COMPONENTS[name], x + s * m * width, y, *cell, period, NU) for s in (1, -1))
            for m in rows.tolist()
        ]
    )
    running = np.cumsum(images, axis=0)
    own = stress_cell_periodic(COMPONENTS[name], x, y, *cell, period, NU)
    summed = own + to_the_limit([running[n - 1] for n in strips], 1 / (strips + 0.5))
    fraction = (1 - 2 * NU) / (1 - NU) * 0.3 * 0.2 / (width * period)
    held = {"xx": fraction, "yy": NU * fraction}.get(name, 0.0)
    assert_allclose(found, summed + held, rtol=0, atol=1e-11 * 0.3 * 0.2)


@pytest.mark.parametrize("z", [2.0, 4.0, 1e3, 1e6])
def test_deep_down_nothing_is_left_of_the_lattice_but_its_mean(z: float) -> None:
    """By the slowest harmonics, ``(1 + k z) exp(-k z)``, two of which go twice into the sum."""
    width, period = 2.0, 1.3
    found = stress_cell_doubly_periodic(COMPONENTS["zz"], np.array([0.0, 0.6]), Y, z, 0.2, 0.2, width, period, NU)
    fraction = 0.2 * 0.2 / (width * period)
    k = 2 * np.pi / width
    assert np.abs(found + fraction).max() <= 4 * fraction * (1 + k * z) * np.exp(-k * z) + 1e-12 * fraction

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

from contactstudy.elasticity.kernels.displacement_cell import boussinesq_cell
from contactstudy.elasticity.kernels.stress_cell import CellKernel, stress_cell
from contactstudy.elasticity.kernels.stress_periodic import stress_cell_doubly_periodic
from contactstudy.elasticity.kernels.traction import CERRUTI_ACROSS, CERRUTI_ALONG, SURFACE
from contactstudy.elasticity.tangential import CerrutiCoefficients

STRESSES = {one.name: one for family in (CERRUTI_ACROSS, CERRUTI_ALONG) for one in family.values()}
DX, DY, DEPTH, NU = 0.5, 0.4, 0.6, 0.3


def by_quadrature(one: CellKernel, x: float, y: float, z: float, dx: float, dy: float) -> float:
    nodes, weights = leggauss(60)
    u, v = x + dx / 2 * nodes[:, None], y + dy / 2 * nodes
    r = np.sqrt(u * u + v * v + z * z)
    return float((weights[:, None] * weights * one.point(u, v, z, r, NU)).sum() * dx * dy / (8 * np.pi))


@pytest.mark.parametrize("name", STRESSES)
def test_stress_under_a_sheared_cell_is_the_integral_of_point_loads(name: str) -> None:
    one, chance = STRESSES[name], np.random.default_rng(1)
    for _ in range(8):
        x, y, z, dx, dy = chance.uniform((-2, -2, 0.5, 0.3, 0.3), 2)
        largest = max(abs(by_quadrature(other, 0.3, 0.2, z, dx, dy)) for other in STRESSES.values())
        found = float(stress_cell(one, x, y, z, dx, dy, NU))
        # the error that is stated for the kernels
        assert abs(found - by_quadrature(one, x, y, z, dx, dy)) <= 1e-12 * largest


@pytest.mark.cases(1)
@pytest.mark.parametrize("family", [CERRUTI_ACROSS, CERRUTI_ALONG], ids=["across", "along"])
@pytest.mark.parametrize("extent", [(2.0, 5.0)])
def test_a_lattice_is_in_equilibrium_and_turns_with_its_axes(
    family: dict[str, CellKernel], extent: tuple[float, float]
) -> None:
    """Below the surface the mean shear is what acts on it; all other means vanish."""
    cells = 2, 3
    dx, dy = (a / n for a, n in zip(extent, cells, strict=True))
    x, y = np.arange(cells[0])[:, None] * dx, np.arange(cells[1]) * dy
    for name, one in family.items():
        lattice = stress_cell_doubly_periodic(one, x, y, DEPTH, dx, dy, *extent, NU)
        turned = stress_cell_doubly_periodic(
            one.swap_axes(), y.reshape(-1, 1), x.reshape(1, -1), DEPTH, dy, dx, *extent[::-1], NU
        )
        np.testing.assert_allclose(lattice, turned.T, atol=1e-12)
        carried = -1.0 if name == {"x": "xz", "y": "yz"}["x" if family is CERRUTI_ACROSS else "y"] else 0.0
        assert lattice.sum() == pytest.approx(carried, abs=1e-11)


@pytest.mark.parametrize("name", SURFACE)
def test_fields_on_the_surface_are_integrals_of_point_loads(name: str) -> None:
    one, nodes, weights = SURFACE[name], *leggauss(60)
    for x, y in ((0.9, 0.2), (0.1, 1.7), (3.0, -2.0)):
        u, v = x + DX / 2 * nodes[:, None], y + DY / 2 * nodes
        wanted = (weights[:, None] * weights * one.point(u, v, 0.0, np.hypot(u, v), NU)).sum() * DX * DY / 4
        found = CerrutiCoefficients(name, 1.0).cell(np.array(x), np.array(y), DX, DY)
        assert float(found) == pytest.approx(wanted, rel=1e-12)


def test_both_moments_add_up_to_the_loaded_cell() -> None:
    x, y = np.arange(5)[:, None] * DX, np.arange(4) * DY
    both = sum(CerrutiCoefficients(name, 2.0).cell(x, y, DX, DY) for name in ("xx", "yy"))
    np.testing.assert_allclose(both, boussinesq_cell(x, y, DX, DY), rtol=1e-13)


@pytest.mark.parametrize("name", [*SURFACE, "yy"])
@pytest.mark.parametrize("extent", [(4.0, 3.0), (2.0, 5.0)])
def test_a_lattice_of_fields_has_their_transforms(name: str, extent: tuple[float, float]) -> None:
    """Wave by wave on the grid: aliases of the cells' own waves fall like the cube of their number."""
    cells, aliases = (16, 20), 60
    dx, dy = (a / n for a, n in zip(extent, cells, strict=True))
    x, y = np.arange(cells[0])[:, None] * dx, np.arange(cells[1]) * dy
    found = np.fft.fft2(CerrutiCoefficients(name, 1.0).lattice(x, y, dx, dy, *extent))
    for wave in ((1, 0), (0, 2), (3, 5), (2, -1)):
        total = 0.0
        for i in range(-aliases, aliases + 1):
            kx = 2 * np.pi / extent[0] * (wave[0] + i * cells[0])
            ky = 2 * np.pi / extent[1] * (wave[1] + np.arange(-aliases, aliases + 1) * cells[1])
            q = np.hypot(kx, ky)
            shape = {
                "x": -1j * kx / q**2,
                "y": -1j * ky / q**2,
                "xx": (1 - (kx / q) ** 2) / q,
                "yy": (1 - (ky / q) ** 2) / q,
                "xy": -kx * ky / q**3,
            }[name]
            size = np.sinc(kx * dx / (2 * np.pi)) * np.sinc(ky * dy / (2 * np.pi))
            total += (2 * np.pi * shape * size).sum()
        # sinc sinc / q, or sinc sinc, summed beyond the last alias
        assert abs(found[wave] - total) <= 2e-4 * np.abs(found).max()

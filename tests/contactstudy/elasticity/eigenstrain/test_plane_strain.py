import numpy as np
import pytest

from contactstudy.domain.grid import Grid
from contactstudy.elasticity.eigenstrain.plane_strain_operator import OuterStrain, PlaneStrainOperator
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume
from contactstudy.elasticity.kernels.displacement_cell import mean_gauss_rule
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS, strip
from contactstudy.elasticity.kernels.stress_periodic import plane_strain

LAYERS = {"even": (0, 0.5, 1, 1.5, 2, 2.5), "graded": (0, 0.3, 0.7, 1.2, 2, 4)}


def _operator(edges: tuple[float, ...], poisson_ratio: float = 0.3) -> PlaneStrainOperator:
    grid = Grid((20, 1), (20 * 0.4, 3.0))
    return PlaneStrainOperator(Volume(grid, 4, 13, edges), Moduli(2.0, poisson_ratio))


def _energy(operator: PlaneStrainOperator) -> np.ndarray:
    """B in the inner product of volumes, as a matrix over the cells' unit strains."""
    shape = 3, *operator.volume.shape
    count = int(np.prod(shape))
    weights = np.broadcast_to(operator.volume.cell_volumes, shape).reshape(-1, 1)
    columns = [operator.negative_residual_stress(one.reshape(shape)).ravel() for one in np.eye(count)]
    return np.sqrt(weights) * np.array(columns).T / np.sqrt(weights.T)


@pytest.mark.parametrize("edges", LAYERS.values(), ids=LAYERS)
@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.5])
def test_plastic_strain_has_an_energy_that_is_symmetric_and_below_that_of_a_rigid_body(
    edges: tuple[float, ...], poisson_ratio: float
) -> None:
    operator = _operator(edges, poisson_ratio)
    energy = _energy(operator)
    twice = 2 * operator.moduli.shear
    assert np.abs(energy - energy.T).max() <= 1e-12 * twice
    values = np.linalg.eigvalsh(energy) / twice
    # an incompressible body in plane strain takes nothing off some strains: 2G is reached to rounding
    assert 1e-3 < values[0] < values[-1] < 1 + 1e-12
    if poisson_ratio < 0.5:
        assert values[-1] < 1 - 1e-4


@pytest.mark.parametrize("edges", LAYERS.values(), ids=LAYERS)
def test_the_lift_of_the_surface_does_the_work_that_pressure_does_on_plastic_strain(
    edges: tuple[float, ...],
) -> None:
    operator = _operator(edges)
    random = np.random.default_rng(2)
    pressure = random.random(operator.volume.grid.cells)
    strain = random.standard_normal((3, *operator.volume.shape))
    work = (operator.volume.cell_volumes * strain * operator.stress_of_pressure(pressure)).sum()
    lifted = (operator.residual_displacement(strain) * pressure).sum() * operator.volume.grid.cell_area
    assert lifted == pytest.approx(work, rel=1e-12)


def test_the_stress_of_pressure_is_the_mean_over_cells_of_that_at_points() -> None:
    operator = _operator(LAYERS["graded"])
    volume, (dx, _) = operator.volume, operator.volume.grid.cell_size
    pressure = np.zeros(volume.grid.cells)
    pressure[7] = 1.0
    stress = operator.stress_of_pressure(pressure)
    offsets = (np.arange(volume.first, volume.last) - 7.0) * dx
    layer = 2
    depth, thickness = volume.depths[layer], volume.thicknesses[layer]
    # 24 points: rho > 3 for points half a layer of 3 cells from the surface
    mean = sum(
        w * v * np.stack([
            plane_strain(component, strip(offsets + x * dx / 2, depth + z * thickness / 2, dx), 0.3)
            for component in COMPONENTS.values()
        ])
        for x, w in mean_gauss_rule(24)
        for z, v in mean_gauss_rule(24)
    )  # fmt: skip
    twice_shear = np.array((1, 1, 1, 2, 2, 2))
    wanted = (operator.basis * twice_shear) @ mean
    assert np.abs(stress[:, layer, :, 0] - wanted).max() < 1e-10


@pytest.mark.parametrize("radius", [4, 8])
def test_a_cylinder_of_uniform_strain_far_below_has_the_stress_of_eshelby(radius: int) -> None:
    # in cells; the surface is 60 radii away and changes it by their square
    deep, side = 60 * radius, radius + 1
    edges = (0.0, *(float(z) for z in np.arange(deep - side, deep + side + 1)))
    grid = Grid((2 * side, 1), (2.0 * side, 1.0))
    nu = 0.3
    operator = PlaneStrainOperator(Volume(grid, 0, 2 * side, edges), Moduli(1.0, nu))
    shape = operator.volume.shape
    x, z = grid.x[:, None], operator.volume.depths[1:, None, None] - deep
    inside = np.zeros(shape, dtype=bool)
    inside[1:] = x**2 + z**2 < radius**2
    strain = np.zeros((3, *shape))
    strain[2][inside] = 1.0
    taken = operator.negative_residual_stress(strain)[2][inside].mean()
    # Eshelby (1957): 2 S_1212 = (3 - 4 nu) / (4 (1 - nu)) leaves 2G / (4 (1 - nu)) of what shear would take
    exact = 2 * operator.moduli.shear / (4 * (1 - nu))
    # the outline is one of squares: of 2 pi r cells on it, half are cut
    assert taken == pytest.approx(exact, rel=0.25 / radius)


def test_half_lines_of_strain_are_the_limit_of_finite_strips() -> None:
    """What is left of the cells beyond falls as one over their distance."""
    moduli, beyond, edges = Moduli(2.0, 0.3), 2000, LAYERS["graded"]
    near, wide = (
        PlaneStrainOperator(Volume(Grid((n, 1), (0.4 * n, 3.0)), 0, n, edges), moduli) for n in (20, 20 + 2 * beyond)
    )
    left, right = np.random.default_rng(3).standard_normal((2, 3, 5))
    strain = np.zeros((3, *wide.volume.shape))
    strain[..., :beyond, 0], strain[..., -beyond:, 0] = left[..., None], right[..., None]
    outer, inside = OuterStrain(near), slice(beyond, -beyond)
    found = outer.tensor(left, right), outer.residual_displacement(left, right)
    expected = (
        wide.residual_stress_tensor(strain)[..., inside, :],
        wide.residual_displacement(strain)[inside],
    )
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, atol=0.01 * np.abs(one).max())

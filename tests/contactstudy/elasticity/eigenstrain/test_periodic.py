from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from contactstudy.domain.grid import Grid
from contactstudy.elasticity.eigenstrain.fourier_modes import Waves
from contactstudy.elasticity.eigenstrain.half_space_wave import Components
from contactstudy.elasticity.eigenstrain.periodic_operator import (
    AntiplaneOperator,
    PeriodicOperator,
)
from contactstudy.elasticity.eigenstrain.plane_strain_operator import PlaneStrainOperator
from contactstudy.elasticity.eigenstrain.volume import EigenstrainOperator, Moduli, Volume
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS
from contactstudy.elasticity.kernels.stress_periodic import stress_cell_periodic

STEEL = Moduli(2.6, 0.3)  # 2G = 2
TENSOR = ("xx", "yy", "zz", "yz", "xz", "xy")


@cache
def small() -> PeriodicOperator:
    """Graded layers from a thin one on, an odd and an even number of cells, cells longer than wide."""
    grid = Grid((9, 6), (9.0, 8.0))
    return PeriodicOperator(Volume(grid, 3, 7, (0.0, 0.05, 0.1, 1.5)), STEEL)


def noise(operator: EigenstrainOperator, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(len(operator.basis), *operator.volume.shape))


def dense(operator: PeriodicOperator) -> np.ndarray:
    """B in cells of unit volume."""
    shape = 5, *operator.volume.shape
    root = np.sqrt(np.broadcast_to(operator.volume.cell_volumes, shape)).ravel()
    units = np.eye(len(root))
    columns = [operator.negative_residual_stress(unit.reshape(shape)).ravel() for unit in units]
    return np.array(columns).T * root[:, None] / root


@pytest.mark.whole
def test_the_energy_is_symmetric_and_between_zero_and_that_of_a_body_that_cannot_give_way() -> None:
    matrix = dense(small())
    assert np.abs(matrix - matrix.T).max() < 1e-12
    values = np.linalg.eigvalsh((matrix + matrix.T) / 2)
    assert values[0] > 1e-4
    assert values[-1] < 2 * STEEL.shear * (1 - 1e-4)


def test_the_lift_is_the_transpose_of_the_stress_of_pressure() -> None:
    operator = small()
    strain, grid = noise(operator), operator.volume.grid
    pressure = np.random.default_rng(1).normal(size=grid.cells)
    work = (operator.volume.cell_volumes * strain * operator.stress_of_pressure(pressure)).sum()
    assert (operator.residual_displacement(strain) * pressure).sum() * grid.cell_area == pytest.approx(work, rel=1e-12)


def test_what_does_not_vary_along_the_length_is_plane_strain() -> None:
    operator = small()
    grid = operator.volume.grid
    alone = Volume(Grid((9, 1), grid.extent), 3, 7, operator.volume.edges)
    plane, antiplane = PlaneStrainOperator(alone, STEEL), AntiplaneOperator(alone, STEEL)
    strain = noise(plane)
    along = np.zeros((5, *operator.volume.shape))
    along[:3] = strain
    found = operator.negative_residual_stress(along)
    assert np.abs(found[:3] - plane.negative_residual_stress(strain)).max() < 1e-13
    assert np.abs(found[3:]).max() < 1e-13
    assert operator.residual_displacement(along) == pytest.approx(
        np.repeat(plane.residual_displacement(strain), 6, 1), abs=1e-13
    )
    pressure = np.random.default_rng(1).normal(size=(9, 1))
    stress = operator.stress_of_pressure(np.repeat(pressure, 6, 1))[:3]
    assert np.abs(stress - plane.stress_of_pressure(pressure)).max() < 1e-13
    shear = np.zeros((5, *operator.volume.shape))
    shear[3:] = strain[:2]
    found = operator.negative_residual_stress(shear)
    assert np.abs(found[3:, ..., 0] - antiplane(strain[:2, ..., 0])).max() < 1e-13


def test_a_pressed_cell_makes_the_stress_of_its_point_formulas() -> None:
    grid, edges = Grid((16, 8), (16.0, 12.0)), (0.0, 1.0, 2.0, 4.0)
    operator = PeriodicOperator(Volume(grid, 5, 11, edges), STEEL)
    pressure = np.zeros(grid.cells)
    pressure[7, 3] = 1
    found = operator.stress_of_pressure(pressure)
    points, weights = np.polynomial.legendre.leggauss(5)
    points, weights = points / 2, weights / 2
    x = ((grid.x[5:11] - grid.x[7])[:, None] + points).ravel()
    y = ((grid.y - grid.y[3])[:, None] + 1.5 * points).ravel()
    for layer, (top, bottom) in enumerate(pairwise(edges)):
        mean = np.zeros((6, 6, 8))
        for number, name in enumerate(TENSOR):
            for point, weight in zip(points, weights, strict=True):
                z = (top + bottom) / 2 + point * (bottom - top)
                at = stress_cell_periodic(COMPONENTS[name], x, y, z, 1.0, 1.5, 12.0, 0.3)
                cells = at.reshape(6, 5, 8, 5)
                mean[number] += weight * np.einsum("iajb,a,b->ij", cells, weights, weights)
        wanted = np.einsum("ct,txy->cxy", operator.basis * (1, 1, 1, 2, 2, 2), mean)
        # short waves: exp(-pi z / dx) of the third in the first layer, nothing of them below
        accuracy = 2e-3 if layer == 0 else 1e-6
        assert np.abs(found[:, layer] - wanted).max() < accuracy


def test_waves_add_up_to_the_closed_forms_of_an_infinite_axis() -> None:
    cells, period = 12, 1501
    volume = Volume(Grid((cells, 1), (12.0, 1e9)), 0, cells, (0.0, 0.7, 1.4, 2.1, 3.5, 4.5))
    waves = Waves.from_orders(volume, STEEL, np.array([1e-3]), period)
    x, z = volume.grid.x[:, None], volume.depths[:, None, None]
    shape = np.exp(-((x / 3) ** 2) - ((z - 2) / 1.5) ** 2)
    strain = np.array([0.3, -0.5, 0.8, 0.6, -0.4])[:, None, None, None] * shape
    found = -np.fft.ifft(waves.stress(np.fft.fft(strain, period, axis=2), Components.DEVIATOR), axis=2)
    found = found[:, :, :cells].real
    plane = PlaneStrainOperator(volume, STEEL).negative_residual_stress(strain[:3])
    shear = AntiplaneOperator(volume, STEEL)(strain[3:, ..., 0])
    # short waves between layers further apart than the next: a per mille; the period: 1 / X
    assert np.abs(found[:3] - plane).max() < 2e-3
    assert np.abs(found[3:, ..., 0] - shear).max() < 2e-3
    blocks = waves.diagonal_blocks(np.array([1 / period]))
    assert np.abs(blocks[:, :3, :3] - PlaneStrainOperator(volume, STEEL).diagonal_blocks).max() < 1e-3
    assert np.abs(blocks[:, 3:, 3:] - AntiplaneOperator(volume, STEEL).diagonal_blocks).max() < 1e-3


def test_a_deep_sphere_keeps_the_stress_of_eshelby() -> None:
    radius, middle = 4.0, 24.0
    edges = (0.0, 6.0, 12.0, 18.0, *np.arange(19.0, 30.0))
    grid = Grid((30, 32), (30.0, 32.0))
    volume = Volume(grid, 10, 20, edges)
    operator = PeriodicOperator(volume, STEEL)
    x, y = grid.x[10:20, None], grid.y
    inside = x**2 + y**2 + (volume.depths[:, None, None] - middle) ** 2 < radius**2
    inside[:3] = False
    for component in range(5):
        strain = np.zeros((5, *volume.shape))
        strain[component] = inside
        stress = operator.negative_residual_stress(strain)
        core = x**2 + y**2 + (volume.depths[:, None, None] - middle) ** 2 < (radius / 2) ** 2
        # Eshelby (1957), eq. 3.14: 1 - beta; the sphere is made of cells, images have (R / L)^3
        fraction = 1 - 2 * (4 - 5 * 0.3) / (15 * (1 - 0.3))
        found = stress[:, core].mean(axis=1) / 2
        wanted = fraction * np.eye(5)[component]
        assert np.abs(found - wanted).max() < 0.03


def test_the_surface_is_free_of_traction() -> None:
    grid = Grid((16, 16), (16.0, 16.0))
    edges = (0.0, 1e-3, 1.0, 2.0, 3.0, 4.0)
    operator = PeriodicOperator(Volume(grid, 0, 16, edges), STEEL)
    volume = operator.volume
    x, y, z = grid.x[:, None], grid.y, volume.depths[:, None, None]
    shape = np.exp(-((x**2 + y**2) + (z - 3) ** 2) / 4)
    shape[:2] = 0
    strain = np.array([0.3, -0.5, 0.8, 0.6, -0.4])[:, None, None, None] * shape
    tensor = operator.residual_stress_tensor(strain)[:, 0]
    # edges of cells a cell away, exp(-pi), are not reflected; the layer's middle is half a per mille deep
    assert np.abs(tensor[[2, 3, 4]]).max() < 2e-3 * np.abs(tensor).max()


def test_a_source_turned_by_a_right_angle_makes_the_field_turned_but_for_its_neighbours() -> None:
    difference = {}
    for cells in (12, 24):
        grid = Grid((cells, cells), (float(cells), float(cells)))
        operator = PeriodicOperator(Volume(grid, 0, cells, (0.0, 1.0, 2.0, 3.0)), STEEL)
        x, y = grid.x[:, None], grid.y
        along, across = np.exp(-(x**2) - y**2 / 2), np.exp(-(x**2) / 2 - y**2)
        # xx - zz and xz, turned into yy - zz and yz
        strain, turned = np.zeros((2, 5, *operator.volume.shape))
        strain[[0, 2], 1] = along
        turned[[0, 1, 4], 1] = np.array((0.5, 0.75**0.5, 1))[:, None, None] * across
        tensor = operator.residual_stress_tensor(strain)
        found = operator.residual_stress_tensor(turned)[[1, 0, 2, 4, 3, 5]].swapaxes(2, 3)
        middle = slice(cells // 2 - 3, cells // 2 + 3)
        difference[cells] = np.abs(found - tensor)[:, :, middle, middle].max()
    # they repeat along y alone, and act like one over their distance cubed: 8, less what is next in order
    assert difference[12] > 5 * difference[24]
    assert difference[24] < 5e-3

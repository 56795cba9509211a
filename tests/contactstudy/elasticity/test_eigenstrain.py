"""Stress and displacement by plastic strain: in plane strain, and varying along a period."""

from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.grid import Grid
from contactstudy.elasticity.eigenstrain.fourier_modes import Components, Waves
from contactstudy.elasticity.eigenstrain.periodic_operator import PeriodicOperator, antiplane_convolution
from contactstudy.elasticity.eigenstrain.plane_strain_operator import (
    EigenstrainOperator,
    Moduli,
    OuterStrain,
    PlaneStrainOperator,
    Volume,
)
from contactstudy.elasticity.kernels.stress import BOUSSINESQ, StressCoefficients
from tests.conftest import STEEL as STEEL_BODY

STEEL = Moduli(2.6, 0.3)  # 2G = 2
TENSOR = ("xx", "yy", "zz", "yz", "xz", "xy")
EVEN, GRADED = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5), (0.0, 0.3, 0.7, 1.2, 2.0, 4.0)


def plane(edges: tuple[float, ...] = GRADED, poisson_ratio: float = 0.3) -> PlaneStrainOperator:
    """A volume of a part of the grid."""
    return PlaneStrainOperator(Volume(Grid((20, 1), (8.0, 3.0)), 4, 13, edges), Moduli(2.0, poisson_ratio))


@cache
def small() -> PeriodicOperator:
    """Graded layers from a thin one on, an odd and an even number of cells, cells longer than wide."""
    return PeriodicOperator(Volume(Grid((9, 6), (9.0, 8.0)), 3, 7, (0.0, 0.05, 0.1, 1.5)), STEEL)


def noise(operator: EigenstrainOperator, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(len(operator.basis), *operator.volume.shape))


def deviator(operator: EigenstrainOperator, tensor: np.ndarray) -> np.ndarray:
    """Deviatoric components (C, ...) of a tensor xx, yy, zz, yz, xz, xy (6, ...)."""
    return np.einsum("ct,t...->c...", operator.basis * (1, 1, 1, 2, 2, 2), tensor)


@pytest.mark.parametrize("operator", [*(plane(edges, nu) for edges in (EVEN, GRADED) for nu in (0.0, 0.5)), small()])
def test_plastic_strain_has_an_energy_that_is_symmetric_and_below_that_of_a_rigid_body(
    operator: EigenstrainOperator,
) -> None:
    shape = len(operator.basis), *operator.volume.shape
    root = np.sqrt(np.broadcast_to(operator.volume.cell_volumes, shape)).ravel()
    columns = [operator.negative_residual_stress(unit.reshape(shape)).ravel() for unit in np.eye(len(root))]
    energy = np.array(columns).T * root[:, None] / root / (2 * operator.moduli.shear)
    assert np.abs(energy - energy.T).max() <= 1e-12
    values = np.linalg.eigvalsh((energy + energy.T) / 2)
    # an incompressible body in plane strain takes nothing off some strains: 2G is reached to rounding
    assert 5e-5 < values[0] < values[-1] < (1 + 1e-12 if operator.moduli.poisson_ratio == 0.5 else 1 - 1e-4)


@pytest.mark.parametrize("operator", [plane(), small()], ids=["plane", "periodic"])
def test_the_lift_of_the_surface_does_the_work_that_pressure_does_on_plastic_strain(
    operator: EigenstrainOperator,
) -> None:
    strain, grid = noise(operator), operator.volume.grid
    pressure = np.random.default_rng(1).normal(size=grid.cells)
    work = (operator.volume.cell_volumes * strain * operator.stress_of_pressure(pressure)).sum()
    assert (operator.residual_displacement(strain) * pressure).sum() * grid.cell_area == pytest.approx(work, rel=1e-12)


def test_a_pressed_cell_makes_the_stress_of_its_point_formulas_where_it_varies_along() -> None:
    grid, edges = Grid((16, 8), (16.0, 12.0)), (0.0, 1.0, 2.0, 4.0)
    operator = PeriodicOperator(Volume(grid, 5, 11, edges), STEEL)
    pressure = np.zeros(grid.cells)
    pressure[7, 3] = 1
    computed = operator.stress_of_pressure(pressure)
    points, weights = np.polynomial.legendre.leggauss(5)
    points, weights = points / 2, weights / 2
    x = ((grid.x[5:11] - grid.x[7])[:, None] + points).ravel()
    y = ((grid.y - grid.y[3])[:, None] + 1.5 * points).ravel()
    for layer, (top, bottom) in enumerate(pairwise(edges)):
        mean = np.zeros((6, 6, 8))
        for number, name in enumerate(TENSOR):
            for point, weight in zip(points, weights, strict=True):
                z = (top + bottom) / 2 + point * (bottom - top)
                at = StressCoefficients(BOUSSINESQ[name], z, 0.3).row(x, y, 1.0, 1.5, 12.0)
                cells = at.reshape(6, 5, 8, 5)
                mean[number] += weight * np.einsum("iajb,a,b->ij", cells, weights, weights)
        # short waves: exp(-pi z / dx) of the third in the first layer, nothing of them below
        accuracy = 2e-3 if layer == 0 else 1e-6
        assert np.abs(computed[:, layer] - deviator(operator, mean)).max() < accuracy


@pytest.mark.parametrize(("kind", "along", "parts"), [(PlaneStrainOperator, 1, (5, 1)), (PeriodicOperator, 12, (3, 3))])
def test_shear_makes_the_stress_of_cerruti(kind: Any, along: int, parts: tuple[int, int]) -> None:
    """Means over cells beside points in the middle of the parts of each cell, for all components."""
    grid, (m, n) = cs.Grid((24, along), (72e-6, 54e-6)), parts
    x, y = grid.x[:, None] / 36e-6, 2 * np.pi * grid.y / 54e-6
    shear = np.where(abs(x) < 0.5, 1 + 0.5 * x + 0.7 * np.cos(y) + 0.3 * np.sin(2 * y), 0.0)
    operator = kind(Volume(grid, 0, 24, (3e-6, 6e-6, 12e-6)), Moduli(2e11, 0.3))
    nodes = (np.arange(6) + 0.5) / 6
    below = cs.SubsurfaceStress((*(3e-6 + nodes * 3e-6), *(6e-6 + nodes * 6e-6)))
    finer = cs.Grid((24 * m, along * n), grid.extent)
    traction = shear.repeat(m, axis=0).repeat(n, axis=1)
    stress = below.of((STEEL_BODY, STEEL_BODY), finer, (cs.ZeroPadding(), cs.ExactPeriodicity()))
    points = stress.with_shear(np.stack([traction, 0 * traction]))(0 * traction)
    expected = deviator(operator, points.reshape(6, 2, 6, 24, m, along, n).mean(axis=(2, 4, 6)))
    np.testing.assert_allclose(operator.stress_of_shear(shear), expected, atol=0.015)


def test_a_deep_sphere_keeps_the_stress_of_eshelby() -> None:
    radius, middle = 4.0, 24.0
    edges = (0.0, 6.0, 12.0, 18.0, *np.arange(19.0, 30.0))
    grid = Grid((30, 32), (30.0, 32.0))
    volume = Volume(grid, 10, 20, edges)
    operator = PeriodicOperator(volume, STEEL)
    squared = grid.x[10:20, None] ** 2 + grid.y**2 + (volume.depths[:, None, None] - middle) ** 2
    squared[:3] = np.inf
    # Eshelby (1957), eq. 3.14: 1 - beta; the sphere is made of cells, images have (R / L)^3
    fraction = 1 - 2 * (4 - 5 * 0.3) / (15 * (1 - 0.3))
    for component in range(5):
        strain = np.zeros((5, *volume.shape))
        strain[component] = squared < radius**2
        stress = operator.negative_residual_stress(strain)
        computed = stress[:, squared < (radius / 2) ** 2].mean(axis=1) / 2
        assert np.abs(computed - fraction * np.eye(5)[component]).max() < 0.03


def test_half_lines_of_strain_are_the_limit_of_finite_strips() -> None:
    """What is left of the cells beyond falls as one over their distance, which is extrapolated."""
    left, right = np.random.default_rng(3).standard_normal((2, 3, 5))

    def of_strips(beyond: int) -> tuple[np.ndarray, np.ndarray]:
        cells, inside = 20 + 2 * beyond, slice(beyond, -beyond)
        wide = PlaneStrainOperator(Volume(Grid((cells, 1), (0.4 * cells, 3.0)), 0, cells, GRADED), STEEL)
        strain = np.zeros((3, *wide.volume.shape))
        strain[..., :beyond, 0], strain[..., -beyond:, 0] = left[..., None], right[..., None]
        return wide.residual_stress_tensor(strain)[..., inside, :], wide.residual_displacement(strain)[inside]

    near = PlaneStrainOperator(Volume(Grid((20, 1), (8.0, 3.0)), 0, 20, GRADED), STEEL)
    outer = OuterStrain(near)
    found = outer.tensor(left, right), outer.residual_displacement(left, right)
    for exact, shorter, longer in zip(found, of_strips(500), of_strips(1000), strict=True):
        np.testing.assert_allclose(2 * longer - shorter, exact, atol=1e-3 * np.abs(exact).max())
    # without strain in the volume the stress of those beyond is all there is
    np.testing.assert_allclose(outer.stress(left, right), deviator(near, found[0]), atol=1e-12)


def test_what_does_not_vary_along_the_length_is_plane_strain() -> None:
    operator = small()
    alone = Volume(Grid((9, 1), operator.volume.grid.extent), 3, 7, operator.volume.edges)
    plane, antiplane = PlaneStrainOperator(alone, STEEL), antiplane_convolution(alone, STEEL)
    strain = noise(plane)
    along, shear = np.zeros((2, 5, *operator.volume.shape))
    along[:3], shear[3:] = strain, strain[:2]
    computed = operator.negative_residual_stress(along)
    assert np.abs(computed[:3] - plane.negative_residual_stress(strain)).max() < 1e-13
    assert np.abs(computed[3:]).max() < 1e-13
    computed = operator.negative_residual_stress(shear)
    assert np.abs(computed[3:, ..., 0] - antiplane(strain[:2, ..., 0])).max() < 1e-13
    displacement = operator.residual_displacement(along) - plane.residual_displacement(strain)
    assert np.abs(displacement).max() < 1e-13
    pressure = np.random.default_rng(1).normal(size=(9, 1))
    stress = operator.stress_of_pressure(np.repeat(pressure, 6, 1))[:3]
    assert np.abs(stress - plane.stress_of_pressure(pressure)).max() < 1e-13


def test_waves_add_up_to_the_closed_forms_of_an_infinite_axis() -> None:
    cells, period = 12, 1501
    volume = Volume(Grid((cells, 1), (12.0, 1e9)), 0, cells, (0.0, 0.7, 1.4, 2.1, 3.5, 4.5))
    waves = Waves(volume, STEEL, np.array([1e-3]), period)
    x, z = volume.grid.x[:, None], volume.depths[:, None, None]
    shape = np.exp(-((x / 3) ** 2) - ((z - 2) / 1.5) ** 2)
    strain = np.array([0.3, -0.5, 0.8, 0.6, -0.4])[:, None, None, None] * shape
    computed = -np.fft.ifft(waves.stress(np.fft.fft(strain, period, axis=2), Components.DEVIATOR), axis=2)
    computed = computed[:, :, :cells].real
    plane, antiplane = PlaneStrainOperator(volume, STEEL), antiplane_convolution(volume, STEEL)
    # short waves between layers further apart than the next: a per mille; the period: 1 / X
    assert np.abs(computed[:3] - plane.negative_residual_stress(strain[:3])).max() < 2e-3
    assert np.abs(computed[3:, ..., 0] - antiplane(strain[3:, ..., 0])).max() < 2e-3
    blocks = waves.diagonal_blocks(np.array([1 / period]))
    assert np.abs(blocks[:, :3, :3] - plane.diagonal_blocks).max() < 1e-3
    assert np.abs(blocks[:, 3:, 3:] - antiplane.diagonal_blocks).max() < 1e-3

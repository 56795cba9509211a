import itertools
from math import inf

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.kernels.layer_response import LayerResponse, StressWaves
from contactstudy.elasticity.kernels.layer_waves import amplitudes
from contactstudy.elasticity.kernels.stress import COMPONENTS, HalfSpaceStress
from contactstudy.scene.solids.coated import BELOW, CoatedStress
from contactstudy.scene.stress import SubsurfaceStressOperator
from tests.conftest import STEEL

LINE = cs.ZeroPadding(), cs.ExactPeriodicity()
LATTICE = (cs.ExactPeriodicity(),) * 2
FREE = (cs.ZeroPadding(),) * 2
# a lattice's closed forms are sums over many rows
ALL = [LINE, FREE, pytest.param(LATTICE, marks=pytest.mark.whole)]
NAMES = list(COMPONENTS)
GRID = cs.Grid((3, 2), (1.0, 0.7))
PRESSURE, *SHEAR = np.random.default_rng(5).random((3, *GRID.cells))


def integral(s: np.ndarray) -> np.ndarray:
    s = np.clip(s, -1, 1)
    return (s * np.sqrt(1 - s * s) + np.arcsin(s)) / 2


def under_ellipse(ratio: float, cells: int, *depths: float) -> np.ndarray:
    """Return stress (component, depth, x) under ``sqrt(1 - x^2)`` on a layer of thickness 1, nu = 0.3 throughout."""
    grid = cs.Grid((cells, 1), (2.4, 1.0))
    ends = grid.x[:, None] + np.array([-0.5, 0.5]) * grid.cell_size[0]
    pressure = np.diff(integral(ends), axis=1) / grid.cell_size[0]
    medium = CoatedStress((LayerResponse((ratio,), (0.3, 0.3)),), (1.0,))
    return SubsurfaceStressOperator(grid, LINE, medium, depths)(pressure)[..., 0]


@pytest.mark.parametrize(
    ("ratio", "surface", "above", "below", "normal", "shear"),
    [
        (4.0, -1.848123638, 0.572596958, -0.041852663, -0.575561474, 0.18282438),
        (1.0, -1.0, -0.121320344, -0.121320344, -0.707106781, 0.21796353),
        (0.25, -0.656839278, -0.312125626, -0.242306219, -0.782597110, 0.21002334),
    ],
)
def test_stress_on_the_axis_is_that_of_a_quadrature_over_waves(
    ratio: float, surface: float, above: float, below: float, normal: float, shear: float
) -> None:
    """To six digits, from two grids: the error of a pressure constant in each cell falls with the square of the cell."""
    coarse, fine = (under_ellipse(ratio, n, 0.0, 1.0, BELOW) for n in (201, 401))
    xx, zz = NAMES.index("xx"), NAMES.index("zz")
    found = []
    for component, level in ((xx, 0), (xx, 1), (xx, 2), (zz, 1)):
        one, two = coarse[component, level, 100], fine[component, level, 200]
        found.append(two + (two - one) / ((401 / 201) ** 2 - 1))
    assert found == pytest.approx([surface, above, below, normal], abs=1e-6)
    assert fine[NAMES.index("xz"), 1].max() == pytest.approx(shear, rel=2e-5)


@pytest.mark.parametrize("paddings", ALL)
def test_equal_moduli_give_the_half_space_with_every_padding(paddings: cs.Paddings) -> None:
    coated, plain = (
        SubsurfaceStressOperator(GRID, paddings, medium, (0.3,)).with_shear(np.array(SHEAR))(PRESSURE)
        for medium in (CoatedStress((LayerResponse((1.0,), (0.3, 0.3)),), (0.5,)), HalfSpaceStress(0.3))
    )
    np.testing.assert_allclose(coated, plain, rtol=0, atol=1e-12)


@pytest.mark.cases(1)
@pytest.mark.parametrize("paddings", ALL)
def test_traction_is_continuous_at_the_bond_and_the_surface_bears_what_presses_it(paddings: cs.Paddings) -> None:
    shear = np.array(SHEAR) * (paddings != LATTICE)  # three times as many sums
    medium = CoatedStress((LayerResponse((5.0,), (0.2, 0.4)),), (0.5,))
    stress = SubsurfaceStressOperator(GRID, paddings, medium, (0.0, 0.5, 0.5 * BELOW)).with_shear(shear)(PRESSURE)
    rows = [NAMES.index(name) for name in ("zz", "yz", "xz")]
    np.testing.assert_allclose(stress[rows, 1], stress[rows, 2], rtol=0, atol=3e-12)
    np.testing.assert_allclose(stress[rows, 0], [-PRESSURE, -shear[1], -shear[0]], rtol=0, atol=1e-12)
    # strain in the plane is continuous too: for xy it is that over the shear modulus
    row = NAMES.index("xy")
    np.testing.assert_allclose(stress[row, 1], 5.0 * stress[row, 2], rtol=0, atol=1e-11)


def test_stress_under_a_wave_of_any_load_is_in_equilibrium_below_the_bond() -> None:
    layer, kx, ky, step = LayerResponse((4.0,), (0.25, 0.35)), 1.1, -0.7, 1e-4

    def stress(load: str, depth: float) -> dict[str, complex]:
        waves = StressWaves(layer, depth, load)
        return {name: one.item() for name, one in amplitudes(waves, np.array([[kx]]), np.array([[ky]])).items()}

    for load, depth in itertools.product(("pressure", "across", "along"), (1.1, 2.0)):
        at, above, below = (stress(load, depth + off) for off in (0.0, -step, step))
        for across, along, down in (("xx", "xy", "xz"), ("xy", "yy", "yz"), ("xz", "yz", "zz")):
            slope = (below[down] - above[down]) / (2 * step)
            assert abs(1j * kx * at[across] + 1j * ky * at[along] + slope) < 1e-7
            assert abs(slope) > 1e-4


@pytest.mark.parametrize(("ratio", "thickness"), [(3.0, 2.0), (1e3, 0.5)])
def test_stress_below_a_body_that_ends_is_the_same_on_a_wider_grid(ratio: float, thickness: float) -> None:
    medium = CoatedStress((LayerResponse((ratio,), (0.25, 0.35)),), (thickness,))
    random, stresses = np.random.default_rng(3).random((3, 6, 6)), []
    for cells in (6, 48):
        grid, first = cs.Grid((cells, cells), (cells / 6, cells / 6)), cells // 2 - 3
        loads = np.zeros((3, *grid.cells))
        loads[:, first : first + 6, first : first + 6] = random
        below = SubsurfaceStressOperator(grid, FREE, medium, (0.0, 0.4, thickness, 9.0))
        stress = below.with_shear(loads[1:])(loads[0])
        stresses.append(stress[..., first : first + 6, first : first + 6])
    np.testing.assert_allclose(*stresses, rtol=0, atol=1e-12 * np.abs(stresses[1]).max())


def test_a_substrate_that_does_not_yield_holds_the_coating_in_its_plane() -> None:
    """Without strain in the plane at the interface ``s_xx = nu / (1 - nu) s_zz``."""
    medium = CoatedStress((LayerResponse((0.0,), (0.3, 0.3)),), (0.5,))
    grid = cs.Grid((32, 1), (2.4, 1.0))
    pressure = np.sqrt(np.maximum(1 - grid.x[:, None] ** 2, 0))
    stress = SubsurfaceStressOperator(grid, LINE, medium, (0.5,))(pressure)
    xx, zz = stress[NAMES.index("xx")], stress[NAMES.index("zz")]
    np.testing.assert_allclose(xx, 0.3 / 0.7 * zz, atol=1e-9)


def test_a_depth_given_as_the_sum_of_two_thicknesses_is_that_of_their_interface() -> None:
    middle = cs.HalfSpace(100e9, 0.3, thickness=6e-6)
    coated = cs.CoatedHalfSpace(cs.HalfSpace(300e9, 0.25), 4e-6, STEEL, (middle,))
    for depth in (1e-5, 4e-6 + 6e-6, "10 um"):
        below = cs.SubsurfaceStress((depth,), body=1)
        scene = cs.Scene(cs.LineLoad(1e4), (STEEL, coated), (cs.Cylinder(0.01),), outputs=(below,))
        assert "interlayer_0_shear" in cs.solve(scene, cs.Grid((64, 1), (2e-4, 1e-3))).quantities


@pytest.mark.parametrize(("modulus", "shear"), [(250e9, 44.17e6), (50e9, 21.87e6)])
def test_the_shear_at_the_interface_of_a_thin_coating_is_resolved_where_it_is_asked_for(
    modulus: float, shear: float
) -> None:
    """Reference on cells of a sixteenth of the thickness."""
    coated = cs.CoatedHalfSpace(cs.HalfSpace(modulus, 0.22), 2e-6, STEEL)
    below = cs.SubsurfaceStress((1e-6, 2e-6, 2.001e-6, 5e-5), body=1)
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, coated), (cs.Cylinder(0.01),), outputs=(below,))
    numbers = cs.solve(scene, error=0.05).quantities
    found = numbers["interface_shear"]
    assert abs(found.value - shear) <= found.bound < 0.1 * shear
    largest = max(numbers[f"{part}_von_mises"].value for part in ("coating", "substrate"))
    assert numbers["largest_von_mises"].value == largest
    for name in ("coating_von_mises", "substrate_von_mises", "largest_von_mises"):
        assert "Scene.solids[1]" in numbers[name].label
        assert numbers[name].bound < 0.1 * numbers[name].value
    coarse = cs.solve(scene, cs.Grid((48, 1), (2.5e-4, 1e-3)), cs.ExactPeriodicity())
    unresolved = coarse.quantities["interface_shear"]
    assert unresolved.bound == inf
    assert "cells in the coating" in unresolved.reason

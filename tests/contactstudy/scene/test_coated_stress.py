from dataclasses import replace
from math import inf

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.kernels.layer_response import LayerResponse, LayerStress
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS
from contactstudy.scene.solids.coated import BELOW, CoatedStress
from contactstudy.scene.solids.stress_model import HalfSpaceStress
from contactstudy.scene.stress import SubsurfaceStressOperator, von_mises
from tests.conftest import STEEL

LINE = cs.ZeroPadding(), cs.ExactPeriodicity()
LATTICE = (cs.ExactPeriodicity(),) * 2
FREE = (cs.ZeroPadding(),) * 2
# a lattice's closed forms are sums over many rows
ALL = [LINE, FREE, pytest.param(LATTICE, marks=pytest.mark.whole)]
NAMES = list(COMPONENTS)


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


@pytest.mark.cases(5)
@pytest.mark.parametrize(
    ("ratio", "surface", "above", "below", "normal", "shear"),
    [
        (4.0, -1.848123638, 0.572596958, -0.041852663, -0.575561474, 0.18282438),
        (2.0, -1.340154568, 0.135961520, -0.070823998, -0.647755538, 0.20701233),
        (1.0, -1.0, -0.121320344, -0.121320344, -0.707106781, 0.21796353),
        (0.5, -0.785043097, -0.253020878, -0.183848206, -0.751784948, 0.21695559),
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


def test_von_mises_stress_on_the_axis_is_that_of_a_quadrature() -> None:
    depths = 0.25, 0.5, 0.75, 1.0, BELOW, 1.5, 2.0, 3.0
    found = von_mises(under_ellipse(4.0, 401, *depths))[:, 200]
    expected = [
        0.4092062,
        0.4056089,
        0.6397773,
        0.9943345,
        0.4784160,
        0.3977497,
        0.3347978,
        0.2501797,
    ]
    assert found == pytest.approx(expected, rel=2e-5)


def test_one_wave_of_pressure_and_shear() -> None:
    """A system of six equations, solved with 40 digits."""
    materials, k = LayerResponse((4.0,), (0.25, 0.35)), np.array([0.7])
    for depth, expected in (
        (0.4, (-0.859772142243, -0.558805376983, -0.12054257933)),
        (BELOW, (-0.651302638895, -0.34616473468, 0.0410268304655)),
    ):
        pressed, sheared = LayerStress(materials, depth).plane(k)[:, :, 0]
        assert pressed + 0.4 * sheared == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("paddings", ALL)
def test_equal_moduli_give_the_half_space_with_every_padding(paddings: cs.Paddings) -> None:
    grid = cs.Grid((3, 2), (1.0, 0.7))
    random = np.random.default_rng(5)
    pressure, shear = random.random(grid.cells), random.random((2, *grid.cells))
    depths = (0.3,) if paddings == LATTICE else (0.3, 0.8)
    coated, plain = (
        SubsurfaceStressOperator(grid, paddings, medium, depths).with_shear(shear)(pressure)
        for medium in (
            CoatedStress((LayerResponse((1.0,), (0.3, 0.3)),), (0.5,)),
            HalfSpaceStress(0.3),
        )
    )
    np.testing.assert_allclose(coated, plain, rtol=0, atol=1e-12)


@pytest.mark.cases(1)
@pytest.mark.parametrize("paddings", ALL)
def test_traction_is_continuous_at_the_bond_and_the_surface_bears_what_presses_it(
    paddings: cs.Paddings,
) -> None:
    grid = cs.Grid((3, 2), (1.0, 0.7))
    random = np.random.default_rng(5)
    pressure, shear = random.random(grid.cells), random.random((2, *grid.cells))
    shear *= paddings != LATTICE  # three times as many sums
    medium = CoatedStress((LayerResponse((5.0,), (0.2, 0.4)),), (0.5,))
    below = SubsurfaceStressOperator(grid, paddings, medium, (0.0, 0.5, 0.5 * BELOW))
    stress = (below.with_shear(shear) if shear.any() else below)(pressure)
    rows = [NAMES.index(name) for name in ("zz", "yz", "xz")]
    np.testing.assert_allclose(stress[rows, 1], stress[rows, 2], rtol=0, atol=3e-12)
    np.testing.assert_allclose(stress[rows, 0], [-pressure, -shear[1], -shear[0]], rtol=0, atol=1e-12)
    # strain in the plane is continuous too: for xy it is that over the shear modulus
    row = NAMES.index("xy")
    np.testing.assert_allclose(stress[row, 1], 5.0 * stress[row, 2], rtol=0, atol=1e-11)


def test_what_is_alike_along_the_length_is_plane_strain() -> None:
    medium = CoatedStress((LayerResponse((3.0,), (0.25, 0.35)),), (0.2,))
    pressure = np.random.default_rng(2).random((5, 1))
    shear = np.stack([pressure**2, 1 - pressure])
    depths = 0.0, 0.4
    line, strip = (
        SubsurfaceStressOperator(cs.Grid((5, n), (1.0, 0.7)), LINE, medium, depths).with_shear(
            np.repeat(shear, n, axis=2)
        )(np.repeat(pressure, n, axis=1))
        for n in (1, 2)
    )
    np.testing.assert_allclose(strip, np.repeat(line, 2, axis=3), rtol=0, atol=2e-10)


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


@pytest.mark.parametrize("ratio", [0.1, 3.0])
def test_far_below_a_thin_coating_the_stress_is_that_in_the_substrate(ratio: float) -> None:
    """What the coating changes there is of the order of its thickness over the depth, 3e-4."""
    grid, pressure = cs.Grid((65, 1), (4.0, 1.0)), np.zeros((65, 1))
    pressure[32] = 1.0
    coated, plain = (
        SubsurfaceStressOperator(grid, LINE, medium, (1.0,))(pressure)
        for medium in (
            CoatedStress((LayerResponse((ratio,), (0.3, 0.3)),), (3e-4,)),
            HalfSpaceStress(0.3),
        )
    )
    np.testing.assert_allclose(coated, plain, rtol=0, atol=1e-3 * np.abs(plain).max())


def test_a_substrate_that_does_not_yield_holds_the_coating_in_its_plane() -> None:
    """Without strain in the plane at the interface ``s_xx = nu / (1 - nu) s_zz``."""
    medium = CoatedStress((LayerResponse((0.0,), (0.3, 0.3)),), (0.5,))
    grid = cs.Grid((32, 1), (2.4, 1.0))
    pressure = np.sqrt(np.maximum(1 - grid.x[:, None] ** 2, 0))
    stress = SubsurfaceStressOperator(grid, LINE, medium, (0.5,))(pressure)
    xx, zz = stress[NAMES.index("xx")], stress[NAMES.index("zz")]
    np.testing.assert_allclose(xx, 0.3 / 0.7 * zz, atol=1e-9)


@pytest.mark.parametrize("fractions", [None, (0.5, 0.70429, 1.0, 1.5)])
def test_numbers_of_a_coating_are_its_von_mises_stress_and_the_shear_at_its_bond(
    fractions: tuple[float, ...] | None,
) -> None:
    """Materials that are nearly alike, under Hertz's pressure: 0.5575162 and 0.21796353 of its peak, by quadrature."""
    plain = cs.Scene(cs.LineLoad(1e5), (cs.HalfSpace(inf, 0.3), STEEL), (cs.Cylinder(0.01),))
    thickness = plain.hertz.half_width
    coating = replace(STEEL, youngs_modulus=STEEL.youngs_modulus * (1 + 1e-6))
    depths = "auto" if fractions is None else tuple(part * thickness for part in fractions)
    scene = replace(
        plain,
        solids=(plain.solids[0], cs.CoatedHalfSpace(coating, thickness, STEEL)),
        outputs=(cs.SubsurfaceStress(depths, body=1),),
    )
    grid = cs.Grid((201, 1), (2.4 * thickness, 1e-3))
    quantities = cs.solve(scene, grid, cs.ExactPeriodicity()).quantities
    in_coating, interface = quantities["coating_von_mises"], quantities["interface_shear"]
    peak = plain.hertz.peak_pressure
    assert in_coating.value / peak == pytest.approx(0.5575162, rel=1e-2 if fractions is None else 1e-3)
    assert in_coating.position["z"] == pytest.approx(0.70429 * thickness, rel=0.15)
    assert interface.value / peak == pytest.approx(0.21796353, rel=1e-3)
    assert abs(interface.position["x"]) == pytest.approx(0.950175 * thickness, abs=2 * grid.cell_size[0])


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize(("modulus", "shear"), [(250e9, 44.17e6), (50e9, 21.87e6)])
def test_the_shear_at_the_interface_of_a_thin_coat_is_resolved_where_it_is_asked_for(
    modulus: float, shear: float, number: int
) -> None:
    """Reference on cells of a sixteenth of the thickness."""
    coated = cs.CoatedHalfSpace(cs.HalfSpace(modulus, 0.22), 2e-6, STEEL)
    bodies = (coated, STEEL) if number == 0 else (STEEL, coated)
    scene = cs.Scene(
        cs.LineLoad(1e5),
        bodies,
        (cs.Cylinder(0.01),),
        outputs=(cs.SubsurfaceStress((1e-6, 2e-6, 2.001e-6, 5e-5), number),),
    )
    planned = cs.solve(scene, error=0.05)
    numbers = planned.quantities
    found = numbers["interface_shear"]
    assert abs(found.value - shear) <= found.bound < 0.1 * shear
    largest = max(numbers[f"{part}_von_mises"].value for part in ("coating", "substrate"))
    assert numbers["largest_von_mises"].value == largest
    for name in ("coating_von_mises", "substrate_von_mises", "largest_von_mises"):
        assert f"Scene.solids[{number}]" in numbers[name].label
        assert numbers[name].bound < 0.1 * numbers[name].value
    coarse = cs.solve(scene, cs.Grid((48, 1), (2.5e-4, 1e-3)), cs.ExactPeriodicity())
    unresolved = coarse.quantities["interface_shear"]
    assert unresolved.bound == inf
    assert "cells in the coating" in unresolved.reason


def test_the_stresses_of_both_coated_bodies_are_given_under_their_names() -> None:
    hard, soft = (cs.CoatedHalfSpace(cs.HalfSpace(modulus, 0.25), 1e-5, STEEL) for modulus in (400e9, 100e9))
    scene = cs.Scene(cs.LineLoad(1e5), (hard, soft), (cs.Cylinder(0.01),))
    outputs = cs.SubsurfaceStress(), cs.SubsurfaceStress(body=1)
    grid = cs.Grid((48, 1), (2.6e-4, 1e-3))
    both = cs.solve(replace(scene, outputs=outputs), grid, cs.ExactPeriodicity())
    for output, suffix in zip(outputs, ("", "_1"), strict=True):
        one = cs.solve(replace(scene, outputs=(output,)), grid, cs.ExactPeriodicity()).quantities
        for name in (
            "largest_von_mises",
            "largest_shear_stress",
            "coating_von_mises",
            "interface_shear",
        ):
            assert str(both.quantities[name + suffix]) == str(one[name])
    assert both.to_dataset()["von_mises_1"].dims == ("z_1", "x", "y")
    with pytest.raises(cs.InvalidInput, match="second of its kind"):
        replace(scene, outputs=(outputs[0], outputs[0]))

from dataclasses import replace
from math import inf, log, sqrt
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.convolution import influence_coefficients
from contactstudy.elasticity.tangential import shear_response
from tests.conftest import STEEL

RIGID = cs.HalfSpace(inf, 0.3)
DLC = cs.HalfSpace(250e9, 0.22)
EXACT, FREE = cs.ExactPeriodicity(), cs.ZeroPadding()
PADDINGS = {
    "row": (FREE, EXACT), "lattice": (EXACT, EXACT), "free": (FREE, FREE),
    "window": (FREE, cs.DuplicatedPadding()), "turned": (EXACT, cs.Superposition(2)),
}  # fmt: skip


def coefficients(body: cs.Body, grid: cs.Grid, paddings: cs.Paddings, datum: float = 1e-4) -> np.ndarray:
    """Displacement under unit pressure on one cell, at all offsets."""
    return np.asarray(
        sum(weight * influence_coefficients(grid, paddings, one) for one, weight in body.response(datum).items())
    )


@pytest.mark.parametrize("padding", PADDINGS)
def test_a_thin_coating_is_its_substrate_and_a_thick_one_its_own_material(padding: str) -> None:
    grid = cs.Grid((6, 40), (1.1e-3, 0.8e-3))
    for coating, substrate in ((DLC, STEEL), (STEEL, replace(STEEL, youngs_modulus=2e8))):
        body = cs.CoatedHalfSpace(coating, 1e-21, substrate)
        thin = coefficients(body, grid, PADDINGS[padding])
        bare = coefficients(substrate, grid, PADDINGS[padding])
        # a film adds its membrane's fraction, (E1 / E2) h / dx < 1e-13, and the sums their rounding
        assert np.abs(thin - bare).max() <= 1e-12 * np.abs(bare).max()
        thick = coefficients(replace(body, thickness=1e9), grid, PADDINGS[padding])
        alone = coefficients(coating, grid, PADDINGS[padding])
        # up to 1e3 times the difference of two large logarithms is rounding
        assert np.abs(thick - alone).max() <= 1e-9 * np.abs(alone).max()


@pytest.mark.parametrize("thickness", [1e-6, 0.1])
def test_a_coated_surface_stays_where_it_is_at_the_datum(thickness: float) -> None:
    body, datum = cs.CoatedHalfSpace(STEEL, thickness, DLC, (cs.HalfSpace(3e9, 0.4, thickness=1e-4),)), 0.02
    near, far = (
        sum(w * one.row(np.array([[x]]), np.zeros(1), 1e-4, 1e-4, 1e-4) for one, w in body.response(datum).items())
        for x in (0.0, datum)
    )
    assert abs(far) <= 1e-6 * near


A, MODULUS = 1e-4, 2e9


def ground(ratio: float, wide: float) -> cs.CoatedHalfSpace:
    """A coating that is so many times as stiff as its substrate, and A over `wide` thick."""
    coating = cs.HalfSpace(MODULUS * (1 - 0.3**2), 0.3)
    substrate = replace(coating, youngs_modulus=coating.youngs_modulus / ratio)
    return cs.CoatedHalfSpace(coating, A / wide, substrate)


# Rigid cylinder, nu = 0.3 in coating and substrate, E1* = R = 1: P / (E1* a^2 / R), p0 / (E1* a / R).
# Source: Chebyshev collocation of the layered problem, residual 3e-12
CYLINDERS = ((4, 1, 0.458102570999, 0.277768758153), (1 / 4, 0.2, 0.800833019014, 0.509889180575))


@pytest.mark.parametrize(("ratio", "wide", "load", "peak"), CYLINDERS)
def test_a_rigid_cylinder_on_a_coating(ratio: float, wide: float, load: float, peak: float) -> None:
    scene = cs.Scene(cs.LineLoad(load * MODULUS * A**2), (ground(ratio, wide), RIGID), (cs.Cylinder(1.0),))
    off = []
    for cells in (128, 512):
        solution = cs.solve(scene, cs.Grid((cells, 1), (2.4 * A, 1e-3)), EXACT, tolerance=1e-10)
        assert solution.status is cs.Status.CONVERGED
        off.append(abs(solution.pressure.max() / (peak * MODULUS * A) - 1))
    # second order in the cell: PEAK (dx / a)^2 with a factor below one, and 16 times less on cells a quarter as wide
    assert off[1] <= (2.4 / 512) ** 2
    assert off[1] <= off[0] / 8


# Sphere on the same: P / (E1* a^3 / R), approach / (a^2 / R), pressure in the middle / (E1* a / R).
# Source: a Fredholm equation of the second kind (Lebedev & Ufliand), to 1e-10
SPHERES = ((4, 2, 0.6865234111, 1.4181927454, 0.2677152978), (1 / 4, 0.5, 1.3801110660, 0.8268072130, 0.6603836616))


@pytest.mark.parametrize(("ratio", "wide", "load", "approach", "middle"), SPHERES)
def test_a_rigid_sphere_on_a_coating(ratio: float, wide: float, load: float, approach: float, middle: float) -> None:
    """On the stiff coating that is thin the pressure is highest beside the middle, so the middle is compared."""
    n, extent = 97, 2.3 * A
    line = cs.LineLoad(load * MODULUS * A**3 / extent)
    scene = cs.Scene(line, (ground(ratio, wide), RIGID), (cs.Sphere(1.0),))
    solution = cs.solve(scene, cs.Grid((n, n), (extent, extent)), PADDINGS["free"])
    # second order in the cell (dx / a = 0.024)
    assert solution.approach / A**2 == pytest.approx(approach, rel=0.024**2)
    assert solution.pressure[n // 2, n // 2] / (MODULUS * A) == pytest.approx(middle, rel=0.024**2)


@pytest.mark.parametrize("thickness", [1e-5, 5e-3])
@pytest.mark.parametrize("substrate", [STEEL, RIGID], ids=["steel", "rigid"])
def test_the_modulus_of_its_hertz_contact_is_that_at_the_half_width(thickness: float, substrate: cs.HalfSpace) -> None:
    """Of an incompressible cover too, whose modulus falls as the cube of the half-width."""
    solids = cs.CoatedHalfSpace(cs.HalfSpace(1e7, 0.5), thickness, substrate), RIGID
    for load in (cs.LineLoad(1e4), cs.Approach(1e-4)):
        hertz = cs.Scene(load, solids, (cs.Cylinder(0.1),)).hertz
        modulus = 1 / solids[0].compliance_at(hertz.half_width)
        assert hertz.contact_modulus == pytest.approx(modulus, rel=1e-6)
    # of an approach, the half-width is that of any modulus: Johnson (1985), sect. 5.6, from 0.2 m beside the axis
    turns = 2 * log(2 * 0.2 / hertz.half_width) + 1
    assert hertz.half_width == pytest.approx(sqrt(4 * 0.1 * 1e-4 / turns), rel=1e-6)


@pytest.mark.parametrize("padding", ["row", "free"])
def test_layers_that_are_nearly_alike_are_one_of_their_sum(padding: str) -> None:
    """Pressure, stress in each layer and shear of a stack whose layers differ by 1e-9, which is what may be left."""
    grid, depths = cs.Grid((6, 4), (3e-4, 2e-4)), (0.5e-5, 1.7e-5, 4e-5)
    nearly = replace(DLC, youngs_modulus=250e9 * (1 + 1e-9), thickness=1.2e-5)
    stack = cs.CoatedHalfSpace(DLC, 1e-5, STEEL, (nearly, replace(DLC, thickness=0.8e-5)))
    one = cs.CoatedHalfSpace(DLC, 3e-5, STEEL)
    assert replace(stack, interlayers=(replace(nearly, youngs_modulus=250e9),)).response(1.0) == (
        replace(one, thickness=2.2e-5).response(1.0)
    )
    pressure = np.random.default_rng(1).random((6, 4))
    output = cs.SubsurfaceStress(depths)
    # for the stress of a cell alone stands that of a lattice, whose size depends on how unlike the layers are
    stress = 1e-8 if padding == "row" else 1e-5
    for left, answer in (
        (1e-8, lambda body: coefficients(body, grid, PADDINGS[padding])),
        (stress, lambda body: output.of((body, body), grid, PADDINGS[padding])(pressure)),
        (1e-8, lambda body: shear_response([body], grid, PADDINGS[padding], 1.0).xx.spectrum),
    ):
        found, wanted = map(answer, (stack, one))
        np.testing.assert_allclose(found, wanted, rtol=0, atol=left * np.abs(wanted).max())


def test_a_stack_is_read_from_a_file_and_each_layer_has_its_numbers(tmp_path: Path) -> None:
    path = tmp_path / "stack.toml"
    path.write_text(
        """
        load = { per_length = "100 N/mm" }
        shapes = [{ kind = "Cylinder", radius = "10 mm" }]
        outputs = [{ kind = "SubsurfaceStress", depths = ["2 um", "4 um", "7 um", "8 um", "50 um"] }]
        [[solids]]
        kind = "CoatedHalfSpace"
        coating = { material = "DLC" }
        thickness = "4 um"
        interlayers = [{ material = "TiN", thickness = "4 um" }]
        substrate = { material = "steel" }
        [[solids]]
        material = "steel"
        """
    )
    scene = cs.read_scene(path).scene
    body = scene.solids[0]
    assert body.interlayers[0].youngs_modulus == 300e9
    contact = cs.solve(scene, cs.Grid((128, 1), (2.6e-4, 1e-3)), EXACT)
    numbers = contact.quantities
    stress = contact.derived["von_mises"].values.max(axis=(1, 2))
    z = contact.derived["z"].values
    parts = {"coating": z <= 4e-6, "interlayer_0": (z > 4e-6) & (z <= 8e-6), "substrate": z > 8e-6}
    for name, inside in parts.items():
        found = numbers[f"{name}_von_mises"]
        assert found.value == stress[inside].max()
        assert found.bound < 0.1 * found.value
    assert {"interface_shear", "interlayer_0_shear"} <= numbers.keys()
    path.write_text(contact.to_dataset().attrs["scene"])
    assert cs.read_scene(path).scene == scene

"""Shear and tensile stresses against closed forms (Johnson 1985, sect. 3.4, 4.2 and 7.1; McEwen 1949; Hamilton 1983)."""

from math import pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.io.quantities.quantity import Quantities
from contactstudy.scene.stress import principal_stresses

STEEL = cs.HalfSpace(210e9, 0.3, yield_stress=1e9)
LOAD, CYLINDER = cs.LineLoad(1e5), cs.Cylinder(0.01)
ALL_DEPTHS = cs.SubsurfaceStress()
DEPTHS = 2e-5, 6e-5, 9e-5
AT_SURFACE = cs.SubsurfaceStress((0.0,))


def line(
    cells: int, output: cs.SubsurfaceStress = ALL_DEPTHS, friction: cs.Sliding | None = None
) -> tuple[Quantities, float, float]:
    """Quantities of a line contact, and its peak pressure and half-width by Hertz."""
    scene = cs.Scene(LOAD, (STEEL, STEEL), (CYLINDER,), outputs=(output,), friction=friction)
    half = scene.hertz.half_width
    found = cs.solve(scene, cs.Grid((cells, 1), (3 * half, 3 * half)), cs.ExactPeriodicity()).quantities
    return found, scene.hertz.peak_pressure, half


def ball(
    cells: int, output: cs.SubsurfaceStress = ALL_DEPTHS, friction: cs.Sliding | None = None
) -> tuple[Quantities, float, float]:
    """The same of a ball on a flat."""
    scene = cs.Scene(cs.TotalLoad(50.0), (STEEL, STEEL), (cs.Sphere(0.01),), outputs=(output,), friction=friction)
    half = scene.ellipse.semi_axes[0]
    found = cs.solve(scene, cs.Grid((cells, cells), (3 * half, 3 * half)), cs.ZeroPadding()).quantities
    return found, scene.ellipse.peak_pressure, half


def assert_within_bounds(found: Quantities, expected: dict[str, float], loosest: float) -> None:
    for name, value in expected.items():
        assert abs(found[name].value - value) <= found[name].bound, name
        assert found[name].bound <= loosest * value or not value


def test_principal_stresses_are_the_eigenvalues_of_the_stress() -> None:
    xx, yy, zz, yz, xz, xy = stress = np.random.default_rng(1).normal(size=(6, 20))
    matrices = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
    eigenvalues = np.linalg.eigvalsh(matrices)
    assert np.allclose(principal_stresses(stress), eigenvalues[:, [2, 0]].T)


def test_shear_stresses_below_a_line_contact_are_those_of_johnson() -> None:
    found, peak, half = line(45)
    stresses = {"largest_shear_stress": 0.30028 * peak, "orthogonal_shear_range": peak / 2}
    assert_within_bounds(found, stresses, 0.03)
    depths = {"largest_shear_stress_depth": 0.7861 * half, "orthogonal_shear_depth": half / 2}
    assert_within_bounds(found, depths, 0.1)
    assert_within_bounds(found, {"surface_tension": 0.0}, 0.0)


def test_shear_and_tension_of_a_ball_are_those_of_johnson() -> None:
    found, peak, half = ball(32)
    shear = {"largest_shear_stress": 0.31005 * peak, "largest_shear_stress_depth": 0.4808 * half}
    assert_within_bounds(found, shear, 0.05)
    assert_within_bounds(found, {"surface_tension": (1 - 2 * 0.3) / 3 * peak}, 0.6)


@pytest.mark.parametrize(("cells", "body"), [(40, 0), (41, 1), (103, 0)])  # the edge lies anywhere in its cell
def test_the_tension_behind_a_sliding_cylinder_is_that_of_mcewen(cells: int, body: int) -> None:
    found, peak, half = line(cells, cs.SubsurfaceStress((0.0,), body), cs.Sliding(0.2))
    assert_within_bounds(found, {"surface_tension": 2 * 0.2 * peak}, 0.6)
    # the first body is dragged along +x, and torn where the other holds it back
    assert found["surface_tension"].position["x"] == pytest.approx((2 * body - 1) * half, rel=0.1)


def test_the_tension_behind_a_sliding_ball_is_that_of_hamilton() -> None:
    found, peak, _ = ball(48, AT_SURFACE, cs.Sliding(0.2))
    tension = ((1 - 2 * 0.3) / 3 + 0.2 * pi * (4 + 0.3) / 8) * peak
    assert_within_bounds(found, {"surface_tension": tension}, 0.8)


def test_coating_and_substrate_have_numbers_of_their_own() -> None:
    coated = cs.CoatedHalfSpace(cs.HalfSpace(210e9, 0.3, yield_stress=2e9), 4e-5, STEEL)
    scene = cs.Scene(LOAD, (coated, STEEL), (CYLINDER,), outputs=(ALL_DEPTHS,))
    half = scene.hertz.half_width
    found = cs.solve(scene, cs.Grid((64, 1), (3 * half, 3 * half))).quantities
    whole, _, _ = line(64)
    # both are steel, and the largest stresses lie below the interface
    for name in ("largest_shear_stress", "orthogonal_shear"):
        assert found[f"substrate_{name}"].value == pytest.approx(whole[name].value, rel=6e-3)
    for part, strength in (("coating", 2e9), ("substrate", 1e9)):
        margin, stress = found[f"{part}_safety_factor"], found[f"{part}_von_mises"]
        assert margin.value == pytest.approx(strength / stress.value)
    assert found["safety_factor"].value == found["substrate_safety_factor"].value


def test_a_depth_is_known_to_the_distance_of_the_given_ones_or_of_the_next_to_the_surface() -> None:
    depth = line(64, cs.SubsurfaceStress(DEPTHS))[0]["largest_shear_stress_depth"]
    assert (depth.value, depth.bound) == (9e-5, pytest.approx(3e-5))
    found, _, half = line(64, friction=cs.Sliding(0.5))
    depth = found["largest_von_mises_depth"]
    assert depth.value == 0.0
    assert 0 < depth.bound < 0.05 * half


def test_the_tension_of_a_bent_coating_is_found_beyond_the_grid() -> None:
    coated = cs.CoatedHalfSpace(cs.HalfSpace(4e12, 0.25), 1e-4, STEEL)
    scene = cs.Scene(LOAD, (coated, STEEL), (CYLINDER,), outputs=(AT_SURFACE,))
    narrow, wide = (
        cs.solve(scene, cs.Grid(cells, extent), cs.ExactPeriodicity()).quantities["surface_tension"]
        for cells, extent in (((50, 1), (2.4e-4, 1e-4)), ((250, 1), (2e-3, 1e-4)))
    )
    assert abs(narrow.value - wide.value) <= narrow.bound <= 0.3 * narrow.value
    assert narrow.position["x"] == pytest.approx(wide.position["x"], abs=2e-5)


def test_a_largest_stress_at_the_end_of_the_grid_has_no_bound() -> None:
    found, _, _ = line(64, cs.SubsurfaceStress((2e-3,)))
    assert np.isinf(found["orthogonal_shear"].bound)
    assert "wider grid" in found["orthogonal_shear"].reason

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactstudy as cs
from contactstudy.elasticity.kernels.stress import COMPONENTS, HalfSpaceStress
from contactstudy.scene.stress import SubsurfaceStressOperator
from tests.conftest import STEEL, LineContact

NU, EXACT, FREE = 0.3, cs.ExactPeriodicity(), cs.ZeroPadding()
NAMES = list(COMPONENTS)


@pytest.mark.parametrize("images", [(0, 1), (1, 2)], ids=str)
def test_images_load_the_body_as_a_wider_pressure_would(images: tuple[int, int]) -> None:
    """Along both axes images leave the mean stress open, which is that without lateral strain (Johnson 1985, 3.4)."""
    grid, pressure = cs.Grid((3, 4), (1.0, 0.7)), np.random.default_rng(1).random((3, 4))
    copies = tuple(2 * count + 1 for count in images)
    wide = cs.Grid((3 * copies[0], 4 * copies[1]), (copies[0], 0.7 * copies[1]))
    paddings = cs.Superposition(images[0]) if images[0] else FREE, cs.Superposition(images[1])
    found, alone = (
        SubsurfaceStressOperator(on, padding, HalfSpaceStress(NU), (0.15,))(load)[:, 0]
        for on, padding, load in ((grid, paddings, pressure), (wide, (FREE, FREE), np.tile(pressure, copies)))
    )
    expected = alone[:, 3 * images[0] :, 4 * images[1] :][:, :3, :4]
    if all(images):
        uniform = np.array([-NU / (1 - NU), -NU / (1 - NU), -1.0, 0.0, 0.0, 0.0]) * pressure.mean()
        expected = expected + (uniform - expected.mean(axis=(1, 2)))[:, None, None]
    assert_allclose(found, expected, rtol=0, atol=2e-14)


def test_line_contact_has_its_textbook_stress(line_contact: LineContact) -> None:
    """McEwen (1949), everywhere below; the error falls with the square of the cell."""
    hertz, errors, cells = line_contact.hertz, [], (33, 65, 129, 257)
    depths = tuple(depth * hertz.half_width for depth in (0.3, 0.786, 2.0))
    scene = replace(line_contact.scene, outputs=(cs.SubsurfaceStress(depths),))
    for count in cells:
        dataset = cs.solve(scene, line_contact.grid((count, 1), 1.0), EXACT, tolerance=1e-11).to_dataset()
        found = dataset["stress"].sel(component=["xx", "zz", "xz"]).values[..., 0]
        expected = hertz.stress(dataset["x"].values, dataset["z"].values[:, None])
        errors.append(np.abs(found - expected).max() / hertz.peak_pressure)
    rate = -np.polyfit(np.log(cells), np.log(errors), 1)[0]
    assert rate == pytest.approx(2, abs=0.25)
    assert errors[-1] < (2.4 / cells[-1]) ** 2


def test_point_contact_has_hubers_stress_on_the_axis() -> None:
    """Under Hertz's own pressure, sampled: the error falls like the cell to 3/2, the edge's fraction."""
    hertz = cs.analytic.HertzPoint(1.0, 1.0, 1.0)
    a, depths = hertz.contact_radius, (0.3, 0.481, 1.0, 2.0)
    expected = hertz.axis_stress(np.array(depths) * a, NU)
    errors = []
    for count in (25, 97):
        grid = cs.Grid(cells=(count, count), extent=(2.2 * a, 2.2 * a))
        operator = SubsurfaceStressOperator(grid, (FREE, FREE), HalfSpaceStress(NU), tuple(d * a for d in depths))
        pressure = hertz.pressure(np.hypot(grid.x[:, None], grid.y))
        stress = operator(pressure)[:, :, count // 2, count // 2]
        assert_allclose(stress[0], stress[1], rtol=0, atol=1e-13 * hertz.peak_pressure)
        assert_allclose(stress[3:], 0, atol=1e-13 * hertz.peak_pressure)
        errors.append(np.abs(stress[[0, 2]] - expected).max() / hertz.peak_pressure)
    assert errors[-1] < 1e-3
    assert errors[0] / errors[-1] > 4**1.5 / 1.5


def test_stress_takes_the_ratio_of_the_body_it_is_in(line_contact: LineContact) -> None:
    rubber = cs.HalfSpace(youngs_modulus=1e9, poisson_ratio=0.5)
    grid = line_contact.grid((15, 1), 1.0)
    for solid, ratio in ((0, 0.3), (1, 0.5)):
        asked = cs.SubsurfaceStress(depths=(1e-4,), body=solid)
        scene = replace(line_contact.scene, solids=(STEEL, rubber), outputs=(asked,))
        dataset = cs.solve(scene, grid, EXACT).to_dataset()
        xx, yy, zz = dataset["stress"].values[:3]
        assert_allclose(yy, ratio * (xx + zz), rtol=1e-12)


@pytest.mark.parametrize("most_values", [2**25, 1])
def test_chosen_depths_show_the_largest_stress_to_one_per_cent(
    most_values: int, line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Below a line contact 0.55751 of the peak pressure, 0.704 half-widths down; of a large grid three depths alone."""
    monkeypatch.setattr("contactstudy.scene.stress.MAX_VALUES", most_values)
    scene = replace(line_contact.scene, outputs=(cs.SubsurfaceStress(),))
    grid = line_contact.grid((40, 1), 1.2, width=2.6)
    found, hertz = cs.solve(scene, grid, EXACT).derived, line_contact.hertz
    values, depths = found["von_mises"].values.max(axis=(1, 2)), found["z"].values
    level = values.argmax()
    assert values[level] / hertz.peak_pressure == pytest.approx(0.55751, rel=1e-2)
    assert depths[level] / hertz.half_width == pytest.approx(0.704, rel=0.1)
    # steps by a tenth about the largest, from which the stress falls on both sides
    assert_allclose(depths[level : level + 2] / depths[level - 1 : level + 1], 1.1, rtol=1e-12)
    assert (len(depths) == 3) == (most_values == 1)


@pytest.mark.parametrize(
    "profile",
    [
        cs.HardnessProfile(surface="720 HV", core="350 HV", case_depth="0.15 mm"),
        cs.HardnessProfile((0.0, 2e-3, 2.1e-3), yield_stresses=(2e9, 2e9, 0.1e9)),
    ],
)
def test_the_least_safety_of_a_case_is_that_of_the_stress_below_hertz(profile: cs.HardnessProfile) -> None:
    """By Johnson (1985), eqs. 4.46, at many depths on the axis, where the stress is largest."""
    body = replace(STEEL, hardness_profile=profile)
    outputs = (cs.SubsurfaceStress(),)
    scene = cs.Scene(cs.LineLoad("800 N/mm"), (body, STEEL), (cs.Cylinder("10 mm"),), outputs=outputs)
    hertz, z = scene.hertz, np.geomspace(1e-6, 3e-3, 20001)
    t = z / hertz.half_width
    root = np.sqrt(1 + t * t)
    across, down = 2 * t - (1 + 2 * t * t) / root, -1 / root
    along = 0.3 * (across + down)
    square = (across - down) ** 2 + (down - along) ** 2 + (along - across) ** 2
    safety = profile.yield_stress(z) / (hertz.peak_pressure * np.sqrt(square / 2))
    numbers = cs.solve(scene, error=0.02).quantities
    found, depth = numbers["safety_factor"], numbers["safety_factor_depth"]
    assert abs(found.value - safety.min()) <= found.bound < 0.1 * found.value
    assert abs(depth.value - z[safety.argmin()]) <= depth.bound < 0.4 * depth.value
    said = any("von Mises" in text for text in cs.solve(replace(scene, outputs=())).error.warnings)
    assert said == (found.value < 1)

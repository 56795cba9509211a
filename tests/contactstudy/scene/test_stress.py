from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactstudy as cs
from contactstudy.domain.grid import across_and_along
from contactstudy.elasticity.kernels.stress_cell import COMPONENTS, stress_cell
from contactstudy.elasticity.kernels.stress_periodic import (
    stress_cell_doubly_periodic,
    stress_cell_periodic,
)
from contactstudy.scene.solids.stress_model import HalfSpaceStress
from contactstudy.scene.stress import SubsurfaceStressOperator, von_mises
from tests.conftest import STEEL, LineContact
from tests.contactstudy.elasticity.test_convolution import PADDINGS

NU, EXACT = 0.3, cs.ExactPeriodicity()
NAMES = list(COMPONENTS)


def seen(one: cs.Padding, count: int) -> list[tuple[int, int, int, float]]:
    """For each pair (field point, source), an offset in cells that counts, and how much."""
    pairs = [(i, j) for i in range(count) for j in range(count)]
    if isinstance(one, cs.ZeroPadding | cs.Superposition):
        return [(i, j, i - j + m * count, 1.0) for i, j in pairs for m in one.window]
    if isinstance(one, cs.ExactPeriodicity):
        return [(i, j, i - j, 1.0) for i, j in pairs]
    reach = (1 if isinstance(one, cs.DuplicatedPadding) else one.images + 0.5) * count
    offsets = [(i, j, i - j + m * count) for i, j in pairs for m in range(-len(one.window) - 1, 99)]
    return [(i, j, d, 1.0 if abs(d) < reach else 0.5) for i, j, d in offsets if abs(d) <= reach]


@pytest.mark.parametrize("padding", PADDINGS, ids=str)
def test_stress_is_the_sum_over_all_pairs(padding: cs.Padding | cs.Paddings) -> None:
    """Images at the end of a window, as far on one side as on the other, count half on each."""
    cells = (3, 4)
    grid, medium = cs.Grid(cells, (1.0, 0.7)), HalfSpaceStress(NU)
    operator = SubsurfaceStressOperator(grid, across_and_along(padding), medium, (0.15,))
    pressure = np.random.default_rng(1).random(cells)
    found = operator(pressure)[:, 0]
    (dx, dy), (width, period) = grid.cell_size, grid.extent
    exact_x, exact_y = (one.window is None for one in operator.paddings)
    across, along = (seen(one, count) for one, count in zip(operator.paddings, cells, strict=True))
    steps_x, steps_y = (sorted({d for _, _, d, _ in side}) for side in (across, along))
    x, y = np.array(steps_x) * dx, np.array(steps_y) * dy
    for number, component in enumerate(COMPONENTS.values()):
        if exact_x and exact_y:
            table = stress_cell_doubly_periodic(component, x, y, 0.15, dx, dy, width, period, NU)
        elif exact_x:
            turned = COMPONENTS[component.swapped]
            table = stress_cell_periodic(turned, y, x, 0.15, dy, dx, width, NU).T
        elif exact_y:
            table = stress_cell_periodic(component, x, y, 0.15, dx, dy, period, NU)
        else:
            table = stress_cell(component, x[:, None], y, 0.15, dx, dy, NU)
        left = np.zeros((*[cells[0]] * 2, len(steps_x)))
        right = np.zeros((*[cells[1]] * 2, len(steps_y)))
        for weights, side, steps in ((left, across, steps_x), (right, along, steps_y)):
            for i, j, d, fraction in side:
                weights[i, j, steps.index(d)] += fraction
        expected = np.einsum("ikd,jle,de,kl->ij", left, right, table, pressure, optimize=True)
        if all(one.wraps or len(one.window) > 1 for one in operator.paddings):
            # mean lateral strain is prevented, whatever the images (Johnson 1985, sect. 3.4)
            uniform = {"xx": -NU / (1 - NU), "yy": -NU / (1 - NU), "zz": -1.0}.get(NAMES[number], 0.0)
            expected += uniform * pressure.mean() - expected.mean()
        assert_allclose(found[number], expected, rtol=0, atol=2e-14)


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
        free = cs.ZeroPadding()
        operator = SubsurfaceStressOperator(grid, (free, free), HalfSpaceStress(NU), tuple(d * a for d in depths))
        pressure = hertz.pressure(np.hypot(grid.x[:, None], grid.y))
        stress = operator(pressure)[:, :, count // 2, count // 2]
        assert_allclose(stress[0], stress[1], rtol=0, atol=1e-13 * hertz.peak_pressure)
        assert_allclose(stress[3:], 0, atol=1e-13 * hertz.peak_pressure)
        errors.append(np.abs(stress[[0, 2]] - expected).max() / hertz.peak_pressure)
    assert errors[-1] < 1e-3
    assert errors[0] / errors[-1] > 4**1.5 / 1.5


def test_von_mises_is_its_definition() -> None:
    stress = np.random.default_rng(4).standard_normal((6, 3, 4))
    tensor = np.empty((3, 3, 3, 4))
    for number, name in enumerate(NAMES):
        i, j = ("xyz".index(axis) for axis in name)
        tensor[i, j] = tensor[j, i] = stress[number]
    deviator = tensor - np.einsum("kk...,ij->ij...", tensor, np.eye(3)) / 3
    expected = np.sqrt(1.5 * np.einsum("ij...,ij...->...", deviator, deviator))
    assert_allclose(von_mises(stress), expected, rtol=1e-14)


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

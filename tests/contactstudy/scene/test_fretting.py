from dataclasses import replace
from math import log, pi

import numpy as np
import pytest
from scipy.integrate import simpson

import contactstudy as cs
from tests.conftest import STEEL

MU = 0.3
# E* = 1, a load of 1 N/m and a half-width of 1 m
BODY = cs.HalfSpace(2 * (1 - 0.3**2), 0.3)
LINE = cs.Scene(cs.LineLoad(1.0), (BODY, BODY), (cs.Cylinder(pi / 4),))
P0 = LINE.hertz.peak_pressure
STRIP = cs.Grid((220, 1), (2.2, 1.0))
ROUGH = cs.Roughness(2e-7, hurst=0.8, roll_off=1e-4, cut_off=4e-5, seed=1)


def fretted(
    friction: cs.Fretting, grid: cs.Grid = STRIP, tolerance: float = 1e-7, scene: cs.Scene = LINE
) -> cs.Solution:
    return cs.solve(replace(scene, friction=friction), grid, cs.ExactPeriodicity(), tolerance=tolerance)


def energy_per_cycle(fraction: float) -> float:
    """Energy [J/m] of a cycle to a fraction of the largest force, by Masing's rule under Cattaneo's shear."""
    return MU**2 / pi * (4 * (1 - fraction) * log(1 - fraction) + 4 * fraction - 2 * fraction**2)


def test_shear_on_the_way_down_is_mindlin_and_deresiewicz() -> None:
    """At x = 0, 0.5, 0.7 and 0.9 half-widths, over mu p_0; the error is larger beside the stick-slip boundary."""
    known = {
        0.18: (0.36754447, 0.47872707, 0.71414284, 0.43588989),
        0.12: (0.26491106, 0.35912781, 0.56648201, 0.16411011),
        0.06: (0.15639885, 0.22991596, 0.39941003, -0.43588989),
        0.0: (0.04086452, 0.08831705, 0.20237230, -0.43588989),
        -0.09: (-0.14921583, -0.15787862, -0.22424489, -0.43588989),
        -0.18: (-0.36754447, -0.47872707, -0.71414284, -0.43588989),
    }
    found = fretted(cs.Fretting(MU, tuple(known)))
    assert found.status is cs.Status.CONVERGED
    errors = []
    for (force, values), shear in zip(known.items(), found.traction.shears, strict=True):
        assert shear.sum() * STRIP.cell_area == pytest.approx(force, abs=1e-9)
        sampled = np.interp((0, 0.5, 0.7, 0.9), STRIP.x, shear[0, :, 0] / (MU * P0))
        errors.append(np.abs(sampled - values).mean())
    assert np.mean(errors) < 1e-3


def test_the_loop_is_that_of_masing_s_rule_and_its_area_the_energy() -> None:
    force = 0.6 * MU
    answer = fretted(cs.Fretting.cycle(MU, force))
    assert "loop_force" not in answer.to_dataset()  # which takes further solves
    dataset = answer.dataset_to_draw()
    forces, slips = dataset["loop_force"].values, dataset["loop_slip"].values
    displacements = dataset["loop_displacement"].values
    assert forces[[0, len(forces) // 2, -1]] == pytest.approx([force, -force, force])
    # back from the reversal as on the first way, at twice the scale
    first = fretted(cs.Fretting(MU, ((force - forces[3]) / 2,))).traction.rigid_displacement[-1]
    assert displacements[0] - displacements[3] == pytest.approx(2 * first, rel=1e-5)
    for along in (slips, displacements):  # by Simpson's rule on each way, rough beside the reversal
        area = sum(simpson(forces[part], along[part]) for part in (slice(9), slice(8, None)))
        assert abs(area) == pytest.approx(energy_per_cycle(0.6), rel=2e-2)
    assert np.ptp(slips) < 0.3 * np.ptp(displacements)


@pytest.mark.parametrize("cells", [37, 211])
@pytest.mark.parametrize("fraction", [0.13, 0.86])
def test_energy_and_largest_slip_of_a_cycle_are_within_bounds(fraction: float, cells: int) -> None:
    """Against the closed forms; of a slip zone of one cell there is none."""
    grid = cs.Grid((cells, 1), (2.5, 1.0))
    found, stepped = (fretted(cs.Fretting.cycle(MU, fraction * MU, n), grid) for n in (1, 4))
    c = (1 - fraction) ** 0.5
    expected = {
        "energy_per_cycle": energy_per_cycle(fraction),
        "largest_slip": 4 * MU * P0 * (fraction**0.5 - c**2 * np.arccosh(1 / c)),
    }
    for name, value in expected.items():
        number = found.quantities[name]
        assert abs(number.value - value) <= number.bound
        assert stepped.quantities[name].value == pytest.approx(number.value, rel=1e-3)
        if fraction * cells > 20:
            assert number.bound < 0.4 * value


@pytest.mark.parametrize(
    ("forces", "cycle"),
    [
        ((0, 1, 0, -1, 0, 1), (2, 6)), ((1, -1, 1, 0), (1, 3)), ((1, 0, -1, 0), None), ((1, -1, 0.5), None),
    ],
)  # fmt: skip
def test_energy_of_a_cycle_is_that_of_the_last_whole_one(
    forces: tuple[float, ...], cycle: tuple[int, int] | None
) -> None:
    """Without a whole cycle, the energy is that lost so far, bounded by its changes from larger cells."""
    friction = cs.Fretting(MU, tuple(0.6 * MU * force for force in forces))
    found = fretted(friction, cs.Grid((40, 1), (2.2, 1.0)))
    assert found.traction.cycle == cycle
    assert ("energy_per_cycle" in found.quantities) == (cycle is not None)
    if cycle is None:
        energy = found.quantities["friction_energy"]
        finer = fretted(friction, cs.Grid((320, 1), (2.2, 1.0))).quantities["friction_energy"]
        assert abs(energy.value - finer.value) <= energy.bound < np.inf


def test_a_rough_contact_closes_its_loop() -> None:
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01), ROUGH))
    grid = cs.Grid((32, 32), (3.2e-4, 3.2e-4))
    forces = (1.8e4, -1.8e4, 1.8e4, -1.8e4, 1.8e4)
    once = fretted(cs.Fretting(MU, forces[:3]), grid, 1e-6, scene)
    twice = fretted(cs.Fretting(MU, forces), grid, 1e-6, scene)
    assert twice.status is cs.Status.CONVERGED
    np.testing.assert_allclose(twice.shear, once.shear, atol=1e-3 * once.shear.max())
    energy, again = (one.quantities["energy_per_cycle"].value for one in (once, twice))
    assert again == pytest.approx(energy, rel=1e-3)

from dataclasses import replace
from math import log, pi, sqrt

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


def fretted(friction: cs.Fretting, grid: cs.Grid = STRIP) -> cs.Solution:
    return cs.solve(replace(LINE, friction=friction), grid, cs.ExactPeriodicity(), tolerance=1e-7)


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


def test_stress_at_the_cusps_of_a_reversed_traction_is_within_its_bound() -> None:
    """Few cells do not show how far the stress rises at the surface, where slip begins."""
    friction = cs.Fretting(0.59, tuple(0.59 * force for force in (0.95, -0.12, 0.31)))
    scene = replace(LINE, friction=friction, outputs=(cs.SubsurfaceStress(),))
    coarse, fine = (
        cs.solve(scene, cs.Grid((cells, 1), (2.6, 1.0)), cs.ExactPeriodicity()).quantities for cells in (37, 370)
    )
    for name in ("largest_von_mises", "largest_shear_stress"):
        assert fine[name].position["z"] == 0
        assert abs(coarse[name].value - fine[name].value) <= coarse[name].bound


def test_slip_in_one_cell_has_no_bound() -> None:
    friction = cs.Fretting(MU, tuple(force * MU for force in (0.2, -0.14, -0.05, 0.08)))
    found = fretted(friction, cs.Grid((21, 1), (2.6, 1.0))).quantities
    assert found["largest_slip"].value
    assert "at most one cell wide" in found["largest_slip"].reason


# Fretting fatigue: a bulk stress in one body (Nowell & Hills 1987; Hills & Nowell 1994, sect. 9.3).
FRICTION, FORCE = 0.5, 2.5e4
ROLLER = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01),))


def pulled(law: object, cells: int = 128, **other: object) -> cs.Contact:
    grid = cs.Grid((cells, 1), (2.6 * ROLLER.hertz.half_width, 1e-3))
    return cs.solve(replace(ROLLER, friction=law, **other), grid, cs.ExactPeriodicity())


@pytest.mark.parametrize(("stress", "body"), [(5e7, 0), (5e7, 1)])
def test_a_bulk_stress_moves_the_stick_zone_as_in_closed_form(stress: float, body: int) -> None:
    found = pulled(cs.PartialSlip(FRICTION, FORCE, bulk_stress=stress, bulk_body=body), 256)
    hertz, x = found.scene.hertz, found.grid.x
    a, c = hertz.half_width, hertz.half_width * sqrt(0.5)
    limit = FRICTION * hertz.peak_pressure
    shift = (1 - 2 * body) * stress * a / (4 * limit)
    zones = [np.sqrt(np.maximum(r**2 - (x - at) ** 2, 0)) / a for r, at in ((a, 0.0), (c, shift))]
    expected = limit * (zones[0] - zones[1])
    assert np.abs(found.shear[0, :, 0] - expected).sum() < 2e-3 * expected.sum()
    assert x[found.stick[:, 0]].mean() == pytest.approx(shift, abs=found.grid.cell_size[0] / 2)


def test_no_bulk_stress_changes_nothing_and_a_reversed_one_mirrors_the_traction() -> None:
    law = cs.Fretting(FRICTION, (FORCE,))
    zero = replace(law, bulk_stresses=(0.0,), bulk_body=1)
    np.testing.assert_array_equal(pulled(zero).shear, pulled(law).shear)
    one, other = (pulled(replace(law, bulk_stresses=(s,))).shear[0] for s in (8e7, -8e7))
    np.testing.assert_allclose(one, other[::-1], atol=1e-6 * one.max())
    at_once = pulled(cs.PartialSlip(FRICTION, FORCE, bulk_stress=8e7))
    np.testing.assert_allclose(at_once.shear[0], one, atol=1e-6 * one.max())


def test_the_bulk_stress_adds_to_the_stress_of_its_body_alone() -> None:
    deep = cs.SubsurfaceStress((2e-5,)), cs.SubsurfaceStress((2e-5,), 1)
    both = [
        pulled(cs.Fretting(FRICTION, (0.0,), bulk_stresses=stresses), 32, outputs=deep) for stresses in (None, (1e6,))
    ]
    # the stresses by the traction of the one body and its reaction on the other cancel
    sums = [found.derived["stress"].values + found.derived["stress_1"].values for found in both]
    added = np.array([1e6, 0.3e6, 0.0, 0.0, 0.0, 0.0])[:, None, None, None]
    np.testing.assert_allclose(sums[1] - sums[0], added * np.ones_like(sums[0]), atol=10.0)
    assert np.abs(both[1].derived["stress_1"].values - both[0].derived["stress_1"].values).max() > 1e5


def test_a_loop_passes_the_states_of_a_bulk_stress_that_changes_with_the_force() -> None:
    loop = pulled(cs.Fretting(FRICTION, (FORCE,), bulk_stresses=(8e7,))).dataset_to_draw()
    middle = len(loop["loop_force"]) // 2
    half = pulled(cs.Fretting(FRICTION, (FORCE / 2,), bulk_stresses=(4e7,)))
    assert loop["loop_displacement"].values[middle] == pytest.approx(half.traction.rigid_displacement[-1], rel=1e-4)


def test_a_cycle_of_bulk_stress_alone_is_a_whole_one() -> None:
    def energy(law: cs.Fretting) -> float:
        return pulled(law).quantities["energy_per_cycle"].value

    weak, strong = (cs.Fretting.cycle(FRICTION, 0.0, bulk_stress=stress) for stress in (5e7, 1e8))
    twice = replace(strong, **{name: 2 * getattr(strong, name) for name in ("forces", "bulk_stresses")})
    assert energy(twice) == pytest.approx(energy(strong), rel=1e-6)
    assert energy(strong) > energy(weak)

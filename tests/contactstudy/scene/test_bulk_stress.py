"""Fretting fatigue: a bulk stress in one body (Nowell & Hills 1987; Hills & Nowell 1994, sect. 9.3)."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL

FRICTION, LOAD = 0.5, 1e5
FORCE = 0.5 * FRICTION * LOAD


def solved(law: object, cells: int = 128, **other: object) -> cs.Contact:
    scene = cs.Scene(cs.LineLoad(LOAD), (STEEL, STEEL), (cs.Cylinder(0.01),), friction=law, **other)
    grid = cs.Grid((cells, 1), (2.6 * scene.hertz.half_width, 1e-3))
    return cs.solve(scene, grid, cs.ExactPeriodicity())


@pytest.mark.parametrize(("stress", "body"), [(5e7, 0), (5e7, 1)])
def test_a_bulk_stress_moves_the_stick_zone_as_in_closed_form(stress: float, body: int) -> None:
    found = solved(cs.PartialSlip(FRICTION, FORCE, bulk_stress=stress, bulk_body=body), 256)
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
    np.testing.assert_array_equal(solved(zero).shear, solved(law).shear)
    one, other = (solved(replace(law, bulk_stresses=(s,))).shear[0] for s in (8e7, -8e7))
    np.testing.assert_allclose(one, other[::-1], atol=1e-6 * one.max())
    at_once = solved(cs.PartialSlip(FRICTION, FORCE, bulk_stress=8e7))
    np.testing.assert_allclose(at_once.shear[0], one, atol=1e-6 * one.max())


def test_a_large_bulk_stress_slips_in_both_directions_under_the_same_force() -> None:
    found = solved(cs.PartialSlip(FRICTION, FORCE, bulk_stress=2e9))
    assert found.status is cs.Status.CONVERGED
    assert found.shear[0].sum() * found.grid.cell_size[0] == pytest.approx(FORCE, rel=1e-6)
    slipping = (found.pressure > 0) & ~found.stick
    ratio = found.shear[0][slipping] / (FRICTION * found.pressure[slipping])
    assert np.allclose(np.abs(ratio), 1)
    # the first body is stretched: its right end slips forwards and is held back
    assert ratio[0] == pytest.approx(1)
    assert ratio[-1] == pytest.approx(-1)


def test_the_bulk_stress_adds_to_the_stress_of_its_body_alone() -> None:
    deep = cs.SubsurfaceStress((2e-5,)), cs.SubsurfaceStress((2e-5,), 1)
    both = [
        solved(cs.Fretting(FRICTION, (0.0,), bulk_stresses=stresses), 32, outputs=deep) for stresses in (None, (1e6,))
    ]
    # the stresses by the traction of the one body and its reaction on the other cancel
    sums = [found.derived["stress"].values + found.derived["stress_1"].values for found in both]
    added = np.array([1e6, 0.3e6, 0.0, 0.0, 0.0, 0.0])[:, None, None, None]
    np.testing.assert_allclose(sums[1] - sums[0], added * np.ones_like(sums[0]), atol=10.0)
    assert np.abs(both[1].derived["stress_1"].values - both[0].derived["stress_1"].values).max() > 1e5


def test_a_cycle_of_bulk_stress_alone_is_a_whole_one() -> None:
    def energy(law: cs.Fretting) -> float:
        return solved(law).quantities["energy_per_cycle"].value

    weak, strong = (cs.Fretting.cycle(FRICTION, 0.0, bulk_stress=stress) for stress in (5e7, 1e8))
    twice = replace(strong, **{name: 2 * getattr(strong, name) for name in ("forces", "bulk_stresses")})
    assert energy(twice) == pytest.approx(energy(strong), rel=1e-6)
    assert energy(strong) > energy(weak)

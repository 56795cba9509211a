"""Test the load on a whole roller."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.evolve import evolve
from tests.conftest import STEEL

LENGTH = 1e-3
ROLLER = (cs.Cylinder(0.01), cs.FiniteLength(LENGTH))
GRID = cs.Grid((48, 40), (4e-4, 1.25 * LENGTH))


def scene(load: cs.LineLoad | cs.TotalLoad, *shapes: cs.Shape) -> cs.Scene:
    return cs.Scene(load, (STEEL, STEEL), shapes or ROLLER)


def test_the_pressure_adds_up_to_the_total_load() -> None:
    solution = cs.solve(scene(cs.TotalLoad(100.0)), GRID, cs.ZeroPadding())
    assert solution.pressure.sum() * GRID.cell_area == pytest.approx(100.0, rel=1e-7)


def test_a_total_load_is_a_load_per_length_of_the_grid() -> None:
    total, line = (
        cs.solve(scene(load), GRID, cs.ZeroPadding())
        for load in (cs.TotalLoad(100.0), cs.LineLoad(100.0 / GRID.period))
    )
    scale = line.pressure.max()
    np.testing.assert_allclose(total.pressure, line.pressure, atol=1e-6 * scale)


def test_the_length_is_that_of_the_shortest_roller() -> None:
    load = scene(cs.TotalLoad(100.0), *ROLLER, cs.LundbergProfile(1e-6, 2e-6, 2 * LENGTH)).load
    assert load == cs.TotalLoad(100.0, length=LENGTH)
    assert load.largest == 100.0 / LENGTH


def test_a_roller_without_a_length_is_refused() -> None:
    with pytest.raises(
        cs.InvalidInput, match=r"Scene\.load is a TotalLoad.* give TotalLoad\.length"
    ):
        scene(cs.TotalLoad(100.0), cs.Cylinder(0.01))
    with pytest.raises(cs.InvalidInput, match=r"TotalLoad\.length is None"):
        _ = cs.TotalLoad(100.0).largest


def test_a_march_carries_the_total_load() -> None:
    worn = replace(scene(cs.TotalLoad(100.0)), wear=cs.Wear(1e-18, 1.0))
    evolution = evolve(worn, GRID, cs.ZeroPadding(), times=[0.0])
    assert evolution.pressure[-1].sum() * GRID.cell_area == pytest.approx(100.0, rel=1e-7)

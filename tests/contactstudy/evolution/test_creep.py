from math import pi
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.states.state_variables import retardation_weights
from contactstudy.evolution.time_stepper import Trajectory
from tests.contactstudy.evolution.creeping import EXACT, LOAD, RIGID, SOLID, evolved, pressures, rolling_cylinder

FLUID = cs.ViscoelasticHalfSpace(0.0, 0.0, ((1.0, 3.0),))
HALF = cs.ViscoelasticHalfSpace(0.8, 0.0, ((1.2, 0.4),))


def line(cells: int, width: float = 0.9) -> cs.Grid:
    return cs.Grid((cells, 1), (width, 1.0))


def half_width(found: Trajectory, number: int = -1) -> float:
    return np.count_nonzero(found.frames[number].pressure) * found.description.grid.cell_size[0] / 2


@pytest.mark.parametrize(
    ("body", "solids", "end", "steps", "grid", "width"),
    [
        (SOLID, (HALF, HALF), 2.0, 20, line(400), 0.151558473),  # by an independent integration
        (FLUID, (FLUID, RIGID), 9.0, 60, line(600, 1.2), 0.2),  # a^2 = 4 R P (1 + t / 3) / pi
    ],
    ids=["two solids", "Maxwell fluid"],
)
def test_a_held_load_spreads_as_lee_and_radok_have_it(
    body: cs.ViscoelasticHalfSpace, solids: Any, end: float, steps: int, grid: cs.Grid, width: float
) -> None:
    closed = cs.analytic.LeeRadok(LOAD, 1.0, body.equilibrium_modulus, body.relaxation, body.creep)
    scene = cs.Scene(cs.LineLoad(LOAD), solids, (cs.Cylinder(1.0),))
    found = evolved(scene, grid, np.linspace(0, end, steps + 1))
    exact = closed.pressure(grid.x, end)
    assert closed.half_width(end) == pytest.approx(width, rel=1e-8)
    assert half_width(found) == pytest.approx(width, abs=grid.cell_size[0])  # the contact ends in a cell
    assert found.frames[-1].peak_pressure == pytest.approx(exact.max(), rel=1e-3)
    # the edge law of the grid: 0.35 (dx / a)^1.5 is 6e-4, and some for the steps
    assert np.abs(found.frames[-1].pressure[:, 0] - exact).sum() / exact.sum() < 2e-3


def test_a_contact_falls_back_at_a_sudden_unloading_as_ting_has_it() -> None:
    """From P0 to 0.4 P0 at t = 1: a = 0.094359465 (Ting 1966), found to a cell."""
    history = cs.LoadHistory((0.0, 1.0, 1.0), (LOAD, LOAD, 0.4 * LOAD))
    found = evolved(rolling_cylinder(SOLID, history), line(800), [*np.linspace(0, 1, 21), 1.0])
    assert [(frame.time, frame.load) for frame in found.frames[-2:]] == [(1.0, LOAD), (1.0, 0.4 * LOAD)]
    assert half_width(found) == pytest.approx(0.094359465, abs=0.9 / 800)


def test_a_wave_in_full_contact_relaxes_by_itself() -> None:
    """Pressed flat, a wave carries ``E*(t) q / 2`` of its height: exact at any step, for one wave is linear."""
    grid, times = cs.Grid((64, 1), (1.0, 1.0)), np.linspace(0, 2, 201)
    body = cs.ViscoelasticHalfSpace(0.3, 0.2, ((0.5, 0.4), (0.2, 3.0)))
    scene = cs.Scene(cs.LineLoad(1.0), (body, RIGID), (cs.Waviness(1e-3, across=1.0, along=1e9),))
    found = evolved(scene, grid, times, padding=(EXACT, EXACT), tolerance=1e-11)
    wave = np.cos(2 * pi * grid.x) @ pressures(found)[:, :, 0].T
    relaxed = 0.3 + 0.5 * np.exp(-times / 0.4) + 0.2 * np.exp(-times / 3)
    # the step is a 40th of the shortest time: linear pressure is out by its square over 12
    np.testing.assert_allclose(wave / wave[0], relaxed, rtol=(0.01 / 0.4) ** 2 / 4)


def test_a_step_weighs_the_past_and_both_pressures_and_they_add_up() -> None:
    nodes, gauss = np.polynomial.legendre.leggauss(20)
    s = (nodes + 1) / 2
    for ratio in (0.0, 1e-12, 1e-4, 9.9e-4, 1.1e-3, 0.1, 1.0, 50.0):
        weights = retardation_weights(ratio)
        assert min(weights) >= 0
        assert sum(weights) == pytest.approx(1, rel=1e-15)
        if 0 < ratio < 10:  # int of the rising fraction of p under exp(-(1 - s) ratio) ratio
            assert weights[2] == pytest.approx((gauss / 2 * s * ratio * np.exp(-(1 - s) * ratio)).sum(), rel=1e-9)


def test_unloaded_bodies_recover_and_touch() -> None:
    history = cs.LoadHistory((0.0, 1.0, 1.0, 3.0), (LOAD, LOAD, 0.0, 0.0))
    found = evolved(rolling_cylinder(SOLID, history), line(128), [1.0, 3.0])
    after, later = found.frames
    assert after.pressure.max() == later.pressure.max() == after.gap.min() == later.gap.min() == 0
    # the groove that is left heals: the approach at which the cylinder touches falls
    assert later.gap[0, 0] > after.gap[0, 0]

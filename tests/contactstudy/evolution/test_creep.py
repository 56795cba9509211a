from dataclasses import replace
from math import pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.states.state_variables import retardation_weights
from contactstudy.evolution.trajectory import Trajectory
from tests.contactstudy.evolution.creeping import (
    LOAD,
    RIGID,
    SOLID,
    evolved,
    half_width,
    held_pressure,
    pressures,
    rolling_cylinder,
)

EXACT = cs.ExactPeriodicity()


def line(cells: int, width: float = 0.9) -> cs.Grid:
    return cs.Grid((cells, 1), (width, 1.0))


def width_of(found: Trajectory, number: int = -1) -> float:
    return np.count_nonzero(found.frames[number].pressure) * found.description.grid.cell_size[0] / 2


FLUID = cs.ViscoelasticHalfSpace(0.0, 0.0, ((1.0, 3.0),))


def test_the_closed_form_has_the_numbers_of_an_independent_integration() -> None:
    assert half_width(SOLID, 2.0) == pytest.approx(0.151558473, rel=1e-8)
    assert held_pressure(SOLID, 2.0, np.zeros(1))[0] == pytest.approx(0.031855429, rel=1e-7)
    # a^2 = 4 R P (1 + t / 3) / pi
    assert half_width(FLUID, 9.0) == pytest.approx(0.2)


HALF = cs.ViscoelasticHalfSpace(0.8, 0.0, ((1.2, 0.4),))


@pytest.mark.parametrize(
    ("body", "solids", "end", "steps", "grid", "off"),
    [
        (SOLID, (SOLID, RIGID), 2.0, 20, line(400), 2e-4),
        (SOLID, (HALF, HALF), 2.0, 20, line(400), 2e-4),
        (FLUID, (FLUID, RIGID), 9.0, 60, line(600, 1.2), 1e-3),
    ],
    ids=["solid", "two bodies", "Maxwell fluid"],
)
def test_a_held_load_spreads_as_lee_and_radok_have_it(
    body: cs.ViscoelasticHalfSpace,
    solids: tuple[cs.ViscoelasticHalfSpace, cs.HalfSpace],
    end: float,
    steps: int,
    grid: cs.Grid,
    off: float,
) -> None:
    scene = replace(rolling_cylinder(body), solids=solids)
    found = evolved(scene, grid, np.linspace(0, end, steps + 1))
    exact = held_pressure(body, end, grid.x)
    assert found.frames[-1].peak_pressure == pytest.approx(exact.max(), rel=off)
    # the contact ends in a cell
    assert width_of(found) == pytest.approx(half_width(body, end), abs=grid.cell_size[0])
    wrong = np.abs(found.frames[-1].pressure[:, 0] - exact).sum() / exact.sum()
    # the edge law of the grid: 0.35 (dx / a)^1.5 is 6e-4, and some for the steps
    assert wrong < 2e-3


def test_a_contact_falls_back_at_a_sudden_unloading_as_ting_has_it() -> None:
    """From P0 to 0.4 P0 at t = 1: a = 0.094359465 (Ting 1966), found to a cell."""
    history = cs.LoadHistory((0.0, 1.0, 1.0), (LOAD, LOAD, 0.4 * LOAD))
    grid = line(800)
    found = evolved(rolling_cylinder(SOLID, history), grid, [*np.linspace(0, 1, 21), 1.0])
    before, after = found.frames[-2:]
    assert (before.load, after.load) == (LOAD, 0.4 * LOAD)
    assert before.time == after.time == 1.0
    assert width_of(found, -2) == pytest.approx(half_width(SOLID, 1.0), abs=grid.cell_size[0])
    assert width_of(found) == pytest.approx(0.094359465, abs=grid.cell_size[0])


def test_a_sine_load_on_a_solid_with_two_times() -> None:
    """At t = 1.5, past the largest width: a = 0.121487781, p0 = 0.028086871; p0 errors known to be 1.2e-4."""
    body = cs.ViscoelasticHalfSpace(0.3, 0.0, ((0.5, 0.4), (0.2, 3.0)))
    scene = rolling_cylinder(body, cs.SineLoad(0.0, LOAD, frequency=0.25))
    grid = line(400)
    found = evolved(scene, grid, np.linspace(0, 1.5, 61)[1:])
    assert found.frames[-1].peak_pressure == pytest.approx(0.028086871, rel=3e-4)
    assert width_of(found) == pytest.approx(0.121487781, abs=grid.cell_size[0])
    widest = max(range(len(found.frames)), key=lambda number: width_of(found, number))
    assert found.times[widest] == pytest.approx(1.217635, abs=0.1)
    assert width_of(found, widest) == pytest.approx(0.129483507, abs=grid.cell_size[0])


def test_a_wave_in_full_contact_relaxes_by_itself() -> None:
    """Pressed flat, a wave carries ``E*(t) q / 2`` of its height: exact at any step, for one wave is linear."""
    grid = cs.Grid((64, 1), (1.0, 1.0))
    body = cs.ViscoelasticHalfSpace(0.3, 0.2, ((0.5, 0.4), (0.2, 3.0)))
    scene = cs.Scene(cs.LineLoad(1.0), (body, RIGID), (cs.Waviness(1e-3, across=1.0, along=1e9),))
    times = np.linspace(0, 2, 201)
    found = evolved(scene, grid, times, padding=(EXACT, EXACT), tolerance=1e-11)
    wave = np.cos(2 * pi * grid.x) @ pressures(found)[:, :, 0].T
    relaxed = 0.3 + 0.5 * np.exp(-times / 0.4) + 0.2 * np.exp(-times / 3)
    # the step is a 40th of the shortest time: linear pressure is out by its square over 12
    np.testing.assert_allclose(wave / wave[0], relaxed, rtol=(0.01 / 0.4) ** 2 / 4)


@pytest.mark.parametrize("ratio", [0.0, 1e-12, 1e-4, 9.9e-4, 1.1e-3, 0.1, 1.0, 50.0, 1e9])
def test_a_step_weighs_the_past_and_both_pressures_and_they_add_up(ratio: float) -> None:
    kept, before, after = retardation_weights(ratio)
    assert min(kept, before, after) >= 0
    assert kept + before + after == pytest.approx(1, rel=1e-15)
    nodes, gauss = np.polynomial.legendre.leggauss(20)
    if 0 < ratio < 10:  # int of the rising fraction of p under exp(-(1 - s) ratio) ratio
        s = (nodes + 1) / 2
        exact = (gauss / 2 * s * ratio * np.exp(-(1 - s) * ratio)).sum()
        assert after == pytest.approx(exact, rel=1e-9)


def test_unloaded_bodies_recover_and_touch() -> None:
    history = cs.LoadHistory((0.0, 1.0, 1.0, 3.0), (LOAD, LOAD, 0.0, 0.0))
    found = evolved(rolling_cylinder(SOLID, history), line(128), [1.0, 1.0, 3.0])
    assert found.status is cs.Status.CONVERGED
    before, after, later = found.frames
    assert before.pressure.max() > 0
    assert after.pressure.max() == later.pressure.max() == 0
    assert after.gap.min() == later.gap.min() == 0
    # the groove that is left heals: the approach at which the cylinder touches falls
    assert later.gap[0, 0] > after.gap[0, 0]

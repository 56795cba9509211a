from dataclasses import replace
from functools import partial
from math import inf, pi
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution import steady_rolling
from contactstudy.evolution.steady_rolling import solve_rolling
from contactstudy.solvers.solve import solve_with_mixing
from tests.contactstudy.evolution.creeping import EXACT, LOAD, RIGID, SOLID, rolling_cylinder

A, P = 0.1, 0.05  # Hertz's half-width and peak pressure for a sudden load
HALF = cs.ViscoelasticHalfSpace(0.8, 0.0, ((1.2, 0.4),))


def rolling(body: cs.ViscoelasticHalfSpace, speed: float) -> cs.Scene:
    return rolling_cylinder(body, rolling=cs.Rolling(speed))


def strip(cells: int, width: float = 0.6) -> cs.Grid:
    return cs.Grid((cells, 1), (width, 1.0))


@pytest.mark.parametrize("solids", [(SOLID, RIGID), (HALF, HALF)], ids=["one body", "two bodies"])
def test_a_rolling_cylinder_has_its_known_shift_and_pressure(solids: Any) -> None:
    """J1 / J0 = 1.5, v lambda = a: centroid 0.35338 a ahead, p_max = 0.7643 p_H, by two other solvers."""
    found = solve_rolling(replace(rolling(SOLID, A), solids=solids), strip(200), EXACT)
    assert found.solution.status is cs.Status.CONVERGED
    assert found.shift / A == pytest.approx(0.35338, abs=6e-5)
    assert found.solution.pressure.max() / P == pytest.approx(0.7643, abs=2e-4)
    # a cylinder of 1 m: the moment of its pressure does the work that is lost
    assert found.resistance_coefficient == pytest.approx(found.shift, abs=6e-5 * A)


@pytest.mark.parametrize(("speed", "modulus"), [(0.0, 0.4), (inf, 1.0)])
def test_at_no_speed_and_at_an_infinite_one_bodies_are_elastic(speed: float, modulus: float) -> None:
    found = solve_rolling(rolling(SOLID, speed), strip(128), EXACT)
    elastic = cs.solve(rolling_cylinder(cs.HalfSpace(modulus, 0.0)).problem(strip(128), EXACT))
    np.testing.assert_allclose(found.solution.pressure, elastic.pressure, atol=1e-6 * elastic.pressure.max())
    assert abs(found.shift) < 1e-6 * A


def test_a_soft_body_far_from_elastic_settles_by_mixing() -> None:
    """J1 / J0 = 9, where a plain lag diverges."""
    body = cs.ViscoelasticHalfSpace(0.1, 0.0, ((0.9, 0.1),))
    found = solve_rolling(rolling(body, A), strip(200, 1.0), EXACT)
    assert found.solution.status is cs.Status.CONVERGED


def test_the_last_change_of_the_pressure_is_part_of_its_error(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, grid = rolling(SOLID, A), strip(50)
    found, exact = (solve_rolling(scene, grid, EXACT, options=cs.SolveOptions(size)) for size in (1e-4, 1e-10))
    true = exact.solution.pressure
    error = np.abs(found.solution.pressure - true).sum() / true.sum()
    assert error <= found.error_estimate().l1.residual <= 2e-3
    monkeypatch.setattr(steady_rolling, "solve_with_mixing", partial(solve_with_mixing, max_outer=2))
    l1 = solve_rolling(scene, grid, EXACT, options=cs.SolveOptions(1e-4)).error_estimate().l1
    assert (l1.residual, l1.reason) == (inf, f"No bound: {cs.Status.NOT_CONVERGED}")


@pytest.mark.parametrize("speed", [0.02, 4.0])
def test_a_wave_in_full_contact_slides_against_the_complex_modulus(speed: float) -> None:
    """``p = q A / 2 E*(i q v)`` of a wave of height A: its size, and its lead over the heights.

    To (q dx)^2 / 24 and a few of it for the mean over cells: 64 to a wave.
    """
    grid, q, shape = strip(64, 1.0), 2 * pi, cs.Waviness(1e-3, across=1.0, along=1e9)
    body = cs.ViscoelasticHalfSpace(0.3, 0.0, ((0.5, 0.4), (0.2, 3.0)))
    scene = cs.Scene(cs.LineLoad(1.0), (body, RIGID), (shape,), rolling=cs.Rolling(speed))
    found = solve_rolling(scene, grid, (EXACT, EXACT), options=cs.SolveOptions(1e-11))
    wave, gap = np.exp(-1j * q * grid.x) @ np.hstack((found.solution.pressure, shape.gap(grid))) / 32
    turn = 1j * q * speed
    modulus = 0.3 + sum(e * turn * tau / (1 + turn * tau) for e, tau in body.relaxation)
    # what stands out presses, and pressure runs ahead of it, in the direction of motion
    assert abs(wave / (-q / 2 * np.conj(modulus) * gap) - 1) < 4 * (q / 64) ** 2 / 24


@pytest.mark.parametrize("waves", [0.0, 21.0])
def test_resistance_and_pressure_are_as_far_from_finer_cells_as_they_promise(waves: float) -> None:
    scene = rolling(SOLID, A)
    if waves:
        wavy = cs.Waviness(2e-4 / waves, across=0.6 / waves, phase=0.7)
        scene = replace(scene, shapes=(*scene.shapes, wavy))
    found, fine = (solve_rolling(scene, strip(cells), EXACT) for cells in (80, 640))
    resistance = cs.solve(scene, strip(80), EXACT).quantities["rolling_resistance"]
    wrong = abs(found.resistance_coefficient / fine.resistance_coefficient - 1)
    assert wrong <= resistance.relative_bound < 0.3
    means = fine.solution.pressure.reshape(80, 8, 1).mean(axis=1)
    error = np.abs(found.solution.pressure - means).sum() / means.sum()
    assert error <= found.error_estimate().l1.total < 6 * error


def test_rolling_under_a_load_that_changes_slowly_is_steady_at_each_instant() -> None:
    """An instant without load has no relative error."""
    load = cs.LoadHistory((0.0, 300.0, 500.0), (LOAD, 0.4 * LOAD, 0.0))
    scene, grid, times = replace(rolling(SOLID, A), load=load), strip(48), [0.0, 300.0, 500.0]
    found = cs.solve(scene, grid, EXACT, times=times)
    assert not found.frames[-1].pressure.any()
    for frame, part in zip(found.frames[:2], (1.0, 0.4), strict=True):
        alone = cs.solve(replace(scene, load=cs.LineLoad(part * LOAD)), grid, EXACT)
        np.testing.assert_allclose(frame.pressure, alone.pressure, atol=1e-9 * P)
        resistance = alone.quantities["rolling_resistance"].value
        assert frame.quantities["rolling_resistance"].value == pytest.approx(resistance)
    with pytest.raises(cs.InvalidInput, match=r"rolls by .* of its widths"):
        cs.solve(replace(scene, load=replace(load, times=(0.0, 1.0, 500.0))), grid, EXACT, times=times)


def test_a_smooth_slider_that_creeps_loses_nothing_on_a_rigid_track() -> None:
    """The contact stands still on it; a rigid slider on such a track loses what a rolling contact does."""
    rubber = replace(SOLID, poisson_ratio=0.5)
    slider, track, rolls = (
        solve_rolling(replace(rolling(rubber, A), friction=friction), strip(50), EXACT)
        for friction in (cs.Sliding(0.3, standing=0), cs.Sliding(0.3, standing=1), None)
    )
    assert slider.resistance_coefficient == 0
    assert abs(slider.shift) < 1e-12 * A
    assert track.resistance_coefficient == rolls.resistance_coefficient > 0

from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.rolling.steady_rolling import solve_rolling
from tests.contactstudy.evolution.creeping import RIGID, SOLID, rolling_cylinder

EXACT = cs.ExactPeriodicity()
A, P = 0.1, 0.05  # Hertz's half-width and peak pressure for a sudden load


def rolling(body: cs.ViscoelasticHalfSpace, speed: float) -> cs.Scene:
    return rolling_cylinder(body, rolling=cs.Rolling(speed))


HALF = cs.ViscoelasticHalfSpace(0.8, 0.0, ((1.2, 0.4),))


@pytest.mark.parametrize(
    ("solids", "cells", "shift"),
    [((SOLID, RIGID), 100, 2e-4), ((SOLID, RIGID), 200, 6e-5), ((HALF, HALF), 100, 2e-4)],
    ids=["coarse", "fine", "two bodies"],
)
def test_a_rolling_cylinder_has_its_known_shift_and_pressure(
    solids: tuple[cs.ViscoelasticHalfSpace, cs.HalfSpace], cells: int, shift: float
) -> None:
    """J1 / J0 = 1.5, v lambda = a: centroid 0.35338 a ahead, p_max = 0.7643 p_H, by two other solvers."""
    scene = replace(rolling(SOLID, A), solids=solids)
    found = solve_rolling(scene, cs.Grid((cells, 1), (0.6, 1.0)), EXACT)
    assert found.solution.status is cs.Status.CONVERGED
    assert found.lagged.change <= 1e-6
    assert found.shift / A == pytest.approx(0.35338, abs=shift)
    assert found.solution.pressure.max() / P == pytest.approx(0.7643, abs=2e-4)
    # a cylinder of 1 m: the moment of its pressure does the work that is lost
    assert found.resistance_coefficient == pytest.approx(found.shift, abs=shift * A)


@pytest.mark.parametrize(("speed", "peak"), [(0.0, 1 / 2.5**0.5), (inf, 1.0)])
def test_at_no_speed_and_at_an_infinite_one_bodies_are_elastic(speed: float, peak: float) -> None:
    grid = cs.Grid((128, 1), (0.6, 1.0))
    found = solve_rolling(rolling(SOLID, speed), grid, EXACT)
    assert found.lagged.outer_iterations == 1
    modulus = 1.0 if speed else 0.4
    scene = replace(rolling_cylinder(SOLID), solids=(cs.HalfSpace(modulus, 0.0), RIGID))
    elastic = cs.solve(scene.problem(grid, EXACT))
    np.testing.assert_allclose(found.solution.pressure, elastic.pressure, atol=1e-6 * elastic.pressure.max())
    assert found.solution.pressure.max() / P == pytest.approx(peak, rel=1e-3)
    assert abs(found.shift) < 1e-6 * A


def test_rolling_in_single_precision_ends_at_its_rounding() -> None:
    found = cs.solve(rolling(SOLID, A), cs.Grid((64, 1), (0.6, 1.0)), EXACT, precision="single")
    assert found.status is cs.Status.PRECISION_LIMIT
    assert 0 < found.error.l1.total < inf


def test_the_work_of_all_outer_iterations_is_counted() -> None:
    answer = cs.solve(rolling(SOLID, A), cs.Grid((50, 1), (0.6, 1.0)), EXACT)
    assert isinstance(answer, cs.Contact)
    assert "approach" not in answer.quantities  # which falls with the speed without limit
    assert answer.rolling is not None
    lagged = answer.rolling.lagged
    assert answer.counts["iterations"][0] == lagged.iterations > lagged.outer_iterations > 1
    assert answer.counts["convolutions"][0] == lagged.convolutions


def test_a_soft_body_far_from_elastic_settles_by_mixing() -> None:
    """J1 / J0 = 9, where a plain lag diverges."""
    body = cs.ViscoelasticHalfSpace(0.1, 0.0, ((0.9, 0.1),))
    found = solve_rolling(rolling(body, A), cs.Grid((200, 1), (1.0, 1.0)), EXACT, change=1e-8)
    assert found.solution.status is cs.Status.CONVERGED


@pytest.mark.parametrize("change", [1e-6, 1e-3])
def test_the_last_change_of_the_pressure_is_part_of_its_error(change: float) -> None:
    grid = cs.Grid((50, 1), (0.6, 1.0))
    found = solve_rolling(rolling(SOLID, A), grid, EXACT, change=change)
    exact = solve_rolling(rolling(SOLID, A), grid, EXACT, change=1e-10).solution.pressure
    error = np.abs(found.solution.pressure - exact).sum() / exact.sum()
    assert error <= found.error_estimate().l1.residual <= 2 * change
    few = solve_rolling(rolling(SOLID, A), grid, EXACT, change=change, max_outer=2)
    assert few.solution.residual > change
    l1 = few.error_estimate().l1
    assert (l1.residual, l1.reason) == (inf, f"No bound: {cs.Status.NOT_CONVERGED}")


@pytest.mark.parametrize("speed", [0.02, 0.3, 4.0])
def test_a_wave_in_full_contact_slides_against_the_complex_modulus(speed: float) -> None:
    """``p = q A / 2 E*(i q v)`` of a wave of height A: its size, and its lead over the heights.

    To (q dx)^2 / 24 and a few of it for the mean over cells: 64 to a wave.
    """
    grid = cs.Grid((64, 1), (1.0, 1.0))
    body = cs.ViscoelasticHalfSpace(0.3, 0.0, ((0.5, 0.4), (0.2, 3.0)))
    q, height = 2 * pi, 1e-3
    scene = cs.Scene(
        cs.LineLoad(1.0),
        (body, RIGID),
        (cs.Waviness(height, across=1.0, along=1e9),),
        rolling=cs.Rolling(speed),
    )
    found = solve_rolling(scene, grid, (EXACT, EXACT), options=cs.SolveOptions(1e-11), change=1e-9)
    wave = 2 * (np.exp(-1j * q * grid.x) @ found.solution.pressure[:, 0]) / 64
    gap = 2 * (np.exp(-1j * q * grid.x) @ scene.shapes[0].gap(grid)[:, 0]) / 64
    turn = 1j * q * speed
    modulus = 0.3 + sum(e * turn * tau / (1 + turn * tau) for e, tau in body.relaxation)
    # what stands out presses, and pressure runs ahead of it, in the direction of motion
    expected = -q / 2 * np.conj(modulus) * gap
    assert abs(wave / expected - 1) < 4 * (q / 64) ** 2 / 24


@pytest.mark.parametrize("waves", [0.0, 6.3, 21.0])
def test_resistance_and_pressure_are_as_far_from_finer_cells_as_they_promise(waves: float) -> None:
    scene, grid = rolling(SOLID, A), cs.Grid((80, 1), (0.6, 1.0))
    if waves:
        wavy = cs.Waviness(2e-4 / waves, across=0.6 / waves, phase=0.7)
        scene = replace(scene, shapes=(*scene.shapes, wavy))
    found = solve_rolling(scene, grid, EXACT)
    fine = solve_rolling(scene, cs.Grid((8 * 80, 1), grid.extent), EXACT)
    wrong = abs(found.resistance_coefficient / fine.resistance_coefficient - 1)
    assert wrong <= found.resistance_coefficient_error < 0.2
    means = fine.solution.pressure.reshape(80, 8, 1).mean(axis=1)
    error = np.abs(found.solution.pressure - means).sum() / means.sum()
    assert error <= found.error_estimate().l1.total < 6 * error


@pytest.mark.whole
def test_rolling_under_a_load_that_changes_slowly_is_steady_at_each_instant() -> None:
    """An instant without load has no relative error."""
    loads = 0.01 * pi / 4, 0.004 * pi / 4, 0.008 * pi / 4, 0.0
    load = cs.LoadHistory((0.0, 100.0, 300.0, 500.0), loads)
    scene, grid = replace(rolling(SOLID, A), load=load), cs.Grid((64, 1), (0.6, 1.0))
    times = [0.0, 100.0, 100.0, 200.0, 500.0]
    found = cs.solve(scene, grid, EXACT, times=times)
    assert isinstance(found, cs.Evolution)
    assert found.error.l1.total < 0.02
    *loaded, unloaded = found.frames
    assert (unloaded.pressure.any(), unloaded.problem.control.uniform(1)) == (False, 0)
    assert found.times.tolist() == times
    for frame, part in zip(loaded, (0.01, 0.004, 0.004, 0.006), strict=True):
        alone = cs.solve(replace(scene, load=cs.LineLoad(part * pi / 4)), grid, EXACT)
        np.testing.assert_allclose(frame.pressure, alone.pressure, atol=1e-9 * P)
        resistance = alone.quantities["rolling_resistance"].value
        assert frame.quantities["rolling_resistance"].value == pytest.approx(resistance)
    assert found.quantities["rolling_resistance"].position == {"time": 0.0}
    fast = replace(load, times=(0.0, 1.0, 3.0, 500.0))
    with pytest.raises(cs.InvalidInput, match=r"rolls by .* of its widths"):
        cs.solve(replace(scene, load=fast), grid, EXACT, times=[0.0, 3.0])


def test_a_smooth_slider_that_creeps_loses_nothing_on_a_rigid_track() -> None:
    """The contact stands still on it; a rigid slider on such a track loses what a rolling contact does."""
    rubber = replace(SOLID, poisson_ratio=0.5)
    grid = cs.Grid((50, 1), (0.6, 1.0))
    slider, track, rolls = (
        solve_rolling(replace(rolling(rubber, A), friction=friction), grid, EXACT)
        for friction in (cs.Sliding(0.3, standing=0), cs.Sliding(0.3, standing=1), None)
    )
    assert slider.resistance_coefficient == 0
    assert abs(slider.shift) < 1e-12 * A
    assert track.resistance_coefficient == rolls.resistance_coefficient > 0

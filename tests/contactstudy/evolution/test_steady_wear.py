from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL

EXACT, ACROSS_FREE = cs.ExactPeriodicity(), (cs.ZeroPadding(), cs.ExactPeriodicity())
RADIUS, LENGTH, AROUND, LOAD = 0.01, 4e-4, 0.06, 1e5
ROLLER = cs.Scene(
    cs.LineLoad(LOAD),
    (STEEL, STEEL),
    (cs.Cylinder(RADIUS), cs.Waviness(2e-7, across=1e9, along=LENGTH)),
    rolling=cs.Rolling(1.0),
    wear=cs.Wear(1e-15, 0.1, circumference=AROUND),
)
A, PEAK = ROLLER.hertz.half_width, ROLLER.hertz.peak_pressure


def depths(answer: cs.Evolution) -> np.ndarray:
    """Depth (time, x, y) [m]."""
    return np.stack([frame.state["wear_depth"].values for frame in answer.frames])


def test_a_wave_of_full_contact_decays_as_the_closed_form_over_the_circumference() -> None:
    """``p_q(t) = p_q(0) exp(-k V t (W / C) E* q / 2)``: Archard's law on the share of the circumference in contact."""
    width, shapes = 1e-3, (cs.Waviness(1e-8, across=1e9, along=LENGTH),)
    scene = replace(ROLLER, load=cs.LineLoad(5e4), shapes=shapes)
    rate = 1e-15 * 0.1 * width / AROUND * scene.contact_modulus * pi / LENGTH
    answer = cs.solve(scene, cs.Grid((4, 32), (width, LENGTH)), (EXACT, EXACT), times=(0.0, 1 / rate, 2 / rate))
    sizes = np.ptp(answer.pressure[:, 0], axis=1)
    # waves of a grid of 32 cells: the mean over a cell
    assert sizes[1:] / sizes[0] == pytest.approx(np.exp([-1.0, -2.0]), rel=5e-3)
    assert (np.ptp(depths(answer), axis=1) == 0).all()


def test_a_roller_wears_until_its_pressure_is_even_along_the_length() -> None:
    answer = cs.solve(ROLLER, cs.Grid((32, 8), (4e-4, LENGTH)), EXACT, times=(0.0, 1e3, 3e4))
    peaks = answer.pressure.max(axis=1)
    assert peaks[0].max() > 1.2 * PEAK
    assert peaks[-1] == pytest.approx(np.full(8, PEAK), rel=0.01)
    volume = answer.quantities["wear_volume"]
    assert volume.value == pytest.approx(1e-15 * 0.1 * 3e4 * LOAD, rel=1e-6)
    assert volume.bound < 0.01 * volume.value


def test_wear_begins_at_the_first_time_before_zero_and_else_at_zero() -> None:
    grid = cs.Grid((16, 4), (4e-4, LENGTH))
    early, late = (depths(cs.solve(ROLLER, grid, EXACT, times=times)) for times in ((-3e3, 0.0), (3e3,)))
    assert not early[0].any()
    for worn in (early[-1], late[-1]):
        assert worn.mean() == pytest.approx(1e-15 * 0.1 * 3e3 * LOAD / AROUND, rel=1e-6)


def test_a_drive_wears_by_its_creepage() -> None:
    """Frictional power over the coefficient of friction is pressure times slip: the creepage where all slides."""
    drive = cs.TractiveRolling(0.3, longitudinal=0.05, speed=2.0)
    driven = replace(ROLLER, rolling=None, friction=drive, wear=cs.Wear(1e-15, 0.0, circumference=AROUND))
    idle = replace(driven, friction=replace(drive, longitudinal=0.0))
    grid, times = cs.Grid((16, 4), (4e-4, LENGTH)), (0.0, 300.0, 3000.0)
    known, found, still = (cs.solve(scene, grid, ACROSS_FREE, times=times) for scene in (ROLLER, driven, idle))
    assert depths(found) == pytest.approx(depths(known), rel=0.01)
    volume = found.quantities["wear_volume"]
    assert abs(volume.value - known.quantities["wear_volume"].value) <= volume.bound < inf
    assert not depths(still).any()


def test_errors_by_steps_cover_the_change_by_shorter_ones() -> None:
    grid, times = cs.Grid((24, 8), (4e-4, LENGTH)), (0.0, 5e3)
    rough, fine = (cs.solve(ROLLER, grid, EXACT, times=cs.TimeSteps(times, error=error)) for error in (0.1, 1e-3))
    change = np.abs(rough.pressure[-1] - fine.pressure[-1])
    bounds = {name: parts.steps for name, parts in rough.frames[-1].error}
    assert change.sum() / fine.pressure[-1].sum() < bounds["l1"] < 0.1
    moved = abs(rough.pressure[-1].max() / fine.pressure[-1].max() - 1)
    assert max(moved, bounds["l1"]) <= bounds["peak_pressure"] < 0.1
    assert rough.frames[-1].quantities["rolling_resistance"].bound == 0  # elastic bodies roll without resistance
    edges = (rough.pressure[-1] > 0) ^ (fine.pressure[-1] > 0)
    assert edges.sum() / (fine.pressure[-1] > 0).sum() <= bounds["contact_area"] < 0.1


def test_a_film_that_vanishes_wears_like_the_dry_contact() -> None:
    """Ridges on a boundary film; the second body stands, and wears."""
    unit, speed = A**2 / RADIUS, 1e-5
    oil = cs.Lubricant(0.04, 1.47196014e-8, cs.Barus(), cs.ConstantDensity())
    ridges = ((0.015, 0.5, 0.3), (0.009, 0.31, 1.1), (0.006, 0.17, 2.0))
    waves = (cs.Waviness(height * unit, across=wave * A, phase=phase) for height, wave, phase in ridges)
    dry = replace(ROLLER, shapes=(cs.Cylinder(RADIUS), *waves), rolling=None, wear=cs.Wear(1e-17, 2 * speed))
    film = cs.Lubrication(oil, speed, slide_roll_ratio=2.0, boundary=cs.Boundary(0.004 * unit, 0.12))
    wet = replace(dry, lubrication=film, wear=cs.Wear(1e-17, 0.0, body=1))
    times = (0.0, 2e-3 * unit / (1e-17 * 2 * speed * PEAK))
    known, found = (
        cs.solve(scene, cs.Grid((40, 1), (4 * A, 1e-3)), EXACT, times=cs.TimeSteps(times, error=1e-3))
        for scene in (dry, wet)
    )
    assert found.frames[-1].wear_depth == pytest.approx(depths(known)[-1], abs=1e-5 * unit)
    assert found.frames[-1].wear_depth.max() > 2e-3 * unit
    # nothing has worn yet at the first instant
    first, last = (frame.error.l1.by_cause["steps"] for frame in found.frames)
    assert first == 0 < last < 1e-2

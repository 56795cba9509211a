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
GRID = cs.Grid((32, 8), (4e-4, LENGTH))
A, PEAK = ROLLER.hertz.half_width, ROLLER.hertz.peak_pressure


def worn(answer: cs.Evolution) -> np.ndarray:
    """Depth (time, x, y) [m]."""
    return np.stack([frame.state["wear_depth"].values for frame in answer.frames])


def test_a_wave_of_full_contact_decays_as_the_closed_form_over_the_circumference() -> None:
    """``p_q(t) = p_q(0) exp(-k V t (W / C) E* q / 2)``: Archard's law on the share of the circumference in contact."""
    width = 1e-3
    wave = cs.Waviness(1e-8, across=1e9, along=LENGTH)
    scene = replace(ROLLER, load=cs.LineLoad(5e4), shapes=(wave,))
    q, modulus = 2 * pi / LENGTH, scene.contact_modulus
    rate = 1e-15 * 0.1 * width / AROUND * modulus * q / 2
    answer = cs.solve(scene, cs.Grid((4, 32), (width, LENGTH)), (EXACT, EXACT), times=(0.0, 1 / rate, 2 / rate))
    sizes = np.ptp(answer.pressure[:, 0], axis=1)
    # waves of a grid of 32 cells: the mean over a cell
    assert sizes[1:] / sizes[0] == pytest.approx(np.exp([-1.0, -2.0]), rel=5e-3)
    assert (np.ptp(worn(answer), axis=1) == 0).all()


def test_a_roller_wears_until_its_pressure_is_even_along_the_length() -> None:
    answer = cs.solve(ROLLER, GRID, EXACT, times=(0.0, 1e3, 3e4))
    peaks = answer.pressure.max(axis=1)
    assert peaks[0].max() > 1.2 * PEAK
    assert peaks[-1] == pytest.approx(np.full(8, PEAK), rel=0.01)
    volume = answer.quantities["wear_volume"]
    assert volume.value == pytest.approx(1e-15 * 0.1 * 3e4 * LOAD, rel=1e-6)
    assert volume.bound < 0.01 * volume.value


def test_a_drive_that_slides_fully_wears_like_a_roller_that_slides_as_fast() -> None:
    """Frictional power over the coefficient of friction is pressure times slip: the creepage where all slides."""
    drive = cs.TractiveRolling(0.3, longitudinal=0.05, speed=2.0)
    driven = replace(ROLLER, rolling=None, friction=drive, wear=cs.Wear(1e-15, 0.0, circumference=AROUND))
    grid, times = cs.Grid((16, 4), GRID.extent), (0.0, 300.0, 3000.0)
    known, found = (cs.solve(scene, grid, ACROSS_FREE, times=times) for scene in (ROLLER, driven))
    assert worn(found) == pytest.approx(worn(known), rel=0.01)
    volume = found.quantities["wear_volume"]
    assert abs(volume.value - known.quantities["wear_volume"].value) <= volume.bound < inf
    for name in ("approach", "mean_gap"):
        bounds = [frame.quantities[name].bound for frame in found.frames]
        assert 0 < bounds[0] < inf == bounds[1] == bounds[2]
    assert "has crept, worn or yielded" in found.frames[1].quantities["approach"].reason


def test_a_gap_that_wears_evenly_has_no_bound_either() -> None:
    """In plane strain the pressure keeps its value, whatever the steps."""
    roller = replace(ROLLER, shapes=ROLLER.shapes[:1])
    found = cs.solve(roller, cs.Grid((24, 1), GRID.extent), EXACT, times=(0.0, 1e4, 3e4))
    gaps = [frame.quantities["mean_gap"].bound for frame in found.frames]
    assert 0 < gaps[0] < inf == gaps[1] == gaps[2]
    assert all(frame.error.l1.by_cause["steps"] < 1e-6 for frame in found.frames[1:])


def test_without_creepage_a_drive_does_not_wear() -> None:
    drive = cs.TractiveRolling(0.3, longitudinal=0.0)
    wear = cs.Wear(1e-13, 0.0, circumference=AROUND)
    scene = replace(ROLLER, rolling=None, friction=drive, wear=wear)
    assert not worn(cs.solve(scene, GRID, ACROSS_FREE, times=(0.0, 1e3))).any()


@pytest.mark.whole
def test_a_roller_that_creeps_wears_evenly_too() -> None:
    body = cs.ViscoelasticHalfSpace(105e9, 0.3, ((105e9, 1e-4),))
    scene = replace(ROLLER, solids=(body, body))
    grid, times = cs.Grid((32, 4), (4e-4, LENGTH)), cs.TimeSteps((0.0, 3e4), error=0.05)
    answer = cs.solve(scene, grid, EXACT, times=times)
    first, last = (np.ptp(pressure.sum(axis=0)) for pressure in answer.pressure)
    assert last < 0.02 * first
    assert answer.frames[-1].rolling.resistance_coefficient > 0


def test_errors_by_steps_cover_the_change_by_shorter_ones() -> None:
    grid, times = cs.Grid((24, 8), GRID.extent), (0.0, 5e3)
    rough, fine = (cs.solve(ROLLER, grid, EXACT, times=cs.TimeSteps(times, error=error)) for error in (0.1, 1e-3))
    change = np.abs(rough.pressure[-1] - fine.pressure[-1])
    bounds = {name: parts.steps for name, parts in rough.frames[-1].error}
    assert change.sum() / fine.pressure[-1].sum() < bounds["l1"] < 0.1
    # elastic bodies roll without resistance
    moved = abs(rough.pressure[-1].max() / fine.pressure[-1].max() - 1)
    assert max(moved, bounds["l1"]) <= bounds["peak_pressure"] < 0.1
    assert bounds["rolling_resistance"] == 0
    edges = (rough.pressure[-1] > 0) ^ (fine.pressure[-1] > 0)
    assert edges.sum() / (fine.pressure[-1] > 0).sum() <= bounds["contact_area"] < 0.1
    assert rough.counts["solves"][0] < fine.counts["solves"][0]


OIL = cs.Lubricant(0.04, 1.47196014e-8, cs.Barus(), cs.ConstantDensity())
UNIT = A**2 / RADIUS
RIDGES = tuple(
    cs.Waviness(0.03 * part * UNIT, across=wave * A, phase=phase)
    for part, wave, phase in ((0.5, 0.5, 0.3), (0.3, 0.31, 1.1), (0.2, 0.17, 2.0))
)


def on_film(speed: float) -> cs.Scene:
    """Ridges on a boundary film; the second body stands, and wears."""
    layer = cs.Boundary(0.004 * UNIT, 0.12)
    film = cs.Lubrication(OIL, speed, slide_roll_ratio=2.0, boundary=layer)
    shapes = (cs.Cylinder(RADIUS), *RIDGES)
    wear = cs.Wear(1e-17, 0.0, body=1)
    return replace(ROLLER, shapes=shapes, rolling=None, lubrication=film, wear=wear)


def test_a_film_that_vanishes_wears_like_the_dry_contact() -> None:
    speed, grid = 1e-5, cs.Grid((40, 1), (4 * A, 1e-3))
    times = (0.0, 2e-3 * UNIT / (1e-17 * 2 * speed * PEAK))
    found = cs.solve(on_film(speed), grid, EXACT, times=times)
    sliding = replace(on_film(speed), lubrication=None, wear=cs.Wear(1e-17, 2 * speed))
    dry = cs.solve(sliding, grid, EXACT, times=cs.TimeSteps(times, error=1e-3))
    assert found.frames[-1].wear_depth == pytest.approx(worn(dry)[-1], abs=1e-5 * UNIT)
    assert found.frames[-1].wear_depth.max() > 2e-3 * UNIT
    # nothing has worn yet at the first instant
    first, last = (frame.error.l1.by_cause["steps"] for frame in found.frames)
    assert first == 0 < last < 1e-2


@pytest.mark.whole
def test_asperities_wear_until_the_film_bears_the_load() -> None:
    speed = 0.04 * 0.13541667
    grid, time = cs.Grid((400, 1), (6 * A, 1e-3)), 0.1 * UNIT / (1e-17 * 2 * speed * PEAK)
    times = cs.TimeSteps((0.0, time, 2 * time), error=1e-2)
    answer = cs.solve(on_film(speed), grid, EXACT, times=times)
    assert answer.over_time("contact_load_fraction")[0] > 5e-4
    assert answer.over_time("contact_load_fraction")[1:] == pytest.approx([0, 0], abs=1e-5)
    deepest = [frame.wear_depth.max() for frame in answer.frames]
    assert deepest[2] == pytest.approx(deepest[1], rel=1e-3)
    assert deepest[2] > 1e-3 * UNIT
    assert answer.to_dataset().wear_depth.shape == (3, 400, 1)

from dataclasses import replace
from itertools import pairwise
from math import pi, sin
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL


@pytest.mark.parametrize("kind", [np.int16, np.float32])
def test_numbers_of_any_kind_are_kept_as_floats(kind: type) -> None:
    """Else an int16 would overflow in a formula, and a float32 round it."""
    assert type(cs.LineLoad(kind(10_000)).per_length) is float
    assert type(cs.Superposition(np.uint8(3)).images) is int
    assert cs.analytic.HertzLine(kind(100), kind(1), kind(1000)) == cs.analytic.HertzLine(100.0, 1.0, 1000.0)


def test_a_history_is_linear_jumps_and_is_held() -> None:
    load = cs.LoadHistory((2.0, 4.0, 4.0, 8.0), (1.0, 5.0, 2.0, 0.0))
    assert (load.start, load.end, load.largest) == (2.0, 8.0, 5.0)
    assert [load.at(t) for t in (1.9, 2.0, 3.0, 4.0, 5.0, 8.0, 9.0)] == [0, 1, 3, 2, 1.5, 0, 0]
    assert [load.before(t) for t in (2.0, 2.5, 4.0, 6.0, 8.0)] == [0, 2, 5, 1, 0]
    assert load.breaks(5.0) == (2.0, 4.0)
    assert load.breaks(8.0) == (2.0, 4.0, 8.0)
    assert load.mean(2.0, 4.0) == 3.0
    assert load.mean(4.0, 8.0) == 1.0


def test_a_sine_load_starts_at_its_phase_and_repeats_after_a_cycle() -> None:
    load = cs.SineLoad(3.0, 2.0, frequency=0.5, phase=pi / 6)
    assert (load.start, load.end, load.largest) == (0.0, 2.0, 5.0)
    assert load.at(0.0) == pytest.approx(4.0)
    assert load.at(2 / 3) == pytest.approx(3 + 2 * sin(5 * pi / 6))
    assert load.at(2.5) == pytest.approx(load.at(0.5))
    assert (load.before(0.0), load.at(-1e-9)) == (0.0, 0.0)
    assert load.before(1e-9) == pytest.approx(4.0)
    # never zero: it breaks nowhere
    assert load.breaks(10.0) == (0.0,)
    by_points = np.mean([load.at(t) for t in np.linspace(0.2, 1.1, 100_001)])
    # the ends count whole in the mean of the points: one in 1e5
    assert load.mean(0.2, 1.1) == pytest.approx(by_points, rel=1e-5)
    assert load.mean(0.7, 0.7) == load.at(0.7)


@pytest.mark.parametrize("phase", [0.0, -2.0, 7.0])
def test_a_sine_load_that_would_pull_breaks_where_it_reaches_and_leaves_zero(phase: float) -> None:
    load = cs.SineLoad(0.5, 1.0, frequency=0.25, phase=phase)
    breaks = load.breaks(9.0)
    # one half is met at -30 and 210 degrees of every cycle of four seconds
    angles = (angle + 2 * pi * turn for angle in (-pi / 6, 7 * pi / 6) for turn in range(-5, 6))
    known = sorted(time for angle in angles if 0 < (time := (angle - phase) / (2 * pi * 0.25)) < 9)
    assert breaks[0] == 0.0
    assert [time for time in breaks if 0 < time < 9] == pytest.approx(known)
    for before, after in pairwise((*breaks, 9.0)):
        values = [load.at(t) for t in np.linspace(before, after, 12)[1:-1]]
        # all of it bears, or none
        assert min(values, default=1.0) > 0 or max(values) == 0
        by_points = np.mean([load.at(t) for t in np.linspace(before, after, 2_001)])
        assert load.mean(before, after) == pytest.approx(by_points, rel=1e-3, abs=1e-6)


@pytest.mark.cases(3)
@pytest.mark.parametrize(
    ("load", "friction", "name"),
    [
        (cs.TotalLoad(1e3), cs.PartialSlip(0.3, total=150.0), "traction_coefficient"),
        (cs.LineLoad(1e5), cs.TractiveRolling(0.3, total=150.0), "traction_coefficient"),
        (cs.TotalLoad(1e3), cs.Fretting(0.3, (0.0, 1.5e4), times=(0.0, 1.0)), "final_traction_coefficient"),
    ],
)
def test_forces_of_a_roller_are_counted_on_its_length(load: Any, friction: Any, name: str) -> None:
    """On any grid that it ends in: total load, tangential force, energy and power."""
    roller = cs.Scene(load, (STEEL, STEEL), (cs.Cylinder(0.01), cs.FiniteLength(0.01)), friction=friction)
    short, long = (
        cs.solve(roller, cs.Grid((16, rows), (3.4e-4, rows * 5e-4)), cs.ZeroPadding(), tolerance=1e-6)
        for rows in (20, 30)
    )
    for numbers in (long.quantities, short.quantities):
        assert numbers[name].value == pytest.approx(0.15, rel=1e-6)
    for name in {"total_load", "energy_per_cycle", "friction_energy", "frictional_power"} & set(numbers):
        assert long.quantities[name].value == pytest.approx(numbers[name].value, rel=1e-2)
        assert "m-1" not in numbers[name].unit


def test_a_total_load_on_an_endless_roller_is_spread_over_its_length_at_any_period() -> None:
    load = cs.TotalLoad(1500.0, length=0.01)
    endless = cs.Scene(load, (STEEL, STEEL), (cs.Cylinder(0.005),))
    peak = replace(endless, load=cs.LineLoad(1.5e5)).hertz.peak_pressure
    for period in (2e-4, 2e-2):
        answer = cs.solve(endless, cs.Grid((48, 1), (4e-4, period)), cs.ExactPeriodicity())
        assert answer.quantities["peak_pressure"].value == pytest.approx(peak, rel=0.02)
        assert answer.quantities["contact_area"].unit == "m2 m-1"


def test_the_length_is_that_of_the_shortest_roller() -> None:
    shapes = cs.Cylinder(0.01), cs.FiniteLength(1e-3), cs.LundbergProfile(1e-6, 2e-6, 2e-3)
    roller = cs.Scene(cs.TotalLoad(100.0), (STEEL, STEEL), shapes)
    assert roller.largest_load == 1e5
    assert replace(roller, shapes=(*shapes, cs.FiniteLength(5e-4))).largest_load == 2e5


@pytest.mark.parametrize(
    "shape", [cs.Waviness(1e-7, across=3e-4), cs.Roughness(2e-7, 0.8, roll_off=3e-4, cut_off=1e-4, extent=(7e-4, 1e-3))]
)
def test_what_does_not_fit_a_width_that_wraps_is_refused(shape: Any) -> None:
    scene = cs.Scene(cs.LineLoad(1e4), (STEEL, STEEL), (shape,))
    grid, wraps = cs.Grid((64, 64), (1e-3, 1e-3)), cs.ExactPeriodicity()
    with pytest.raises(cs.InvalidInput, match=r"Scene.shapes\[0\] repeats across is"):
        scene.problem(grid, (wraps, wraps))
    scene.problem(grid, wraps)
    period = shape.length_scales.period_across
    scene.problem(cs.Grid((64, 64), (2 * period, 1e-3)), (wraps, wraps))


def test_heights_that_stand_still_in_a_rolling_contact_are_said_to_slide() -> None:
    rubber = cs.ViscoelasticHalfSpace(5e6, 0.45, ((1e7, 1e-2),))
    scene = cs.Scene(cs.LineLoad(1e3), (rubber, STEEL), (cs.Cylinder(0.01),), rolling=cs.Rolling(0.1))
    for waves, said in ((cs.Waviness(1e-6, along=1e-3), False), (cs.Waviness(1e-6, across=1e-3), True)):
        found = cs.solve(replace(scene, shapes=(*scene.shapes, waves)), cs.Grid((48, 8), (6e-3, 1e-3)))
        assert ("hysteretic sliding" in found.quantities["rolling_resistance"].label) == said
        assert any("stand still in the frame" in text for text in found.error.warnings) == said

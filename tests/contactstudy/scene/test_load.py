"""Loads that change in time, at instants where they are known."""

from itertools import pairwise
from math import asin, pi, sin

import numpy as np
import pytest

import contactstudy as cs


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


@pytest.mark.parametrize("phase", [0.0, 0.3, -2.0, 7.0, pi])
def test_a_sine_load_that_would_pull_breaks_where_it_reaches_and_leaves_zero(phase: float) -> None:
    load = cs.SineLoad(0.5, 1.0, frequency=0.25, phase=phase)
    breaks = load.breaks(9.0)
    # one half is met at -30 and 210 degrees of every cycle of four seconds
    known = {0.0}
    for angle in (-asin(0.5), pi + asin(0.5)):
        for turn in range(-5, 6):
            time = (angle + 2 * pi * turn - phase) / (2 * pi * 0.25)
            known |= {time} if 0 < time <= 9 else set()
    assert breaks[0] == 0.0
    inside = [time for time in breaks if 1e-9 < time < 9 - 1e-9]
    assert inside == pytest.approx(sorted(time for time in known if time > 1e-9))
    for before, after in pairwise((*breaks, 9.0)):
        values = [load.at(t) for t in np.linspace(before, after, 12)[1:-1]]
        # all of it bears, or none
        assert min(values, default=1.0) > 0 or max(values) == 0
        by_points = np.mean([load.at(t) for t in np.linspace(before, after, 20_001)])
        assert load.mean(before, after) == pytest.approx(by_points, rel=1e-4, abs=1e-6)


def test_a_zero_is_met_to_rounding() -> None:
    load = cs.SineLoad(1.0, 1.0, frequency=1.0)
    assert load.at(0.75) == 0.0
    assert cs.SineLoad(1.0, 1.0 - 1e-10, frequency=1.0).at(0.75) > 0


def test_a_sudden_load_is_there_from_its_start_on() -> None:
    load = cs.LoadHistory((2.0,), (3.0,))
    assert (load.largest, load.end, load.breaks(9.0)) == (3.0, 2.0, (2.0,))
    assert [load.at(t) for t in (1.9, 2.0, 2.1)] == [0, 3, 3]
    assert [load.before(t) for t in (1.9, 2.0, 2.1)] == [0, 0, 3]
    assert load.mean(2.0, 5.0) == 3.0

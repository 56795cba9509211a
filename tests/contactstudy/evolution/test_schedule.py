from math import pi

import pytest

import contactstudy as cs
from contactstudy.evolution.march import schedule
from contactstudy.evolution.time_steps import TimeSteps

LOAD = cs.LoadHistory(times=(0.0, 1.0, 1.0, 3.0), per_length=(0.0, 2.0, 5.0, 1.0))


def test_instants_are_as_many_as_asked_and_peaks_of_the_load_are_among_them() -> None:
    load = cs.LoadHistory((0.0, 0.9, 2.0, 2.9, 4.0), (0.0, 2.0, 1.0, 3.0, 0.0))
    assert TimeSteps(instants=9).instants_of(load) == [0, 0.5, 0.9, 1.5, 2, 2.5, 2.9, 3.5, 4]
    # two kinks are nearest to one instant, and one to the last: the larger load counts
    near = cs.LoadHistory((0.0, 0.4, 0.42, 0.9, 1.0), (0.0, 500.0, 100.0, 400.0, 300.0))
    assert TimeSteps(instants=5).instants_of(near) == [0, 0.25, 0.4, 0.9, 1]
    default = TimeSteps().instants_of(load)
    assert set(load.times) < set(default)
    assert len(default) == 41
    assert sorted(default) == default
    sine = cs.SineLoad(2.0, 1.0, 1.0, phase=pi / 7)
    instants = TimeSteps().instants_of(sine) or []
    assert [time for time in instants if sine.at(time) in (1.0, 3.0)] == pytest.approx([5 / 28, 19 / 28])


def test_instants_are_even_from_the_start_of_the_load_to_the_end() -> None:
    load = cs.LoadHistory((1.0, 3.0), (1.0, 2.0))
    assert TimeSteps(end=7.0, instants=4).instants_of(load) == [1, 3, 5, 7]
    assert TimeSteps(instants=2).instants_of(load) == [1, 3]
    assert TimeSteps(end=3.0, instants=2).instants_of() == [0, 3]
    assert TimeSteps(times=(2.0, 5.0)).instants_of(load) == (2, 5)
    # an error chooses its own, up to the end of the load
    assert TimeSteps(error=1e-3).instants_of(load) is None
    assert len(TimeSteps(error=1e-3, instants=13).instants_of(load) or []) == 13
    assert TimeSteps(error=1e-3, end=7.0, instants=2).instants_of(load) == [1, 7]


@pytest.mark.parametrize("times", [(0.0, 0.25, 0.5), (0.25, 0.25, 0.5), (0.5, 0.75, 0.75), (0.0, 0.0), (4.0,)])
def test_times_are_recorded_as_they_are_given(times: tuple[float, ...]) -> None:
    found = schedule(LOAD, times)
    assert [point.time for point in found for _ in range(point.times_recorded)] == list(times)


def test_a_load_without_an_end_needs_times() -> None:
    sudden = cs.LoadHistory((0.5,), (3.0,))
    with pytest.raises(cs.InvalidInput, match=r"Scene\.load has no end: give times"):
        schedule(sudden, None)
    (only,) = schedule(sudden, (0.5,))
    assert (only.before, only.after, only.is_discontinuity) == (0, 3, True)

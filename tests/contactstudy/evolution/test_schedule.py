"""The instants that an integration lands on, by hand."""

from itertools import pairwise
from math import nan

import pytest

import contactstudy as cs
from contactstudy.evolution.steps import Breakpoint, schedule, within_periods

LOAD = cs.LoadHistory(times=(0.0, 1.0, 1.0, 3.0), per_length=(0.0, 2.0, 5.0, 1.0))


def test_marks_are_breaks_of_the_load_and_what_is_recorded() -> None:
    found = schedule(LOAD, (0.5, 1.0, 1.0, 2.0))
    assert found == (
        Breakpoint(0.0, before=found[0].before, after=0.0, records=0, breaks=True),
        Breakpoint(0.5, before=1.0, after=1.0, records=1, breaks=False),
        Breakpoint(1.0, before=2.0, after=5.0, records=2, breaks=True),
        Breakpoint(2.0, before=3.0, after=3.0, records=1, breaks=False),
    )
    assert [point.jumps for point in found[1:]] == [False, True, False]


def test_without_times_a_march_goes_to_the_end_of_the_load() -> None:
    found = schedule(LOAD, None)
    assert [point.time for point in found] == [0.0, 1.0, 3.0]
    assert [point.records for point in found] == [0, 0, 0]
    assert found[-1].after == 1.0


def test_a_march_passes_the_breaks_of_the_load_up_to_its_last_time() -> None:
    assert [point.time for point in schedule(LOAD, (0.5, 2.5))] == [0, 0.5, 1, 2.5]
    assert [point.time for point in schedule(LOAD, (0.5,))] == [0, 0.5]


@pytest.mark.parametrize(
    "times", [(0.0, 0.25, 0.5), (0.25, 0.25, 0.5), (0.5, 0.75, 0.75), (0.0, 0.0), (4.0,)]
)
def test_times_are_recorded_as_they_are_given(times: tuple[float, ...]) -> None:
    found = schedule(LOAD, times)
    assert [point.time for point in found for _ in range(point.records)] == list(times)


@pytest.mark.parametrize(
    "times",
    [
        (),
        (0.5, 0.25),
        (0.5, 0.5, 0.5),
        (-0.25, 1.0),
        (-0.25,),
        (0.5, nan),
        ((0.5, 1.0), (1.5, 2.0)),
    ],
    ids=str,
)
def test_times_that_cannot_be_marched_through_are_refused(times: object) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^evolve\.times"):
        schedule(LOAD, times)  # type: ignore[arg-type]


def test_a_load_without_an_end_needs_times() -> None:
    sudden = cs.LoadHistory((0.5,), (3.0,))
    with pytest.raises(cs.InvalidInput, match=r"Scene\.load has no end: give times"):
        schedule(sudden, None)
    (only,) = schedule(sudden, (0.5,))
    assert (only.before, only.after, only.breaks) == (0, 3, True)


@pytest.mark.parametrize(("times", "steps"), [((2.0,), 16), ((0.1, 2.0), 17), ((0.1, 0.2), 2)])
def test_no_step_is_longer_than_a_quarter_of_the_period(
    times: tuple[float, ...], steps: int
) -> None:
    load = cs.SineLoad(300.0, 200.0, 2.0)
    found = within_periods(schedule(load, times), load)
    durations = [last.time - first.time for first, last in pairwise(found)]
    assert len(durations) == steps
    assert max(durations) <= 0.125 * (1 + 1e-9)
    assert [point.time for point in found if point.records] == list(times)
    for point in found[1:]:
        assert point.before == pytest.approx(load.at(point.time))


def test_a_load_that_does_not_repeat_keeps_its_steps() -> None:
    assert within_periods(schedule(LOAD, (0.5, 2.5)), LOAD) == schedule(LOAD, (0.5, 2.5))

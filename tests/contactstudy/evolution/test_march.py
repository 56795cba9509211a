from dataclasses import dataclass, replace
from math import exp, inf, nextafter, pi
from types import SimpleNamespace

import pytest

import contactstudy as cs
from contactstudy.evolution.march import Breakpoint, Control, March, MarchState, Method, Record, TimeSteps, schedule


def solved(status: cs.Status) -> SimpleNamespace:
    return SimpleNamespace(status=status, solves=2)


@dataclass(frozen=True, kw_only=True)
class Decay(MarchState):
    """The value of ``y' = -y`` by Heun's method, with the change by its correction; no solution after `last` [s]."""

    time: float = 0.0
    contacts: tuple[SimpleNamespace, ...] = (solved(cs.Status.CONVERGED),)
    value: float = 1.0
    last: float = inf


class Heun(Method[Decay, Record[Decay]]):
    def step(self, state: Decay, end: float) -> Decay:
        duration = end - state.time
        predicted = state.value * (1 - duration)
        after = state.value - duration / 2 * (state.value + predicted)
        if end > nextafter(state.last, inf):
            return replace(state, time=end, step_error=inf, contacts=(solved(cs.Status.NOT_FINITE),))
        return replace(state, time=end, value=after, step_error=abs(after - predicted))

    def recorded(self, record: Record[Decay], *, has_failed: bool) -> Record[Decay]:
        return record


def marched(
    start: Decay,
    *instants: float,
    error: float = 1e-4,
    longest: float = inf,
) -> list[Record[Decay]]:
    points = [Breakpoint(time, times_recorded=1) for time in instants]
    return March(Heun(), start, points, Control(error, 2, 2.0, longest)).run()


def test_steps_keep_to_their_error_and_the_longer_ones_tell_that_of_all() -> None:
    records = marched(Decay(), 0.0, 0.7, 2.0, error=1e-5)
    assert [record.state.time for record in records] == [0.0, 0.7, 2.0]
    assert all(record.state.step_error <= 1e-5 for record in records)
    # of second order: the error of the short steps is a third of the difference
    last, coarse = records[-1].state, records[-1].coarse
    assert abs(last.value - exp(-2.0)) == pytest.approx(abs(last.value - coarse.value) / 3, rel=0.2)


def test_work_and_outcomes_are_those_since_the_instant_before() -> None:
    first, second = marched(Decay(contacts=(solved(cs.Status.STALLED),)), 0.0, 2.0)
    assert (first.statuses, first.work) == ((cs.Status.STALLED,), {"solves": 2})
    # a pair takes three steps, or one where that is too long
    taken, rejected = (second.work[name] for name in ("steps", "rejected"))
    assert rejected > 0
    assert len(second.statuses) == 1.5 * taken
    assert 2 * (1.5 * taken + rejected) <= second.work["solves"] <= 2 * 3 * (taken / 2 + rejected)


def test_a_march_ends_with_a_step_that_has_no_solution_at_its_own_time() -> None:
    *_, last = marched(Decay(last=1.0), 0.5, 2.0)
    assert cs.Status.NOT_FINITE in last.statuses
    assert last.coarse is None
    assert last.state.time == pytest.approx(1.0, abs=1e-5)
    assert [record.state.step_error for record in marched(Decay(step_error=inf), 1.0)] == [inf]


class Summed(Heun):
    def accept(self, before: Decay, middle: Decay, after: tuple[Decay, Decay | None]) -> float:
        return abs(after[0].value - after[1].value)


def test_a_march_whose_error_of_all_steps_is_too_large_starts_again_with_shorter_ones() -> None:
    march = March(Summed(), Decay(), [Breakpoint(2.0, times_recorded=1)], Control(1e-2, 2, 2.0, allowed=1e-4))
    (last,) = march.run()
    assert march.position.total["restarts"] > 0
    assert last.work == march.position.total  # with that of the marches given up
    assert abs(last.state.value - exp(-2.0)) < 1e-4


def test_steps_are_no_longer_than_allowed() -> None:
    (last,) = marched(Decay(), 1.0, error=1e99, longest=0.2)
    assert 10 <= last.work["steps"] <= 16


def test_instants_are_even_and_peaks_of_the_load_are_among_them() -> None:
    load = cs.LoadHistory((0.0, 0.9, 2.0, 2.9, 4.0), (0.0, 2.0, 1.0, 3.0, 0.0))
    assert TimeSteps(instants=9).instants_of(load) == [0, 0.5, 0.9, 1.5, 2, 2.5, 2.9, 3.5, 4]
    # two kinks are nearest to one instant, and one to the last: the larger load counts
    near = cs.LoadHistory((0.0, 0.4, 0.42, 0.9, 1.0), (0.0, 500.0, 100.0, 400.0, 300.0))
    assert TimeSteps(instants=5).instants_of(near) == [0, 0.25, 0.4, 0.9, 1]
    sine = cs.SineLoad(2.0, 1.0, 1.0, phase=pi / 7)
    instants = TimeSteps().instants_of(sine)
    assert len(instants) == 41
    assert [time for time in instants if sine.at(time) in (1.0, 3.0)] == pytest.approx([5 / 28, 19 / 28])
    later = cs.LoadHistory((1.0, 3.0), (1.0, 2.0))
    assert TimeSteps(end=7.0, instants=4).instants_of(later) == [1, 3, 5, 7]


def test_times_are_recorded_as_they_are_given() -> None:
    load = cs.LoadHistory((0.0, 1.0, 1.0, 3.0), (0.0, 2.0, 5.0, 1.0))
    for times in ((0.25, 0.25, 0.5), (0.5, 0.75, 0.75), (4.0,)):
        assert [point.time for point in schedule(load, times) for _ in range(point.times_recorded)] == list(times)
    sudden = cs.LoadHistory((0.5,), (3.0,))
    (only,) = schedule(sudden, (0.5,))
    assert (only.before, only.after, only.is_discontinuity) == (0, 3, True)

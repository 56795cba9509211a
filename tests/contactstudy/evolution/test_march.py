from collections import Counter
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import exp, inf, nextafter
from typing import Any

import pytest

import contactstudy as cs
from contactstudy.evolution.march import Breakpoint, Control, March, Method, Record


@dataclass(frozen=True)
class Decay:
    """The value of ``y' = -y`` by Heun's method, with the change by its correction; no solution after `last` [s]."""

    time: float = 0.0
    value: float = 1.0
    change: float = 0.0
    last: float = inf
    statuses: tuple[cs.Status, ...] = (cs.Status.CONVERGED,)
    work: Counter[str] = field(default_factory=lambda: Counter(solves=2))


class Heun(Method[Decay]):
    def __init__(self) -> None:
        self.pairs: list[tuple[Decay, Decay | None]] = []

    def step(self, state: Decay, end: float) -> Decay:
        duration = end - state.time
        predicted = state.value * (1 - duration)
        after = state.value - duration / 2 * (state.value + predicted)
        found = replace(state, time=end, value=after, change=abs(after - predicted))
        failed = end > nextafter(state.last, inf)
        return replace(found, change=inf, statuses=(cs.Status.NOT_FINITE,)) if failed else found

    def accept(self, before: Decay, middle: Decay, after: tuple[Decay, Decay | None]) -> float:
        self.pairs.append(after)
        return 0.0


def marched(
    start: Decay, *instants: float, error: float = 1e-4, kinks: tuple[float, ...] = (), **named: Any
) -> tuple[tuple[Record[Decay], ...], Heun]:
    longest = named.pop("longest", inf)
    times = sorted((*instants, *kinks))
    points = [Breakpoint(time, times_recorded=int(time in instants)) for time in times]
    method = Heun()
    march = March(method, start, points, Control(error, 2, 2.0, longest), **named)
    return march.records(), method


@pytest.mark.parametrize("error", [1e-3, 1e-5])
def test_steps_keep_to_their_error_and_the_longer_ones_tell_that_of_all(error: float) -> None:
    records, method = marched(Decay(), 0.0, 0.7, 2.0, error=error)
    assert [record.state.time for record in records] == [0.0, 0.7, 2.0]
    assert 0 < max(fine.change for fine, _ in method.pairs) <= error
    # of second order: the error of the short steps is a third of the difference
    last, coarse = records[-1].state, records[-1].coarse
    assert coarse is not None
    assert abs(last.value - exp(-2.0)) == pytest.approx(abs(last.value - coarse.value) / 3, rel=0.2)


def test_work_and_outcomes_are_those_since_the_instant_before() -> None:
    (first, second), _ = marched(Decay(statuses=(cs.Status.STALLED,)), 0.0, 2.0)
    assert first.statuses == (cs.Status.STALLED,)
    assert first.work == {"solves": 2}
    # a pair takes three steps, or one where that is too long
    taken, rejected = (second.work[name] for name in ("steps", "rejected"))
    assert rejected > 0
    assert len(second.statuses) == 1.5 * taken
    assert 2 * (1.5 * taken + rejected) <= second.work["solves"] <= 2 * 3 * (taken / 2 + rejected)


def test_a_march_ends_with_a_step_that_has_no_solution_at_its_own_time() -> None:
    (*_, last), _ = marched(Decay(last=1.0), 0.5, 2.0)
    assert cs.Status.NOT_FINITE in last.statuses
    assert last.coarse is None
    assert last.state.time == pytest.approx(1.0, abs=1e-5)
    assert [record.state.change for record in marched(Decay(change=inf), 1.0)[0]] == [inf]


def test_every_pair_is_recorded_and_steps_end_at_kinks_and_are_no_longer_than_allowed() -> None:
    every, _ = marched(Decay(), 1.0, error=1e99, longest=0.2, kinks=(0.25,), recorded="pairs")
    times = [0.0, *(record.state.time for record in every)]
    assert {0.25, 1.0} <= set(times)
    assert max(b - a for a, b in pairwise(times)) <= 0.2 * (1 + 1e-9)
    assert len(marched(Decay(), 0.0, 1.0, kinks=(0.25,))[0]) == 2

from collections import Counter
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import exp, inf, nextafter

import pytest

import contactstudy as cs
from contactstudy.evolution.march import Record, march


@dataclass(frozen=True)
class Decay:
    """The value of ``y' = -y`` by Heun's method, with the change by its correction; no solution after `last` [s]."""

    time: float = 0.0
    value: float = 1.0
    change: float = 0.0
    last: float = inf
    status: cs.Status = cs.Status.CONVERGED
    work: Counter[str] = field(default_factory=lambda: Counter(solves=2))

    def step(self, duration: float) -> "Decay":
        predicted = self.value * (1 - duration)
        after = self.value - duration / 2 * (self.value + predicted)
        failed = self.time + duration > nextafter(self.last, inf)
        found = replace(self, time=self.time + duration, value=after, change=abs(after - predicted))
        return replace(found, change=inf, status=cs.Status.NOT_FINITE) if failed else found


def marched(
    start: Decay, *instants: float, error: float = 1e-4, **named: object
) -> list[Record[Decay]]:
    return march(start, Decay.step, instants, error, order=2, first=1.0, **named)  # type: ignore[arg-type]


@pytest.mark.parametrize("error", [1e-3, 1e-5])
def test_steps_keep_to_their_error_and_the_longer_ones_tell_that_of_all(error: float) -> None:
    pairs: list[tuple[Decay, Decay]] = []
    records = marched(Decay(), 0.0, 0.7, 2.0, error=error, compare=lambda *pair: pairs.append(pair))
    assert [record.time for record in records] == [0.0, 0.7, 2.0]
    assert 0 < max(fine.change for fine, _ in pairs) <= error
    # of second order: the error of the short steps is a third of the difference
    last = records[-1]
    difference = abs(last.state.value - last.coarse.value)
    assert abs(last.state.value - exp(-2.0)) == pytest.approx(difference / 3, rel=0.2)


def test_work_and_status_are_those_since_the_instant_before() -> None:
    first, second = marched(Decay(status=cs.Status.STALLED), 0.0, 2.0)
    assert (first.status, second.status) == (cs.Status.STALLED, cs.Status.STALLED)
    assert first.work == {"solves": 2}
    # a pair takes three steps, or one where that is too long
    taken, rejected = (second.work[name] for name in ("steps", "rejected"))
    assert rejected > 0
    assert 2 * (1.5 * taken + rejected) <= second.work["solves"] <= 2 * 3 * (taken / 2 + rejected)


def test_a_march_ends_with_a_step_that_has_no_solution_at_its_own_time() -> None:
    *_, last = marched(Decay(last=1.0), 0.5, 2.0)
    assert last.status is cs.Status.NOT_FINITE
    assert last.time == pytest.approx(1.0, abs=1e-5)
    assert [record.state.change for record in marched(Decay(change=inf), 1.0)] == [inf]


def test_every_pair_is_recorded_and_steps_end_at_kinks_and_are_no_longer_than_allowed() -> None:
    every = marched(Decay(), 0.0, 1.0, error=1e99, longest=0.1, kinks=(0.25,), every_pair=True)
    times = [record.time for record in every]
    assert {0.0, 0.25, 1.0} <= set(times)
    assert max(b - a for a, b in pairwise(times)) <= 0.2 * (1 + 1e-9)
    assert len(marched(Decay(), 0.0, 1.0, kinks=(0.25,))) == 2

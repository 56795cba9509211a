"""How cases are dealt out to the workers of a scheduler, and what becomes of batches that are lost."""

from collections import deque
from dataclasses import dataclass, field
from itertools import chain
from queue import SimpleQueue
from types import SimpleNamespace
from typing import Any

import distributed
import pytest

from contactstudy import InvalidInput
from studies.engine import cluster
from studies.engine.cluster import Cluster, _Flow
from studies.model.outcome import CaseStatus, Outcome
from tests.studies.engine.trouble import Trouble


@dataclass(eq=False)
class Future:
    status: str = "pending"
    outcomes: list[Outcome] = field(default_factory=list)
    error: Exception | None = None

    def exception(self) -> Exception | None:
        return self.error

    def result(self, timeout: float) -> list[Outcome]:
        assert 0 < timeout <= cluster.LAST
        return self.outcomes


class Flow(_Flow):
    """Of ``count`` cases, with a client that computes nothing."""

    def __init__(self, count: int, threads: int = 1, patience: float = 10.0) -> None:
        self.batches: list[int] = []
        self.found: dict[str, Outcome] = {}
        self.said: list[str] = []
        client: Any = SimpleNamespace(
            status="running", submit=self._submitted, nthreads=lambda: self.workers
        )
        # some that are sent already, and those that wait
        self.cluster = Cluster(0, "tcp://here:1", patience, self.said.append)
        self.cases = {str(n): Trouble(float(n)) for n in range(max(count, 100))}
        self.client, self.token, self.payload, self.outcomes = client, "", b"", SimpleQueue()
        self.finished = self.found.__setitem__
        self.size, self.threads = 1, threads
        self._waiting = deque(map(str, range(count)))
        self._open = set(self.cases)
        self._running = {}
        self._completed: Any = SimpleNamespace(add=lambda future: None)
        self._looked_at, self._idle_since = -1.0, 0.0
        self.workers: dict[str, int] = {}

    def _submitted(self, *given: Any, pure: bool) -> Future:
        assert not pure
        self.batches.append(len(given[4]))
        return Future()


def outcomes(count: int, seconds: float = 0.0) -> list[Outcome]:
    return [Outcome(CaseStatus.OK, seconds=seconds) for _ in range(count)]


def test_a_batch_is_twice_what_the_last_one_gave_back_in_time_and_each_thread_has_three() -> None:
    flow = Flow(1000, threads=2)
    flow._fill()
    assert flow.batches == [1] * 2 * cluster.AHEAD
    for names in list(flow._running.values()):
        flow._running = {Future("finished"): names}
        flow._take(next(iter(flow._running)), outcomes(1))
    assert flow.size == 2
    batch = Future("finished")
    flow._running = {batch: [str(n) for n in range(20, 60)]}
    flow._take(batch, outcomes(25))
    # what was not begun in time goes first
    assert flow.size == 50
    assert list(flow._waiting)[:15] == [str(n) for n in range(45, 60)]
    assert set(flow.found) == {str(n) for n in (*range(6), *range(20, 45))}


def test_a_batch_is_half_a_thread_s_share_of_what_is_left_and_no_more_than_the_largest() -> None:
    flow = Flow(1000, threads=2)
    flow.size = cluster.LARGEST
    flow._fill()
    # of 1000, 800, 600, 449, 336 and 251 cases, a quarter and one
    assert flow.batches == [cluster.LARGEST, cluster.LARGEST, 151, 113, 85, 63]
    assert len(flow._waiting) == 1000 - sum(flow.batches)
    flow.client.status = "connecting"
    flow._running.clear()
    flow._fill()
    assert len(flow.batches) == 6


def test_what_is_lost_is_the_first_to_be_sent_again_but_for_what_came_meanwhile() -> None:
    flow = Flow(2)
    done, cancelled, dead = Future("finished"), Future("cancelled"), Future("pending")
    flow._running = {done: ["7", "8"], cancelled: ["5", "6"], dead: ["3"]}
    flow.outcomes.put(("6", outcomes(1)[0]))
    flow._take_delivered()
    flow._take(done, outcomes(2))
    assert list(flow.found) == ["6", "7", "8"]
    flow._take(cancelled, None)
    assert list(flow._waiting) == ["5", "0", "1"]
    flow._take(dead, None)
    assert flow._running == {dead: ["3"]}
    flow._take(Future("finished"), outcomes(1))  # it was thought to be lost
    assert list(flow.found) == ["6", "7", "8"]


def test_cases_that_cannot_be_read_together_are_sent_one_by_one() -> None:
    flow = Flow(0)
    batch = Future("finished")
    flow._running = {batch: ["7", "8", "9"]}
    flow._take(batch, [])
    assert flow.batches == [1, 1, 1]
    assert flow.found == {}


def test_a_look_comes_every_second_and_finds_lost_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [50.0]
    monkeypatch.setattr(cluster, "monotonic", lambda: now[0])
    flow = Flow(1)
    flow.workers = {"one": 2, "two": 3}
    flow._running = {Future("lost"): ["4", "5"], Future("pending"): ["6"]}
    flow._look()
    assert (flow.threads, list(flow._waiting)) == (5, ["4", "5", "0"])
    flow.workers = {"one": 2}
    now[0] += 0.5 * cluster.LOOK
    flow._look()
    assert flow.threads == 5
    now[0] += 0.5 * cluster.LOOK
    flow._look()
    assert flow.threads == 2


def test_a_scheduler_without_workers_is_said_once_after_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [50.0]
    monkeypatch.setattr(cluster, "monotonic", lambda: now[0])
    flow = Flow(1, patience=10.0)
    flow.workers = {"one": 1}
    flow._look()
    flow.workers = {}
    for seconds, said in ((60.0, 0), (61.5, 1), (80.0, 1)):
        now[0] = seconds
        flow._look()
        assert (len(flow.said), flow.threads) == (said, 1)
    assert flow.said == ["waiting for workers of tcp://here:1"]
    flow.client.status = "closed"
    now[0] = 90.0
    with pytest.raises(InvalidInput, match=r"^Scheduler 'tcp://here:1' is lost: start it again"):
        flow._look()


def test_when_a_run_stops_what_workers_have_finished_is_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [50.0]
    monkeypatch.setattr(cluster, "monotonic", lambda: now[0])
    flow = Flow(0)
    pending = Future("pending", outcomes(1))
    flow._running = {
        Future("finished", outcomes(2)): ["3", "4"],
        pending: ["5"],
        Future("finished", outcomes(1)): ["6"],
    }
    flow.outcomes.put(("7", outcomes(1)[0]))
    flow._take_last()
    assert sorted(flow.found) == ["3", "4", "6", "7"]
    assert flow._running == {pending: ["5"]}


def test_of_a_batch_that_killed_its_workers_each_case_is_tried_alone() -> None:
    flow = Flow(9)
    killed = distributed.KilledWorker("batch", SimpleNamespace(address="tcp://there:2"), 3)
    future = Future("error", error=killed)
    flow._running = {future: ["3", "4"]}
    flow._take(future, None)
    assert flow.batches == [1, 1]
    assert sorted(chain.from_iterable(flow._running.values())) == ["3", "4"]
    flow._running = {future: ["8"]}
    flow._take(future, None)
    assert flow.found["8"].case_status is CaseStatus.KILLED
    assert "the last tcp://there:2" in flow.found["8"].error
    other = Future("error", error=ImportError("studies"))
    flow._running = {other: ["1"]}
    with pytest.raises(InvalidInput, match="install the same version of contactstudy there"):
        flow._take(other, None)

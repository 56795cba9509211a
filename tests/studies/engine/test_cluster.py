"""What a run says of a scheduler without workers, one that is lost, and workers that die."""

import logging
from collections import deque
from contextlib import nullcontext
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import distributed
import pytest

from contactstudy import InvalidInput
from studies.engine import cluster
from studies.engine.cluster import DaskRun, client_of_dask
from studies.model.outcome import CaseStatus, Outcome
from tests.studies.engine.trouble import Trouble


@dataclass(eq=False)
class Future:
    status: str = "pending"
    error: Exception | None = None

    def exception(self) -> Exception | None:
        return self.error


class FakeRun(DaskRun):
    """Of ``count`` cases, with a client that computes nothing."""

    def __init__(self, count: int, threads: int = 1, patience: float = 10.0) -> None:
        self.batches: list[int] = []
        self.found: dict[str, Outcome] = {}
        self.said: list[str] = []
        client: Any = SimpleNamespace(
            status="running", submit=self._submitted, nthreads=lambda: self.workers
        )
        # some that are sent already, and those that wait
        self.address, self.patience, self.log = "tcp://here:1", patience, self.said.append
        self.cases = {str(n): Trouble(float(n)) for n in range(max(count, 100))}
        self._client, self._about = client, ("", b"", None)
        self.finished = self.found.__setitem__
        self.size, self.threads = 1, threads
        self._waiting = deque(map(str, range(count)))
        self._open, self._alone = set(self.cases), set()
        self._running = {}
        self._completed: Any = SimpleNamespace(add=lambda future: None)
        self._checked_at, self._idle_since = -1.0, 0.0
        self.workers: dict[str, int] = {}

    def _submitted(self, *given: Any, pure: bool) -> Future:
        assert not pure
        self.batches.append(len(given[-1]))
        return Future()


def test_a_scheduler_without_workers_is_said_after_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [50.0]
    monkeypatch.setattr(cluster, "monotonic", lambda: now[0])
    flow = FakeRun(1, patience=10.0)
    flow.workers = {"one": 1}
    flow._check_workers()
    flow.workers = {}
    for seconds, said in ((60.0, 0), (61.5, 1), (80.0, 1)):
        now[0] = seconds
        flow._check_workers()
        assert (len(flow.said), flow.threads) == (said, 1)
    assert flow.said == [
        "waiting for workers of tcp://here:1: start some, or stop the run and go on later"
    ]
    flow._client.status = "closed"
    now[0] = 90.0
    with pytest.raises(InvalidInput, match=r"^Scheduler 'tcp://here:1' is lost: start it again"):
        flow._check_workers()


def test_of_a_batch_that_killed_its_workers_each_case_is_tried_alone() -> None:
    flow = FakeRun(9)
    killed = distributed.KilledWorker("batch", SimpleNamespace(address="tcp://there:2"), 3)
    future = Future("error", error=killed)
    flow._running = {future: ["3", "4"]}
    flow._collect(future, None)
    flow.size = flow.threads = 8
    flow._submit_batches()
    assert flow.batches[:2] == [1, 1]
    assert list(flow._running.values())[:2] == [["3"], ["4"]]
    flow._running = {future: ["8"]}
    flow._collect(future, None)
    assert flow.found["8"].case_status is CaseStatus.KILLED
    assert "the last tcp://there:2" in flow.found["8"].error
    other = Future("error", error=ImportError("studies"))
    flow._running = {other: ["1"]}
    with pytest.raises(InvalidInput, match="install the same version of contactstudy there"):
        flow._collect(other, None)


def test_what_libraries_say_of_a_lost_connection_is_not_shown(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(distributed, "Client", lambda *_, **__: nullcontext())
    for library in ("distributed.core", "tornado.application"):
        with client_of_dask("tcp://here:1", 0, 1.0):
            logging.getLogger(library).error("a traceback")
        assert not caplog.records
        logging.getLogger(library).error("another one")
        assert len(caplog.records) == 1
        caplog.clear()

"""Cases through dask.distributed: on threads of this process by default, or on the workers of any scheduler.

Each thread of a dask worker drives a process of its own, since dask has no time limit for a task, and gives up other
tasks beside one that kills its worker.
"""

import logging
import secrets
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from time import monotonic
from typing import TYPE_CHECKING, Any, Self

import cloudpickle

from contactstudy import InvalidInput
from studies.engine.executors import packed
from studies.engine.stop import Stop
from studies.engine.workers.compute import failed
from studies.engine.workers.process import Worker
from studies.model.case import Computation
from studies.model.outcome import CaseStatus, Failure, Finished, Outcome, Work

if TYPE_CHECKING:
    from distributed import Client

MAX_BATCH = 200  # cases in a batch
BATCHES_AHEAD = 3  # batches for each thread of a worker, so that it does not wait for the next
CHECK_INTERVAL = 1.0  # seconds between two checks of the workers and of lost batches
POLL_INTERVAL = 0.05  # seconds between two checks for outcomes
STOP_TIMEOUT = 5.0  # seconds to collect finished batches when a run is stopped
LOOPBACK = "127.0.0.1:0"


class Workers:
    """Worker processes of this process, each taken by a thread for one batch at a time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._idle: list[Worker] = []
        self._all: list[Worker] = []

    @contextmanager
    def reserved(self, work: bytes) -> Iterator[Worker]:
        """Reserve a worker with the pickled `work` for a block: an idle one, or a new one."""
        with self._lock:
            if not self._idle:
                self._idle.append(Worker(work))
                self._all.append(self._idle[-1])
            worker = self._idle.pop()
        worker.set_work(work)
        try:
            yield worker
        finally:
            with self._lock:
                if not worker.has_ended:
                    self._idle.append(worker)

    def end(self) -> None:
        """End all processes at once."""
        with self._lock:
            ended, self._all, self._idle = self._all, [], []
        for worker in ended:
            worker.end()


# workers of each run of this process, by its token; and those of this dask worker for runs elsewhere
WORKERS_OF_RUN: dict[str, Workers] = {}
WORKERS_OF_DASK = Workers()


def compute_batch(token: str, work: bytes, batch: bytes, names: Sequence[str]) -> list[Outcome]:
    """Compute a batch of cases on a dask worker, in a process that is kept for the next batch.

    Returns the outcomes that were there after a quarter of a second; none where the run is over, or where the cases
    cannot be read together.
    """
    workers = WORKERS_OF_RUN.get(token) if token else WORKERS_OF_DASK
    if workers is None:  # the run in this process is over
        return []
    from distributed import get_worker

    address = "" if token else str(get_worker().address)
    with workers.reserved(work) as worker:
        return [replace(outcome, worker=address) for outcome in worker.run(batch, names)]


@dataclass
class Cluster:
    """An executor on dask, in a ``with`` statement.

    The worker processes are kept from one study to the next. If one dies, its case alone is lost; if a dask
    worker is lost, the scheduler gives its cases to another.

    Parameters
    ----------
    workers
        Threads of the dask started here, without an address.
    address
        Address of a dask scheduler; None starts one here.
    patience
        Seconds in which a lost scheduler may come back; it gets unfinished cases again.
    log
        Takes messages.
    """

    workers: int = 2
    address: str | None = None
    patience: float = 10.0
    log: Callable[[str], object] = lambda text: None
    processes: Workers = field(default_factory=Workers, init=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.processes.end()

    def run(
        self, cases: Mapping[str, Computation], work: Work, finished: Finished, stop: Stop
    ) -> None:
        """Compute `cases`: small ones in batches, large ones singly."""
        payload = packed(work)
        if not cases:
            return
        token = "" if self.address else secrets.token_hex(8)
        if token:
            WORKERS_OF_RUN[token] = self.processes
        try:
            with self._connection() if self.address else self._dask_here() as client:
                _ClusterRun(self, client, token, cases, payload, finished, stop).run()
        finally:
            WORKERS_OF_RUN.pop(token, None)

    @contextmanager
    def _dask_here(self) -> "Iterator[Client]":
        """Run dask in this process for a block, since an idle one takes 3 % of a core, and provide its client."""
        from distributed import Client, LocalCluster

        with (
            LocalCluster(
                n_workers=1,
                threads_per_worker=self.workers,
                processes=False,
                # without an address, they would listen to other machines
                dashboard_address=LOOPBACK,
                worker_dashboard_address=LOOPBACK,
                memory_limit=0,  # cases use the memory of their own processes
                silence_logs=logging.CRITICAL,
            ) as cluster,
            Client(cluster, set_as_default=False) as client,
        ):
            if find_spec("bokeh"):
                self.log(f"dask shows its work at {client.dashboard_link}")
            yield client

    @contextmanager
    def _connection(self) -> "Iterator[Client]":
        """Provide a client of the scheduler at the address for a block."""
        from distributed import Client

        # errors of the connection are reported here
        loggers = [logging.getLogger(name) for name in ("distributed", "tornado.application")]
        levels = [logger.level for logger in loggers]
        for logger in loggers:
            logger.setLevel(logging.CRITICAL)
        try:
            try:
                if ":" not in str(self.address):
                    raise ValueError(self.address)
                client = Client(self.address, timeout=self.patience, set_as_default=False)
            except (OSError, ValueError, TypeError, RuntimeError) as error:
                raise InvalidInput(
                    f"Scheduler {self.address!r} cannot be reached ({type(error).__name__}): give the address that "
                    "'dask scheduler' shows, such as tcp://127.0.0.1:8786."
                ) from None
            with client:
                yield client
        finally:
            for logger, level in zip(loggers, levels, strict=True):
                logger.setLevel(level)


@dataclass(eq=False)
class _ClusterRun:
    """A run on a cluster: keeps every thread busy with a few batches.

    A batch that takes too long comes back in part, and the next one is twice what came back.
    """

    cluster: Cluster
    client: "Client"
    token: str
    cases: Mapping[str, Computation]
    payload: bytes
    finished: Finished
    stop: Stop
    size: int = 1
    threads: int = 1

    def __post_init__(self) -> None:
        from distributed import as_completed

        self._waiting, self._open = deque(self.cases), set(self.cases)
        self._running: dict[Any, list[str]] = {}
        # an error of a batch is handled here and not raised, so that the others go on
        self._completed = as_completed(
            [], loop=self.client.loop, with_results=True, raise_errors=False
        )
        self._checked_at, self._idle_since = float("-inf"), monotonic()

    def run(self) -> None:
        """Compute all cases."""
        try:
            while self._open:
                self.stop.check()
                self._check_workers()
                self._submit_batches()
                completed = self._completed.next_batch(block=False)
                if not completed:
                    with self._completed.thread_condition:
                        self._completed.thread_condition.wait(timeout=POLL_INTERVAL)
                for future, result in completed:
                    self._collect(future, result)
        except BaseException:
            # batches that dask still holds are not computed, and further outcomes are not read
            WORKERS_OF_RUN.pop(self.token, None)
            self.cluster.processes.end()
            self._collect_last()
            raise
        finally:
            with suppress(Exception):
                self.client.cancel(list(self._running), force=True)

    def _report(self, name: str, outcome: Outcome) -> None:
        """Report the outcome of a case at its first arrival."""
        if name in self._open:
            self._open.discard(name)
            self.finished(name, outcome)

    def _collect(self, future: Any, result: Any) -> None:
        """Report a completed batch, and send its unfinished cases again."""
        names = self._running.pop(future, None)
        if names is None:  # it counted as lost, and was sent to another worker
            return
        if future.status == "finished" and isinstance(result, list):
            for name, outcome in zip(names, result, strict=False):
                self._report(name, outcome)
            if result:
                self.size = min(2 * len(result), MAX_BATCH)
                self._send_again(names[len(result) :])
            else:
                self._send_singly(names)  # which cannot be unpickled together
        elif future.status == "error":
            self._handle_failure(future, names)
        elif (
            future.status == "pending"
        ):  # its worker died with the result, and dask computes it again
            self._track(future, names)
        else:
            self._send_again(names)

    def _track(self, future: Any, names: list[str]) -> None:
        """Wait for a batch."""
        self._running[future] = names
        self._completed.add(future)

    def _send_singly(self, names: Sequence[str]) -> None:
        """Send cases in batches of one."""
        for name in names:
            self._submit([name])

    def _send_again(self, names: Sequence[str]) -> None:
        """Put unfinished cases at the front of those that wait."""
        self._waiting.extendleft(name for name in reversed(names) if name in self._open)

    def _collect_last(self) -> None:
        """Report what workers have finished by the time the run stops, unless the disk takes no more."""
        from distributed import wait

        until = monotonic() + STOP_TIMEOUT
        with suppress(Exception):
            if self.token:  # its processes have been ended, and its batches with them
                wait(list(self._running), timeout=STOP_TIMEOUT)
        for future, names in self._running.items():
            with suppress(Exception):
                if future.status == "finished" and monotonic() < until:
                    for name, outcome in zip(names, future.result(STOP_TIMEOUT), strict=False):
                        self._report(name, outcome)

    def _check_workers(self) -> None:
        """Count the workers, detect a lost connection, and send lost batches again."""
        if monotonic() < self._checked_at + CHECK_INTERVAL:
            return
        self._checked_at = monotonic()
        if self.client.status not in ("running", "connecting"):
            raise InvalidInput(
                f"Scheduler {self.cluster.address!r} is lost: start it again and run the same "
                "command, which goes on from what is stored."
            )
        for future in [key for key in self._running if key.status in ("cancelled", "lost")]:
            self._send_again(self._running.pop(future))
        if self.client.status == "running":
            with suppress(OSError, RuntimeError, TimeoutError):
                threads = sum(self.client.nthreads().values())
                self.threads = max(1, threads)
                if threads:
                    self._idle_since = monotonic()
                elif monotonic() > self._idle_since + self.cluster.patience:
                    self.cluster.log(
                        f"waiting for workers of {self.cluster.address}: start some, or stop the run and go on later"
                    )
                    self._idle_since = float("inf")

    def _submit_batches(self) -> None:
        """Submit batches until each thread has a few in its queue."""
        while (
            self.client.status == "running"
            and self._waiting
            and len(self._running) < BATCHES_AHEAD * self.threads
        ):
            part = len(self._waiting) // (2 * self.threads) + 1
            size = min(self.size, part, len(self._waiting))
            self._submit([self._waiting.popleft() for _ in range(size)])

    def _submit(self, names: list[str]) -> None:
        """Send one batch, pickled together: a class of a study file is then written once, not with every case."""
        try:
            batch = cloudpickle.dumps(tuple(self.cases[name] for name in names))
        except Exception as error:  # noqa: BLE001 (a study's class may do anything)
            if len(names) == 1:
                self._report(names[0], failed(error, "setup", 0.0))
            else:
                self._send_singly(names)
            return
        # impure: a case that is requested again is recomputed
        future = self.client.submit(
            compute_batch, self.token, self.payload, batch, names, pure=False
        )
        self._track(future, names)

    def _handle_failure(self, future: Any, names: list[str]) -> None:
        """Send the cases of a failed batch singly, to find the one that kills workers; raise errors that concern all."""
        from distributed import KilledWorker

        error = future.exception()
        if isinstance(error, InvalidInput):
            raise error
        if not isinstance(error, KilledWorker):
            raise InvalidInput(
                f"A dask worker cannot compute cases ({type(error).__name__}: {error}): install the same "
                "version of contactstudy there."
            )
        if len(names) > 1:  # one case killed the workers: sent singly, it is found
            self._send_singly(names)
            return
        sentence = f"Killed: workers died while they held it, the last {error.last_worker.address}"
        failure = Failure("Killed", sentence, "unknown")
        self._report(names[0], Outcome(CaseStatus.KILLED, {}, failure))

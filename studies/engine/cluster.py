"""Cases through dask.distributed: on threads of this process by default, or on the workers of any scheduler.

Each thread of a dask worker drives a process of its own, since dask has no time limit for a task, and gives up other
tasks beside one that kills its worker.
"""

import logging
import secrets
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from time import monotonic
from typing import TYPE_CHECKING, Any

import cloudpickle

from contactstudy import InvalidInput
from studies.engine.workers.compute import failed
from studies.engine.workers.process import SupervisedProcess, pickled_settings
from studies.model.case import Computation
from studies.model.outcome import CaseStatus, Failure, OnFinished, Outcome, RunSettings
from studies.model.plain_text import Log
from studies.store.stop import Stop

if TYPE_CHECKING:
    from distributed import Client

MAX_BATCH = 200  # cases in a batch
BATCHES_AHEAD = 3  # batches for each thread of a worker, so that it does not wait for the next
CHECK_INTERVAL = 1.0  # seconds between two checks of the workers and of lost batches
POLL_INTERVAL = 0.05  # seconds between two checks for outcomes
STOP_TIMEOUT = 5.0  # seconds to collect finished batches when a run is stopped
LOOPBACK = "127.0.0.1:0"


# processes of each run that this process supervises, and the one that the present thread keeps
PROCESSES_OF_RUNS: dict[str, list[SupervisedProcess]] = {}
THREAD = threading.local()


def compute_batch(
    run: str, settings: bytes, limit: float | None, batch: bytes, names: Sequence[str]
) -> list[Outcome]:
    """Compute a batch of pickled cases on a thread of a dask worker, in a process that it keeps for the next batch.

    Returns the outcomes of the cases begun within a quarter of a second; none where the run is over, or where the
    cases cannot be unpickled together. A case takes at most `limit` [s]. The name of the run is empty where the
    scheduler is not in the process that started it.
    """
    from distributed import get_worker

    process: SupervisedProcess | None = getattr(THREAD, "process", None)
    if process is None or process.settings != settings or process.ended.is_set():
        if process is not None:
            process.end()
        process = THREAD.process = SupervisedProcess(settings)
        PROCESSES_OF_RUNS.get(run, []).append(process)
    if run and run not in PROCESSES_OF_RUNS:  # it is over
        process.end()
    address = "" if run else str(get_worker().address)
    return [replace(outcome, worker=address) for outcome in process.run(batch, names, limit)]


@contextmanager
def client_of_dask(address: str | None, threads: int, timeout: float) -> "Iterator[Client]":
    """Provide a client of the scheduler at an address for a block; without one, of a local cluster that ends with it."""
    from distributed import Client

    # an idle dask takes 3 % of a core
    local_cluster = {
        "n_workers": 1,
        "threads_per_worker": threads,
        "processes": False,
        # without an address, they would listen to other machines
        "dashboard_address": LOOPBACK,
        "worker_dashboard_address": LOOPBACK,
        "memory_limit": 0,  # cases use the memory of their own processes
    }
    # dask gives the logger of its client a level of its own
    with _quiet("distributed"), _quiet("distributed.client"), _quiet("tornado.application"):
        try:
            if address and ":" not in address:
                raise ValueError(address)
            arguments = {} if address else local_cluster
            client = Client(address, timeout=timeout, set_as_default=False, **arguments)
        except (OSError, ValueError, TypeError, RuntimeError) as error:
            raise InvalidInput(
                f"Scheduler {address!r} cannot be reached ({type(error).__name__}): give the address that "
                "'dask scheduler' shows, such as tcp://127.0.0.1:8786."
                if address
                else f"A dask cluster cannot be started here ({error}): give --workers 0."
            ) from None
        with client:
            yield client


@contextmanager
def _quiet(name: str) -> Iterator[None]:
    """Show no errors of a library's logger in a block, since those of the connection are reported here."""
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(level)


def end_processes(run: str) -> None:
    """End the processes of a run here at once; its batches that dask still holds are not computed."""
    for process in PROCESSES_OF_RUNS.pop(run, ()):
        process.end()


@dataclass(eq=False)
class DaskRun:
    """Computation of cases in worker processes: keeps every thread busy with a few batches.

    A batch that takes too long comes back in part, and the next one is twice what came back. If a process dies, its
    case alone is lost; if a dask worker is lost, the scheduler gives its cases to another. An error that `finished`
    raises ends the run and is raised here; batches that other threads had computed by then are still reported.

    Parameters
    ----------
    cases
        Cases by name.
    settings
        Settings of the run.
    finished
        Called with the name and the outcome of each case, one call at a time.
    stop
        Raises where a signal asks to stop.
    workers
        Processes that compute, where there is no address: dask has one worker then, with so many threads.
    address
        Address of a dask scheduler; None starts a local cluster.
    reconnect_timeout
        Seconds in which a lost scheduler may come back; it gets unfinished cases again.
    log
        Takes messages.
    """

    cases: Mapping[str, Computation]
    settings: RunSettings
    finished: OnFinished
    stop: Stop
    workers: int = 2
    address: str | None = None
    reconnect_timeout: float = 10.0
    log: Log = lambda text: None
    size: int = field(default=1, init=False)
    threads: int = field(default=1, init=False)

    def run(self) -> None:
        """Compute all cases."""
        name = "" if self.address else secrets.token_hex(8)
        self._arguments = name, pickled_settings(self.settings), self.settings.time_limit
        self._queue, self._unfinished, self._single = deque(self.cases), set(self.cases), set[str]()
        self._futures: dict[Any, list[str]] = {}
        self._checked_at, self._idle_since = float("-inf"), monotonic()
        PROCESSES_OF_RUNS[name] = []
        try:
            with client_of_dask(self.address, self.workers, self.reconnect_timeout) as self._client:
                if not self.address and find_spec("bokeh"):
                    self.log(f"the dask dashboard is at {self._client.dashboard_link}")
                self._compute_all()
        finally:
            end_processes(name)

    def _compute_all(self) -> None:
        """Submit batches, and report what comes back, until no case is open."""
        from distributed import as_completed

        # an error of a batch is handled here and not raised, so that the others go on
        self._completed = as_completed(
            [], loop=self._client.loop, with_results=True, raise_errors=False
        )
        try:
            while self._unfinished:
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
            # further outcomes are not read
            self._collect_finished()
            raise
        finally:
            with suppress(Exception):
                self._client.cancel(list(self._futures), force=True)

    def _report(self, name: str, outcome: Outcome) -> None:
        """Report the outcome of a case at its first arrival."""
        if name in self._unfinished:
            self._unfinished.discard(name)
            self.finished(name, outcome)

    def _collect(self, future: Any, result: Any) -> None:
        """Report a completed batch, and send its unfinished cases again."""
        names = self._futures.pop(future, None)
        if names is None:  # it counted as lost, and was sent to another worker
            return
        if future.status == "finished" and isinstance(result, list):
            for name, outcome in zip(names, result, strict=False):
                self._report(name, outcome)
            if result:
                self.size = min(2 * len(result), MAX_BATCH)
                self._requeue(names[len(result) :])
            else:
                self._requeue_singly(names)  # they cannot be unpickled together
        elif future.status == "error":
            self._handle_failure(future, names)
        elif future.status == "pending":
            # its worker died with the result, and dask computes it again
            self._track(future, names)
        else:
            self._requeue(names)

    def _track(self, future: Any, names: list[str]) -> None:
        """Wait for a batch."""
        self._futures[future] = names
        self._completed.add(future)

    def _requeue(self, names: Sequence[str]) -> None:
        """Put the unfinished ones of these cases at the front of those that wait."""
        self._queue.extendleft(name for name in reversed(names) if name in self._unfinished)

    def _requeue_singly(self, names: Sequence[str]) -> None:
        """Put the unfinished ones of these cases at the front of those that wait, each to be sent in its own batch."""
        self._single.update(names)
        self._requeue(names)

    def _collect_finished(self) -> None:
        """Report what workers have finished by the time the run stops, unless the disk is full."""
        from distributed import wait

        until = monotonic() + STOP_TIMEOUT
        end_processes(self._arguments[0])
        if self.address is None:  # its batches have ended with them
            with suppress(Exception):
                wait(list(self._futures), timeout=STOP_TIMEOUT)
        for future, names in self._futures.items():
            with suppress(Exception):
                if future.status == "finished" and monotonic() < until:
                    for name, outcome in zip(names, future.result(STOP_TIMEOUT), strict=False):
                        self._report(name, outcome)

    def _check_workers(self) -> None:
        """Count the workers, detect a lost connection, and send lost batches again."""
        if monotonic() < self._checked_at + CHECK_INTERVAL:
            return
        self._checked_at = monotonic()
        if self._client.status not in ("running", "connecting"):
            raise InvalidInput(
                f"Scheduler {self.address!r} is lost: start it again and run the same "
                "command, which goes on from what is stored."
            )
        for future in [key for key in self._futures if key.status in ("cancelled", "lost")]:
            self._requeue(self._futures.pop(future))
        if self._client.status == "running":
            with suppress(OSError, RuntimeError, TimeoutError):
                threads = sum(self._client.nthreads().values())
                self.threads = max(1, threads)
                if threads:
                    self._idle_since = monotonic()
                elif monotonic() > self._idle_since + self.reconnect_timeout:
                    self.log(
                        f"waiting for workers of {self.address}: start some, or stop the run and go on later"
                    )
                    self._idle_since = float("inf")

    def _submit_batches(self) -> None:
        """Submit batches until each thread has a few in its queue."""
        while (
            self._client.status == "running"
            and self._queue
            and len(self._futures) < BATCHES_AHEAD * self.threads
        ):
            part = len(self._queue) // (2 * self.threads) + 1
            size = 1 if self._queue[0] in self._single else min(self.size, part)
            self._submit([self._queue.popleft() for _ in range(size)])

    def _submit(self, names: list[str]) -> None:
        """Send one batch, pickled together: a class of a study file is then written once, not with every case."""
        try:
            batch = cloudpickle.dumps(tuple(self.cases[name] for name in names))
        except Exception as error:  # noqa: BLE001 (a study's class may do anything)
            if len(names) == 1:
                self._report(names[0], failed(error, "setup"))
            self._requeue_singly(names)
            return
        # impure: a case that is requested again is recomputed
        future = self._client.submit(compute_batch, *self._arguments, batch, names, pure=False)
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
            self._requeue_singly(names)
            return
        sentence = f"Killed: workers died while they held it, the last {error.last_worker.address}"
        failure = Failure("Killed", sentence, "unknown")
        self._report(names[0], Outcome(CaseStatus.KILLED, {}, failure))

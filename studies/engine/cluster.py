"""Tasks through dask.distributed: on threads of this process by default, or on the workers of any scheduler.

A dask task is a batch of tasks. The thread that performs it drives one supervised process (`slot.py`), here and on
another machine alike, since dask has no time limit for a task, and gives up other tasks beside one that kills a worker.
"""

import logging
import secrets
import threading
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from queue import Empty, SimpleQueue
from time import monotonic
from typing import TYPE_CHECKING, Any

import cloudpickle

from contactstudy import InvalidInput
from studies.engine.compute import Task, ended, failed
from studies.engine.slot import Slot
from studies.model.outcome import CaseStatus, Outcome
from studies.model.plain_text import Log
from studies.store.stop import Stop, StopRun

if TYPE_CHECKING:
    from distributed import Client, Future

MAX_BATCH = 200  # tasks in a batch
BATCHES_AHEAD = 3  # batches for each thread of a worker, so that it does not wait for the next
CHECK_INTERVAL = 1.0  # seconds between two checks of the workers and of lost batches
POLL_INTERVAL = 0.05  # seconds between two checks whether the run is to stop
STOP_TIMEOUT = 5.0  # seconds to collect finished batches when a run is stopped
PATIENCE = 10.0  # seconds in which a scheduler answers, or comes back
LOOPBACK = "127.0.0.1:0"

# Slots of each run that this process drives.
SLOTS: dict[str, list[Slot]] = {}
# Holds the slot of the present thread.
THREAD = threading.local()
Done = tuple[Task, Outcome]


def perform_batch(run: str, settings: bytes, limit: float | None, tasks: bytes, count: int) -> list[Outcome]:
    """Return the outcomes of the first of `count` pickled tasks, on a thread of a dask worker.

    The name of the run is empty where the scheduler is not in the process that started it.
    """
    from distributed import get_worker

    slot: Slot | None = getattr(THREAD, "slot", None)
    if slot is None or slot.settings != settings or slot.ended.is_set():
        if slot is not None:
            slot.end()
        slot = THREAD.slot = Slot(settings, "" if run else f"worker {get_worker().address}")
        SLOTS.get(run, []).append(slot)
    if run and run not in SLOTS:  # the run has ended meanwhile
        slot.end()
    return slot.perform(tasks, count, limit)


def end_slots(run: str) -> None:
    """End the processes of a run here at once; its batches that dask still holds are not performed."""
    for slot in SLOTS.pop(run, ()):
        slot.end()


@contextmanager
def client_of_dask(address: str | None, threads: int) -> "Iterator[Client]":
    """Provide a client of the scheduler at an address for a block; without one, of a local cluster that ends with it."""
    from distributed import Client

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
            settings = {} if address else local_cluster
            client = Client(address, timeout=PATIENCE, set_as_default=False, **settings)
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


def perform_on_workers(
    tasks: Sequence[Task],
    settings: bytes,
    limit: float | None,
    stop: Stop,
    *,
    workers: int = 2,
    address: str | None = None,
    log: Log = print,
) -> Generator[Done, None, None]:
    """Yield every task with its outcome, as they come, from worker processes.

    A signal to stop is raised when what the processes here had performed by then has come.

    Parameters
    ----------
    tasks
        The tasks.
    settings
        What every task needs, pickled.
    limit
        Longest time of a task [s].
    stop
        Raises where a signal asks to stop.
    workers
        Processes, where there is no address.
    address
        Address of a dask scheduler; None starts a local cluster.
    log
        Takes messages.
    """
    run = "" if address else secrets.token_hex(8)
    SLOTS[run] = []
    try:
        with client_of_dask(address, workers) as client:
            if not address and find_spec("bokeh"):
                # the host in dask's own link may be one on which nothing listens
                port = client.dashboard_link.rpartition(":")[2]
                log(f"the dask dashboard is at http://127.0.0.1:{port}")
            batches = _Batches(client, tasks, (run, settings, limit), address, log)
            try:
                yield from batches.outcomes(stop)
            except StopRun:
                end_slots(run)
                yield from batches.finished()
                raise
            finally:
                batches.cancel()
    finally:
        end_slots(run)


class _Batches:
    """Batches of tasks: a few for each thread of the workers.

    A batch that takes too long comes back in part, and the next one is twice what came back. If a dask worker is lost,
    the scheduler gives its batches to another.
    """

    def __init__(
        self, client: "Client", tasks: Sequence[Task], arguments: tuple[str, bytes, float | None],
        address: str | None, log: Log,
    ) -> None:  # fmt: skip
        self.client, self.arguments, self.address, self.log = client, arguments, address, log
        self.queue, self.alone = deque(tasks), set[str]()
        self.batches: dict[Future[Any], list[Task]] = {}
        self.completed: SimpleQueue[Future[Any]] = SimpleQueue()
        self.size, self.threads = 1, 1
        self.checked, self.seen = float("-inf"), monotonic()

    def outcomes(self, stop: Stop) -> Iterator[Done]:
        """Yield every task with its outcome."""
        while self.queue or self.batches:
            stop.check()
            self._check_workers()
            yield from self._send_batches()
            with suppress(Empty):
                yield from self._collect(self.completed.get(timeout=POLL_INTERVAL))

    def finished(self) -> Iterator[Done]:
        """Yield what has been performed when a run is stopped."""
        from distributed import wait

        if self.address is None:  # on a cluster of its own, all batches have ended with their processes
            with suppress(Exception):
                wait(list(self.batches), timeout=STOP_TIMEOUT)
        until = monotonic() + STOP_TIMEOUT
        for future, tasks in self.batches.items():
            with suppress(Exception):
                if future.status == "finished" and monotonic() < until:
                    yield from zip(tasks, future.result(STOP_TIMEOUT), strict=False)

    def cancel(self) -> None:
        """Give up the batches that are not performed."""
        if self.client.status == "running":  # of a client that is closed, a call may wait for ever
            with suppress(Exception):
                self.client.cancel(list(self.batches), force=True)

    def _check_workers(self) -> None:
        """Count the workers, detect a lost connection, and send lost batches again."""
        if monotonic() < self.checked + CHECK_INTERVAL:
            return
        self.checked = monotonic()
        if self.client.status not in ("running", "connecting"):
            raise InvalidInput(
                f"Scheduler {self.address!r} is lost: start it again and run the same "
                "command, which goes on from what is stored."
            )
        for future in [of for of in self.batches if of.status in ("cancelled", "lost")]:
            self.queue.extendleft(reversed(self.batches.pop(future)))
        if self.client.status == "running":
            with suppress(OSError, RuntimeError, TimeoutError):
                threads = sum(self.client.nthreads().values())
                self.threads = max(1, threads)
                if threads:
                    self.seen = monotonic()
                elif monotonic() > self.seen + PATIENCE:
                    self.log(f"waiting for workers of {self.address}: start some, or stop the run and go on later")
                    self.seen = float("inf")

    def _send_batches(self) -> Iterator[Done]:
        """Send batches until each thread has a few in its queue; yield tasks that cannot be sent."""
        while self.client.status == "running" and self.queue and len(self.batches) < BATCHES_AHEAD * self.threads:
            share = len(self.queue) // (2 * self.threads) + 1
            size = 1 if self.queue[0].key in self.alone else min(self.size, share)
            tasks = [self.queue.popleft() for _ in range(size)]
            try:
                # pickled together, they hold the class of a study file once and not with every case
                pickled = cloudpickle.dumps(tasks)
            except Exception as error:  # noqa: BLE001 (a study's class may do anything)
                yield from self._alone(tasks, failed(error))
                continue
            # impure: a task that is requested again is performed again
            future = self.client.submit(perform_batch, *self.arguments, pickled, len(tasks), pure=False)
            self.batches[future] = tasks
            future.add_done_callback(self.completed.put)

    def _collect(self, future: "Future[Any]") -> Iterator[Done]:
        """Yield the outcomes of a completed batch, and send its other tasks again."""
        from distributed import KilledWorker

        tasks = self.batches.pop(future, None)
        if tasks is None:  # it counted as lost, and was sent again
            return
        if future.status == "error":
            error = future.exception()
            if isinstance(error, InvalidInput):
                raise error
            if not isinstance(error, KilledWorker):
                raise InvalidInput(
                    f"A dask worker cannot compute cases ({type(error).__name__}: {error}): install the same "
                    "version of contactstudy there."
                )
            sentence = f"workers died while they held it, the last {error.last_worker.address}"
            yield from self._alone(tasks, ended(CaseStatus.KILLED, "Killed", sentence, 0.0))
            return
        try:
            outcomes = future.result(timeout=PATIENCE)
        except Exception:  # noqa: BLE001 (the worker or the scheduler was lost with the result)
            self.queue.extendleft(reversed(tasks))
            return
        yield from zip(tasks, outcomes, strict=False)
        self.size = min(2 * len(outcomes) or 1, MAX_BATCH)
        self.queue.extendleft(reversed(tasks[len(outcomes) :]))
        if not outcomes:  # they cannot be unpickled together
            self.alone.update(task.key for task in tasks)

    def _alone(self, tasks: Sequence[Task], outcome: Outcome) -> Iterator[Done]:
        """Send tasks of which one is at fault again, each alone; yield one that was alone with its outcome."""
        if len(tasks) == 1:
            yield tasks[0], outcome
            return
        self.alone.update(task.key for task in tasks)
        self.queue.extendleft(reversed(tasks))

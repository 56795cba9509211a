"""Cases through dask.distributed: on threads of this process by default, or on the workers of any scheduler.

Each thread of a dask worker drives a supervised process of its own, since dask has no time limit for a task, and gives
up other tasks beside one that kills its worker.
"""

import logging
import secrets
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from importlib.util import find_spec
from queue import SimpleQueue
from time import monotonic
from typing import TYPE_CHECKING, Any, Self

import cloudpickle

from contactstudy import InvalidInput
from studies.engine.executors import packed
from studies.engine.stop import Stop
from studies.engine.workers.compute import failed
from studies.engine.workers.supervisor import WorkerSupervisor
from studies.model.case import Computation
from studies.model.outcome import CaseStatus, Failure, Finished, Outcome, Work
from studies.store.fingerprint import versions

if TYPE_CHECKING:
    from distributed import Client

BATCH = 0.25  # seconds of work in a batch of small cases
LARGEST = 200  # cases in a batch
AHEAD = 3  # batches for each thread of a worker, so that it does not wait for the next
LOOK = 1.0  # seconds between two checks of the workers and of lost batches
PAUSE = 0.05  # seconds between two checks for outcomes
LAST = 5.0  # seconds to collect finished batches when a run is stopped
LOOPBACK = "127.0.0.1:0"


class Supervisors:
    """Supervised processes of this process, each taken by a thread for one batch at a time.

    Parameters
    ----------
    deliver
        Takes the name and the outcome of each case at once, where the run is in this process.
    """

    def __init__(self, deliver: Callable[[str, Outcome], object] | None = None) -> None:
        self.deliver = deliver
        self._turn = threading.Lock()
        self._idle: list[WorkerSupervisor] = []
        self._all: list[WorkerSupervisor] = []

    @contextmanager
    def reserved(self, work: bytes) -> Iterator[WorkerSupervisor]:
        """Reserve a supervisor with the pickled `work` for a block: an idle one, or a new one."""
        with self._turn:
            if not self._idle:
                self._idle.append(WorkerSupervisor(work))
                self._all.append(self._idle[-1])
            supervisor = self._idle.pop()
        supervisor.set_work(work)
        try:
            yield supervisor
        finally:
            with self._turn:
                if not supervisor.has_ended:
                    self._idle.append(supervisor)

    def end(self) -> None:
        """End all processes at once."""
        with self._turn:
            ended, self._all, self._idle = self._all, [], []
        for supervisor in ended:
            supervisor.end()


# supervisors of each run of this process, by its token; and those of this dask worker for runs elsewhere
RUNS: dict[str, Supervisors] = {}
ELSEWHERE = Supervisors()


def compute_batch(
    token: str, work: bytes, batch: bytes, names: Sequence[str], expected: Mapping[str, str]
) -> list[Outcome]:
    """Compute a batch of cases on a dask worker, in a process that is kept for the next batch.

    Returns fewer outcomes than ``names`` where the run is over, or where the cases cannot be read together.
    """
    if dict(versions()) != dict(expected):
        raise InvalidInput(
            f"A dask worker has {dict(versions())} and this process {dict(expected)}: install the same."
        )
    supervisors = RUNS.get(token) if token else ELSEWHERE
    if supervisors is None:  # the run in this process is over
        return []
    outcomes = []
    with supervisors.reserved(work) as supervisor:
        for name, outcome in zip(names, supervisor.run(batch, names), strict=False):
            outcomes.append(outcome)
            if supervisors.deliver is not None:
                supervisors.deliver(name, outcome)
    return outcomes


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
    supervisors: Supervisors = field(default_factory=Supervisors, init=False)
    _open: ExitStack = field(default_factory=ExitStack, init=False)
    _client: "Client | None" = field(default=None, init=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.supervisors.end()
        self.rest()

    @contextmanager
    def timer(self, work: bytes) -> Iterator[WorkerSupervisor]:
        """Provide the supervisor of a process of this machine that has read the pickled `work`, for a block."""
        with self.supervisors.reserved(work) as supervisor:
            try:
                yield supervisor
            except BaseException:  # an answer may be under way
                self.supervisors.end()
                raise

    def rest(self) -> None:
        """Close the connection, and the dask of this process: an idle one takes 3 % of a core."""
        self._client = None
        self._open.close()

    def run(
        self, cases: Mapping[str, Computation], work: Work, finished: Finished, stop: Stop
    ) -> None:
        """Compute `cases`: small ones in batches, large ones singly."""
        payload = packed(work)
        if not cases:
            return
        outcomes: SimpleQueue[tuple[str, Outcome]] = SimpleQueue()
        token = "" if self.address else secrets.token_hex(8)
        if token:
            self.supervisors.deliver = lambda name, outcome: outcomes.put((name, outcome))
            RUNS[token] = self.supervisors
        try:
            _Flow(self, self._connected(), token, cases, payload, outcomes, finished, stop).run()
        except BaseException:
            self.rest()
            raise
        finally:
            RUNS.pop(token, None)

    def _connected(self) -> "Client":
        """Return the client of the scheduler, which is started here if there is no address."""
        if self._client is None:
            self._client = self._connect() if self.address else self._start()
        return self._client

    def _start(self) -> "Client":
        """Start dask in this process, and return its client."""
        from distributed import Client, LocalCluster

        cluster = self._open.enter_context(
            LocalCluster(
                n_workers=1,
                threads_per_worker=self.workers,
                processes=False,
                # without an address, they would listen to other machines
                dashboard_address=LOOPBACK,
                worker_dashboard_address=LOOPBACK,
                memory_limit=0,  # the memory of a case is that of its own process
                silence_logs=logging.CRITICAL,
            )
        )
        client: Client = self._open.enter_context(Client(cluster, set_as_default=False))
        if find_spec("bokeh"):
            self.log(f"dask shows its work at {client.dashboard_link}")
        return client

    def _connect(self) -> "Client":
        """Return the client of the scheduler at the address."""
        from distributed import Client

        # what goes wrong with the connection is said here, in a sentence
        logger = logging.getLogger("distributed")
        self._open.callback(logger.setLevel, logger.level)
        logger.setLevel(logging.CRITICAL)
        assert self.address is not None
        try:
            if ":" not in self.address:
                raise ValueError(self.address)
            client = Client(self.address, timeout=self.patience, set_as_default=False)
        except (OSError, ValueError, TypeError, RuntimeError) as error:
            raise InvalidInput(
                f"Scheduler {self.address!r} cannot be reached ({type(error).__name__}): give the address that "
                "'dask scheduler' shows, such as tcp://127.0.0.1:8786."
            ) from None
        self._open.enter_context(client)
        return client


class _Flow:
    """A run on a cluster: keeps every thread busy with a few batches, and adapts their size to the time of a case."""

    def __init__(
        self,
        cluster: Cluster,
        client: "Client",
        token: str,
        cases: Mapping[str, Computation],
        payload: bytes,
        outcomes: "SimpleQueue[tuple[str, Outcome]]",
        finished: Finished,
        stop: Stop,
    ) -> None:
        from distributed import as_completed

        self._cluster, self._client, self._token, self._stop = cluster, client, token, stop
        self._cases, self._payload = cases, payload
        self._outcomes, self._finished = outcomes, finished
        self._waiting, self._open = deque(cases), set(cases)
        self._running: dict[Any, list[str]] = {}
        # an error of a batch is handled here and not raised, so that the others go on
        self._completed = as_completed([], loop=client.loop, with_results=True, raise_errors=False)
        self._mean = BATCH
        self._threads, self._looked_at, self._idle_since = 1, float("-inf"), monotonic()

    def run(self) -> None:
        """Compute all cases."""
        try:
            while self._open:
                self._stop.check()
                self._look()
                self._fill()
                completed = self._completed.next_batch(block=False)
                if not completed and self._outcomes.empty():
                    with self._completed.thread_condition:
                        self._completed.thread_condition.wait(timeout=PAUSE)
                self._take_delivered()
                for future, result in completed:
                    self._take(future, result)
        except BaseException:
            # batches that dask still holds begin nothing, and further outcomes are not read
            RUNS.pop(self._token, None)
            self._cluster.supervisors.end()
            self._take_last()
            raise
        finally:
            with suppress(Exception):
                self._client.cancel(list(self._running), force=True)

    def _report(self, name: str, outcome: Outcome) -> None:
        """Report the outcome of a case at its first arrival, and adapt the size of batches."""
        if name in self._open:
            self._open.discard(name)
            self._mean += 0.3 * (outcome.seconds - self._mean)
            self._finished(name, outcome)

    def _take_delivered(self) -> None:
        """Report the outcomes that threads of this process have delivered."""
        while not self._outcomes.empty():
            self._report(*self._outcomes.get())

    def _take(self, future: Any, result: Any) -> None:
        """Report a completed batch, and send its unfinished cases again."""
        names = self._running.pop(future, None)
        if names is None:  # it counted as lost, and was sent to another worker
            return
        if future.status == "finished" and isinstance(result, list):
            for name, outcome in zip(names, result, strict=False):
                self._report(name, outcome)
            self._send_singly(names[len(result) :])  # which cannot be unpickled together
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

    def _take_last(self) -> None:
        """Report what workers have finished by the time the run stops, unless the disk takes no more."""
        until = monotonic() + LAST
        with suppress(Exception):
            self._take_delivered()
        for future, names in list(self._running.items()):
            with suppress(Exception):
                if future.status == "finished" and monotonic() < until:
                    result = future.result(timeout=until - monotonic())
                    del self._running[future]
                    for name, outcome in zip(names, result, strict=False):
                        self._report(name, outcome)

    def _look(self) -> None:
        """Count the workers, detect a lost connection, and send lost batches again."""
        if monotonic() < self._looked_at + LOOK:
            return
        self._looked_at = monotonic()
        if self._client.status not in ("running", "connecting"):
            raise InvalidInput(
                f"Scheduler {self._cluster.address!r} is lost: start it again and run the same "
                "command, which goes on from what is stored."
            )
        for future in [key for key in self._running if key.status in ("cancelled", "lost")]:
            self._send_again(self._running.pop(future))
        if self._client.status == "running":
            with suppress(OSError, RuntimeError, TimeoutError):
                threads = sum(self._client.nthreads().values())
                self._threads = max(1, threads)
                if threads:
                    self._idle_since = monotonic()
                elif monotonic() > self._idle_since + self._cluster.patience:
                    self._cluster.log(f"waiting for workers of {self._cluster.address}")
                    self._idle_since = float("inf")

    def _fill(self) -> None:
        """Send batches until a few wait for every thread."""
        while (
            self._client.status == "running"
            and self._waiting
            and len(self._running) < AHEAD * self._threads
        ):
            share = len(self._waiting) // (2 * self._threads) + 1
            size = max(1, min(int(BATCH / max(self._mean, 1e-6)), share, LARGEST))
            self._submit([self._waiting.popleft() for _ in range(min(size, len(self._waiting)))])

    def _submit(self, names: list[str]) -> None:
        """Send one batch, pickled together: a class of a study file is then written once, not with every case."""
        try:
            batch = cloudpickle.dumps(tuple(self._cases[name] for name in names))
        except Exception as error:  # noqa: BLE001 (a study's class may do anything)
            if len(names) > 1:
                self._send_singly(names)
            else:
                self._report(names[0], failed(error, "setup", 0.0))
            return
        # impure: a case asked for again is to be computed again
        future = self._client.submit(
            compute_batch, self._token, self._payload, batch, names, dict(versions()), pure=False
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

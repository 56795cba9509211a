"""Cases on the workers of a dask.distributed scheduler."""

import logging
import pickle
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from time import monotonic
from typing import TYPE_CHECKING, Any

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
LOOK = 1.0  # seconds between two looks at the workers and at batches that were lost
LAST = 5.0  # seconds for what workers have finished, when a run is stopped


@dataclass(frozen=True)
class Cluster:
    """The workers that the scheduler at ``address`` has, or will have.

    A worker computes in a process beside its own, so that a case may hang or die without it; where a
    worker is lost all the same, the scheduler gives its cases to another. A scheduler that is lost, and
    comes back within ``patience`` [s], gets again what was not finished.
    """

    address: str
    patience: float = 10.0
    log: Callable[[str], object] = lambda text: None

    def __post_init__(self) -> None:
        if not find_spec("distributed"):
            raise InvalidInput(
                "A scheduler needs dask.distributed: pip install 'contactstudy[cluster]'."
            )

    def run(self, cases: Sequence[Computation], work: Work, finished: Finished, stop: Stop) -> None:
        """Batches of small cases, large ones alone."""
        payload = packed(work)
        # what goes wrong with the connection is said here, in a sentence
        logger = logging.getLogger("distributed")
        level = logger.level
        logger.setLevel(logging.CRITICAL)
        try:
            with _client(self.address, self.patience) as client:
                _Flow(client, self, cases, payload, finished, stop).run()
        finally:
            logger.setLevel(level)


def _client(address: str, patience: float) -> "Client":
    from distributed import Client

    try:
        if ":" not in address:
            raise ValueError(address)
        return Client(address, timeout=patience, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        raise InvalidInput(
            f"Scheduler {address!r} cannot be reached ({type(error).__name__}): give the address that "
            "'dask scheduler' shows, such as tcp://127.0.0.1:8786."
        ) from None


class _Flow:
    """Keeps every worker busy with a few batches, and learns their size on the way."""

    def __init__(
        self,
        client: "Client",
        cluster: Cluster,
        cases: Sequence[Computation],
        payload: bytes,
        finished: Finished,
        stop: Stop,
    ) -> None:
        from distributed import as_completed

        self._client, self._cluster, self._stop = client, cluster, stop
        self._cases, self._finished = cases, finished
        self._payload = payload
        self._waiting = deque(range(len(cases)))
        self._running: dict[Any, list[int]] = {}
        # a batch that fails is looked at here, and not raised: the others go on
        self._completed = as_completed([], loop=client.loop, with_results=True, raise_errors=False)
        self._mean = BATCH
        self._threads, self._looked_at, self._idle_since = 1, -1.0, monotonic()

    def run(self) -> None:
        try:
            while self._waiting or self._running:
                self._stop.check()
                self._look()
                self._fill()
                batch = self._completed.next_batch(block=False)
                if not batch:
                    with self._completed.thread_condition:
                        self._completed.thread_condition.wait(timeout=0.1)
                for future, result in batch:
                    self._take(future, result)
        except BaseException:
            self._take_last()
            raise
        finally:
            with suppress(Exception):
                self._client.cancel(list(self._running), force=True)

    def _take(self, future: Any, result: Any) -> None:
        numbers = self._running.pop(future, None)
        if numbers is None:  # it was thought to be lost, and given to another
            return
        if future.status == "finished" and isinstance(result, list):
            self._waiting.extendleft(reversed(numbers[len(result) :]))
            for number, outcome in zip(numbers, result, strict=False):
                self._mean += 0.3 * (outcome.seconds - self._mean)
                self._finished(number, outcome)
        elif future.status == "error":
            self._handle_failure(future, numbers)
        elif future.status == "pending":  # the worker that had its result died before it gave it
            self._running[future] = numbers
            self._completed.add(future)
        else:
            self._waiting.extendleft(reversed(numbers))

    def _take_last(self) -> None:
        """What workers have finished by the time the run stops is not lost."""
        until = monotonic() + LAST
        for future, numbers in list(self._running.items()):
            with suppress(Exception):
                if future.status == "finished" and monotonic() < until:
                    result = future.result(timeout=until - monotonic())
                    del self._running[future]
                    for number, outcome in zip(numbers, result, strict=False):
                        self._finished(number, outcome)

    def _look(self) -> None:
        """See to workers that come and go, and to a connection that is lost."""
        if monotonic() < self._looked_at + LOOK:
            return
        self._looked_at = monotonic()
        if self._client.status not in ("running", "connecting"):
            raise InvalidInput(
                f"Scheduler {self._cluster.address!r} is lost: start it again and run the same "
                "command, which goes on from what is stored."
            )
        for future in [one for one in self._running if one.status in ("cancelled", "lost")]:
            self._waiting.extendleft(reversed(self._running.pop(future)))
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
        while (
            self._client.status == "running"
            and self._waiting
            and len(self._running) < AHEAD * self._threads
        ):
            share = len(self._waiting) // (2 * self._threads) + 1
            size = max(1, min(int(BATCH / max(self._mean, 1e-6)), share, LARGEST))
            self._submit([self._waiting.popleft() for _ in range(min(size, len(self._waiting)))])

    def _submit(self, numbers: list[int]) -> None:
        sendable, batch = [], []
        for number in numbers:
            try:
                batch.append(cloudpickle.dumps(self._cases[number]))
                sendable.append(number)
            except Exception as error:  # noqa: BLE001 (a study's class may do anything)
                self._finished(number, failed(error, "setup", 0.0))
        if not sendable:
            return
        # impure: a case asked for again is to be computed again
        future = self._client.submit(
            compute_batch, self._payload, batch, dict(versions()), pure=False
        )
        self._running[future] = sendable
        self._completed.add(future)

    def _handle_failure(self, future: Any, numbers: list[int]) -> None:
        from distributed import KilledWorker

        error = future.exception()
        if isinstance(error, InvalidInput):
            raise error
        if not isinstance(error, KilledWorker):
            raise InvalidInput(
                f"A dask worker cannot compute cases ({type(error).__name__}: {error}): install the same "
                "version of contactstudy there."
            )
        if len(numbers) > 1:  # one of them is to blame; alone it will show
            for number in numbers:
                self._submit([number])
            return
        sentence = f"Killed: workers died while they held it, the last {error.last_worker.address}"
        failure = Failure("Killed", sentence, "unknown")
        self._finished(numbers[0], Outcome(CaseStatus.KILLED, {}, failure))


_PROCESS = threading.local()


def compute_batch(
    payload: bytes, batch: Sequence[bytes], expected: Mapping[str, str]
) -> list[Outcome]:
    """On a worker: the outcomes of the cases in ``batch``, from a process that stays for the next."""
    if dict(versions()) != dict(expected):
        raise InvalidInput(
            f"A dask worker has {dict(versions())} and this process {dict(expected)}: install the same."
        )
    held = getattr(_PROCESS, "held", None)
    if held is None or held[0] != payload:
        if held is not None:
            held[1].end()
        held = _PROCESS.held = (payload, WorkerSupervisor(payload))
    return list(held[1].run([pickle.loads(case) for case in batch]))

"""Cases on the workers of a dask.distributed scheduler."""

import pickle
import threading
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from time import monotonic
from typing import TYPE_CHECKING, Any

import cloudpickle

from contactstudy import InvalidInput
from studies.engine.supervisor import WorkerSupervisor
from studies.model.case import Computation
from studies.model.outcome import CaseStatus, Failure, Finished, Outcome, Work
from studies.store.code_fingerprint import versions

if TYPE_CHECKING:
    from distributed import Client

BATCH = 0.25  # seconds of work in a batch of small cases
LARGEST = 200  # cases in a batch
AHEAD = 3  # batches for each thread of a worker, so that it does not wait for the next


@dataclass(frozen=True)
class Cluster:
    """The workers that the scheduler at ``address`` has, or will have.

    A worker computes in a process beside its own, so that a case may hang or die without it; where a
    worker is lost all the same, the scheduler gives its cases to another.
    """

    address: str
    patience: float = 10.0  # seconds to wait for its answer

    def __post_init__(self) -> None:
        if not find_spec("distributed"):
            raise InvalidInput(
                "A scheduler wants dask.distributed: pip install 'contactstudy[cluster]'."
            )

    def run(self, cases: Sequence[Computation], work: Work, finished: Finished) -> None:
        """Batches of small cases, large ones alone."""
        with _client(self.address, self.patience) as client:
            _Flow(client, self.address, cases, work, finished).run()


def _client(address: str, patience: float) -> "Client":
    from distributed import Client

    try:
        return Client(address, timeout=patience, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InvalidInput(
            f"Scheduler {address!r} cannot be reached ({type(error).__name__}): give the address that "
            "'dask scheduler' shows, such as tcp://127.0.0.1:8786."
        ) from None


class _Flow:
    """Keeps every worker busy with a few batches, and learns their size on the way."""

    def __init__(
        self,
        client: "Client",
        address: str,
        cases: Sequence[Computation],
        work: Work,
        finished: Finished,
    ) -> None:
        from distributed import as_completed

        self._client, self._address = client, address
        self._cases, self._finished = cases, finished
        self._payload = cloudpickle.dumps(work)
        self._waiting = deque(range(len(cases)))
        self._running: dict[Any, list[int]] = {}
        # a batch that fails is looked at here, and not raised: the others go on
        self._completed = as_completed([], loop=client.loop, with_results=True, raise_errors=False)
        self._mean = BATCH
        self._threads, self._counted_at = 1, -1.0

    def run(self) -> None:
        try:
            self._fill()
            for future, result in self._completed:
                numbers = self._running.pop(future)
                if future.status == "finished":
                    for number, outcome in zip(numbers, result, strict=True):
                        self._mean += 0.3 * (outcome.seconds - self._mean)
                        self._finished(number, outcome)
                else:
                    self._handle_failure(future, numbers)
                self._fill()
        finally:
            self._client.cancel(list(self._running), force=True)

    def _fill(self) -> None:
        if monotonic() - self._counted_at > 1:  # workers come and go
            self._threads = max(1, sum(self._client.nthreads().values()))
            self._counted_at = monotonic()
        while self._waiting and len(self._running) < AHEAD * self._threads:
            share = len(self._waiting) // (2 * self._threads) + 1
            size = max(1, min(int(BATCH / max(self._mean, 1e-6)), share, LARGEST))
            self._submit([self._waiting.popleft() for _ in range(min(size, len(self._waiting)))])

    def _submit(self, numbers: list[int]) -> None:
        batch = cloudpickle.dumps([self._cases[number] for number in numbers])
        # impure: a case asked for again is to be computed again
        future = self._client.submit(
            compute_batch, self._payload, batch, dict(versions()), pure=False
        )
        self._running[future] = numbers
        self._completed.add(future)

    def _handle_failure(self, future: Any, numbers: list[int]) -> None:
        from distributed import KilledWorker

        if future.status != "error":
            raise InvalidInput(
                f"Scheduler {self._address!r} is lost: start it again and run the same "
                "command, which goes on from what is stored."
            )
        error = future.exception()
        if not isinstance(error, KilledWorker):
            raise error
        if len(numbers) > 1:  # one of them is to blame; alone it will show
            for number in numbers:
                self._submit([number])
            return
        sentence = f"Killed: workers died while they held it, the last {error.last_worker.address}"
        failure = Failure("Killed", sentence, "unknown")
        self._finished(numbers[0], Outcome(CaseStatus.KILLED, {}, failure))


_PROCESS = threading.local()


def compute_batch(payload: bytes, batch: bytes, expected: Mapping[str, str]) -> list[Outcome]:
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
    return list(held[1].run(pickle.loads(batch)))

"""Where cases are computed: in this process, in processes beside it, or on a cluster."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from queue import SimpleQueue
from typing import Protocol, Self

import cloudpickle
from dask.base import compute as compute_all
from dask.delayed import delayed
from threadpoolctl import threadpool_limits

from studies.engine.supervisor import WorkerSupervisor
from studies.model.case import Computation
from studies.model.outcome import CaseStatus, Finished, Outcome, Work, compute, warm_up

CHUNK = 0.02  # seconds of work that are sent to a process in one go


class Executor(Protocol):
    """Computes every case and calls ``finished(number, outcome)`` for each, one call at a time."""

    def run(self, cases: Sequence[Computation], work: Work, finished: Finished) -> None:
        """What ``finished`` raises ends the run, and is raised."""
        ...


@dataclass(frozen=True)
class InProcess:
    """This process alone, but for ``suspects``: cases during which an earlier run died.

    ``on_begin(number)`` is called before each case, so that a death can be laid to it.
    """

    on_begin: Callable[[int], object] = lambda number: None
    suspects: frozenset[int] = frozenset()

    def run(self, cases: Sequence[Computation], work: Work, finished: Finished) -> None:
        """One after the other."""
        warm_up()
        with threadpool_limits(1):
            for number, case in enumerate(cases):
                if number in self.suspects:
                    supervisor = WorkerSupervisor(cloudpickle.dumps(work))
                    try:
                        for outcome in supervisor.run([case]):
                            finished(number, _with_advice(outcome))
                    finally:
                        supervisor.end()
                    continue
                self.on_begin(number)
                finished(number, compute(case, work))


def _with_advice(outcome: Outcome) -> Outcome:
    if outcome.case_status is not CaseStatus.KILLED or outcome.failure is None:
        return outcome
    sentence = (
        f"{outcome.failure.sentence}; it needs a process of its own, since an earlier run in one process "
        "ended with it"
    )
    return replace(outcome, failure=replace(outcome.failure, sentence=sentence))


@dataclass(frozen=True)
class Processes:
    """``workers`` processes on this machine, each driven by a thread of dask's."""

    workers: int

    def run(self, cases: Sequence[Computation], work: Work, finished: Finished) -> None:
        """Each process takes the next few cases when it is done with its last."""
        with ProcessPool(self.workers) as pool:
            pool.run(cases, work, finished)


class ProcessPool:
    """As :class:`Processes`, in a ``with`` statement, whose processes stay from one study to the next.

    To start them takes as long as many a study.
    """

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._supervisors: list[WorkerSupervisor] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.end()

    def end(self) -> None:
        """End the processes, at once."""
        for supervisor in self._supervisors:
            supervisor.end()
        self._supervisors.clear()

    def run(self, cases: Sequence[Computation], work: Work, finished: Finished) -> None:
        """Each process takes the next few cases when it is done with its last."""
        payload = cloudpickle.dumps(work)
        wanted = min(self._workers, len(cases))
        for supervisor in self._supervisors:
            supervisor.set_work(payload)
        self._supervisors += [
            WorkerSupervisor(payload) for _ in range(wanted - len(self._supervisors))
        ]
        shared = _SharedCases(cases)
        # dask in a thread of its own: this one alone reports, and writes to the disk
        with ThreadPoolExecutor(1) as coordinator:
            driving = coordinator.submit(shared.drive, self._supervisors[:wanted])
            try:
                while (found := shared.found.get()) is not None:
                    finished(*found)
            except BaseException:
                # what they are at is for nobody, and the conductor waits for it
                self.end()
                raise
            driving.result()


class _SharedCases:
    """What the threads share: the next case, and the place for its outcome."""

    def __init__(self, cases: Sequence[Computation]) -> None:
        self._cases = cases
        self._next, self._size = 0, 1
        self._turn = threading.Lock()
        self.found: SimpleQueue[tuple[int, Outcome] | None] = SimpleQueue()

    def drive(self, supervisors: Sequence[WorkerSupervisor]) -> None:
        try:
            with ThreadPoolExecutor(max(len(supervisors), 1)) as pool:
                tasks = [delayed(self._drive, pure=False)(supervisor) for supervisor in supervisors]
                compute_all(*tasks, scheduler="threads", pool=pool)
        finally:
            self.found.put(None)

    def _drive(self, supervisor: WorkerSupervisor) -> None:
        while chunk := self._take():
            mine = [self._cases[number] for number in chunk]
            for number, outcome in zip(chunk, supervisor.run(mine), strict=False):
                self.found.put((number, outcome))
                self._resize(outcome.seconds)
            if supervisor.has_ended:
                return

    def _take(self) -> range:
        with self._turn:
            first = self._next
            self._next = min(first + self._size, len(self._cases))
            return range(first, self._next)

    def _resize(self, seconds: float) -> None:
        """A slow case is sent alone, so that the others are free for whoever has time."""
        if seconds * self._size > CHUNK:
            self._size = max(1, self._size // 2)
        elif seconds * 2 * self._size < CHUNK:
            self._size += 1

"""Where cases are computed: in this process, in processes beside it, or on a cluster."""

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from queue import SimpleQueue
from typing import Protocol, Self

import cloudpickle
from threadpoolctl import threadpool_limits

from contactstudy import InvalidInput
from studies.engine.stop import Stop
from studies.engine.workers.compute import StopRun, compute, warm_up
from studies.engine.workers.supervisor import WorkerSupervisor
from studies.model.case import Computation
from studies.model.outcome import CaseStatus, Finished, Outcome, Work

CHUNK = 0.02  # seconds of work that are sent to a process in one go


class Executor(Protocol):
    """Computes every case and calls ``finished(number, outcome)`` for each, one call at a time."""

    def run(self, cases: Sequence[Computation], work: Work, finished: Finished, stop: Stop) -> None:
        """What ``finished`` raises ends the run, and is raised; so does ``stop``.

        What a worker had finished by then is given to ``finished`` all the same.
        """
        ...


def packed(work: Work) -> bytes:
    """``work`` for another process; raises :class:`~contactstudy.InvalidInput` where it cannot go there."""
    try:
        return bytes(cloudpickle.dumps(work))
    except Exception as error:  # noqa: BLE001 (a study's own objects may do anything)
        raise InvalidInput(
            f"measures cannot be sent to a worker process ({type(error).__name__}: {error}): keep open files "
            "and the like out of the file's top level, or run with --workers 0."
        ) from None


@dataclass(frozen=True)
class InProcess:
    """This process alone, but for ``suspects``: cases during which an earlier run died.

    ``begins(number)`` is called before each case, so that a death can be laid to it.
    """

    begins: Callable[[int], object] = lambda number: None
    suspects: frozenset[int] = frozenset()

    def run(self, cases: Sequence[Computation], work: Work, finished: Finished, stop: Stop) -> None:
        """One after the other."""
        warm_up()
        own = os.getpid()
        with threadpool_limits(1):
            for number, case in enumerate(cases):
                stop.check()
                if number in self.suspects:
                    _run_alone(number, case, work, finished, stop)
                    continue
                self.begins(number)
                with stop.interruptible():
                    outcome = compute(case, work)
                if os.getpid() != own:
                    # the case has forked, and this is the other one: the run is not its to go on with
                    os._exit(0)
                finished(number, outcome)


def _run_alone(number: int, case: Computation, work: Work, finished: Finished, stop: Stop) -> None:
    supervisor = WorkerSupervisor(packed(work))
    try:
        with stop.interruptible():
            outcomes = list(supervisor.run([case]))
        for outcome in outcomes:
            finished(number, _with_advice(outcome))
    finally:
        supervisor.end()


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
    """``workers`` processes on this machine, each driven by a thread."""

    workers: int

    def run(self, cases: Sequence[Computation], work: Work, finished: Finished, stop: Stop) -> None:
        """Each process takes the next few cases when it is done with its last."""
        with ProcessPool(self.workers) as pool:
            pool.run(cases, work, finished, stop)


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

    def run(self, cases: Sequence[Computation], work: Work, finished: Finished, stop: Stop) -> None:
        """Each process takes the next few cases when it is done with its last."""
        payload = packed(work)
        wanted = min(self._workers, len(cases))
        for supervisor in self._supervisors:
            supervisor.set_work(payload)
        self._supervisors += [
            WorkerSupervisor(payload) for _ in range(wanted - len(self._supervisors))
        ]
        shared = _SharedCases(cases)
        # the processes are driven from other threads: this one alone reports, and writes to the disk
        with ThreadPoolExecutor(1) as coordinator:
            with stop.waking(shared.stop):
                driving = coordinator.submit(shared.drive, self._supervisors[:wanted])
                try:
                    stop.check()
                    while (found := shared.found.get()) is not None:
                        if found is STOPPED:
                            raise StopRun(stop.signal)
                        finished(*found)
                except BaseException:
                    # nobody will read what they compute now, and the coordinator would wait for it
                    self.end()
                    _finish_rest(shared, finished)
                    raise
            driving.result()


STOPPED = (-1, Outcome(CaseStatus.NOT_RUN))


def _finish_rest(shared: "_SharedCases", finished: Finished) -> None:
    """What was computed by the time the run stopped is not lost, unless the disk takes no more."""
    with suppress(Exception):
        while (found := shared.found.get()) is not None:
            if found is not STOPPED:
                finished(*found)


class _SharedCases:
    """What the threads share: the next case, and the place for its outcome."""

    def __init__(self, cases: Sequence[Computation]) -> None:
        self._cases = cases
        self._next, self._size = 0, 1
        self._turn = threading.Lock()
        # one that a signal handler may put to amid a get
        self.found: SimpleQueue[tuple[int, Outcome] | None] = SimpleQueue()

    def stop(self) -> None:
        """Wake up who waits for outcomes."""
        self.found.put(STOPPED)

    def drive(self, supervisors: Sequence[WorkerSupervisor]) -> None:
        try:
            with ThreadPoolExecutor(max(len(supervisors), 1)) as pool:
                for done in [pool.submit(self._drive, one) for one in supervisors]:
                    done.result()
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

"""Supervisors of worker processes: a case that hangs or dies affects no other case.

Pools of libraries are not used, since they limit and lose a whole batch, they accept answers from a process that a case
has forked, and those of multiprocessing may not be started inside a dask worker.
"""

import pickle
import signal
import threading
from collections.abc import Iterator, Sequence
from itertools import count
from time import perf_counter

import cloudpickle

from contactstudy import InvalidInput
from studies.engine.time_limit import deadline, timed_out
from studies.engine.workers.channel import (
    REQUEST,
    UNREAD,
    Batch,
    ClosedError,
    ForgedError,
    LateError,
    Task,
)
from studies.engine.workers.compute import failure_of
from studies.engine.workers.process import WorkerProcess
from studies.model.case import Computation
from studies.model.outcome import CaseStatus, Failure, Outcome, Sample

STARTS = 3  # processes that may end before their first case
# signals from a person, or for lack of memory; a second try shows whether the case causes them
FROM_OUTSIDE = frozenset({"SIGTERM", "SIGKILL", "SIGINT", "SIGHUP", "SIGQUIT"})
Answer = Outcome | Sample | Failure


class WorkerSupervisor:
    """Supervisor of a worker process for the pickled `work`, started with the first case and again after each death."""

    def __init__(self, work: bytes) -> None:
        self._work = work
        self._limit: float | None = pickle.loads(work).time_limit
        self._process: WorkerProcess | None = None
        self._numbers = count()
        self._lock = threading.Lock()
        self._over = threading.Event()

    def run(self, cases: bytes, names: Sequence[str]) -> Iterator[Outcome]:
        """Yield the outcome of each case, in order, as soon as it is there.

        It ends early after :meth:`end`, and yields nothing for several cases that cannot be read together.

        Parameters
        ----------
        cases
            The cases, pickled together.
        names
            Name of each case.
        """
        for answer in self._answers(cases, names, "compute", self._limit):
            if not isinstance(answer, Outcome):
                assert isinstance(answer, Failure)
                answer = Outcome(CaseStatus.FAILED, {}, answer)
            if answer.failure is None or answer.failure.stage != UNREAD:
                yield answer

    def time_once(
        self, name: str, case: Computation, limit: float | None
    ) -> Sample | Failure | None:
        """Return the times of one run of a case, or the failure that prevents them; None after :meth:`end`."""
        try:
            cases = cloudpickle.dumps((case,))
        except Exception as error:  # noqa: BLE001 (a study's class may do anything)
            return failure_of(error, "setup")
        for answer in self._answers(cases, [name], "clock", limit):
            return answer.failure if isinstance(answer, Outcome) else answer
        return None

    def set_work(self, work: bytes) -> None:
        """Use other `work` from here on, in the same process if there is one."""
        if work != self._work:
            self._work, self._limit = work, pickle.loads(work).time_limit

    @property
    def has_ended(self) -> bool:
        """True after :meth:`end` was called."""
        return self._over.is_set()

    def end(self) -> None:
        """End the process at once; no other is started."""
        with self._lock:
            self._over.set()
            process, self._process = self._process, None
        if process is not None:
            process.end()

    def _answers(
        self, cases: bytes, names: Sequence[str], task: Task, limit: float | None
    ) -> Iterator[Answer]:
        """Yield the answer for each case.

        After the end of a process the remaining cases go to a new one. A case whose process was ended from outside is
        sent again, once.
        """
        answered, retried = 0, -1
        while answered < len(names):
            process = self._ready()
            if process is None:
                return
            batch = Batch(next(self._numbers), cases, tuple(names), answered, task, limit)
            try:
                process.channel.send(REQUEST, batch)
            except ClosedError:  # it had been idle for long, and ended
                self._end_process(process)
                continue
            for place in range(answered, len(names)):
                answer, ending = self._receive(process, (batch.number, place), limit)
                if self._over.is_set():
                    return
                if ending in FROM_OUTSIDE and retried < answered:
                    retried = answered
                    break
                answered += 1
                yield answer
                if not process.is_ready(self._work):  # it has ended
                    break

    def _receive(
        self, process: WorkerProcess, subject: object, limit: float | None
    ) -> tuple[Answer, str]:
        """Return the answer for one case, and the name of the signal that ended the process, if one did."""
        start = perf_counter()
        try:
            # the worker's own alarm comes first, and spares it; the deadline is for what the alarm cannot reach
            answer = process.channel.receive(
                subject,
                process.number,
                until=deadline(limit),
                is_alive=lambda: not process.has_ended(),
            )
            if isinstance(answer, Outcome | Sample | Failure):
                return answer, ""
            raise ForgedError
        except LateError:
            self._end_process(process)
            return timed_out(limit, "unknown", perf_counter() - start), ""
        except ClosedError:
            code = self._end_process(process, wait=2.0)
            sentence = f"Killed: its process {_ending(code)} while it was computed"
            failure = Failure("Killed", sentence, "unknown")
            return Outcome(CaseStatus.KILLED, {}, failure, perf_counter() - start), _signal(code)
        except ForgedError:
            self._end_process(process)
            sentence = (
                "ForgedError: what came in place of its answer is from another process or another case; "
                "does it start processes that go on after it?"
            )
            failure = Failure("ForgedError", sentence, "unknown")
            return Outcome(CaseStatus.FAILED, {}, failure, perf_counter() - start), ""

    def _ready(self) -> WorkerProcess | None:
        """Return a process that has read the study, started or forked if need be; None after :meth:`end`."""
        code: int | None = None
        for _ in range(STARTS):
            with self._lock:
                if self._over.is_set():
                    return None
                process = self._process = self._process or _started()
                if process.is_ready(self._work):
                    return process
            try:
                problem = process.set_up(self._work)
            except (ClosedError, ForgedError, LateError):
                code = self._discard(process, wait=0.5)
                if self._over.is_set():
                    return None
                continue
            if problem:
                raise InvalidInput(f"The study cannot be read in a worker process: {problem}")
            return process
        raise InvalidInput(
            f"{STARTS} worker processes ended before their first case, the last "
            f"{_ending(code)}: see their messages above, or run with --workers 0."
        )

    def _end_process(self, process: WorkerProcess, wait: float = 0.0) -> int | None:
        """End the process that computes, and return its exit code; its keeper stays for the next."""
        return process.end_fork(wait) if process.is_forked else self._discard(process, wait)

    def _discard(self, process: WorkerProcess, wait: float) -> int | None:
        """End the process and its keeper, and return its exit code."""
        with self._lock:
            self._process = None
        return process.end(wait)


def _started() -> WorkerProcess:
    """Return a new worker process; raise InvalidInput where the system allows no more."""
    try:
        return WorkerProcess()
    except OSError as error:
        raise InvalidInput(
            f"A worker process cannot be started ({error.strerror}): give fewer with --workers."
        ) from None


def _ending(code: int | None) -> str:
    """Return a text on how a process ended."""
    name = _signal(code)
    hint = ", perhaps for want of memory" if name == "SIGKILL" else ""
    if code is None:
        return "ended"
    return f"was ended by {name}{hint}" if name else f"ended with exit code {code}"


def _signal(code: int | None) -> str:
    """Return the name of the signal that ended a process; empty where none did."""
    return signal.Signals(-code).name if code is not None and code < 0 else ""

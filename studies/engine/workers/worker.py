"""Program of a worker process, which computes cases for its supervisor, one after the other.

An answer is a tuple: number of this process, place of the case in the batch (None for a set-up), content, whether
another answer follows, and what the process has loaded (None where this is as before).
"""

import multiprocessing
import os
import pickle
import signal
import sys
import threading
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from time import perf_counter
from typing import Any

from threadpoolctl import threadpool_limits

from studies.engine.workers.compute import compute, failed, timed, warm_up
from studies.engine.workers.interpreter_state import InterpreterState
from studies.engine.workers.leftovers import WORKER_VARIABLE, end_all
from studies.model.outcome import Outcome, Work
from studies.store.loaded import LOADED, Record

IDLE_TIMEOUT = 120.0  # seconds without a request after which it ends
READING_STAGE = "reading"  # stage of the failure of several cases that cannot be unpickled together
Answer = tuple[int, int | None, Any, bool, Record | None]


@dataclass(frozen=True)
class Setup:
    """Request to use import paths, an environment and pickled `work`; the answer is an error text, or empty."""

    path: tuple[str, ...]
    environment: dict[str, str]
    work: bytes


@dataclass(frozen=True)
class Batch:
    """Request to compute or to time cases; there is one answer for each that is computed.

    Attributes
    ----------
    cases
        All cases, pickled together. If they cannot be unpickled, every answer is a failure.
    names
        Name of each case.
    first
        Place of the first case to compute; earlier ones have been answered.
    task
        "compute", or "clock" to time.
    limit
        Longest time of a case [s]; None without a limit.
    seconds
        Time [s] after which no further case is begun.
    """

    cases: bytes
    names: tuple[str, ...]
    first: int
    task: str
    limit: float | None
    seconds: float


def main(connection: Connection, mark: str) -> None:
    """Answer the supervisor's requests in order, until it is gone or none comes for a long time."""
    # an interrupt from outside ends the process, and is no error of the case
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    if hasattr(os, "setsid"):
        os.setsid()
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=connection.close)
    threading.Thread(target=_end_with_supervisor, args=(mark,), daemon=True).start()
    with threadpool_limits(1):
        try:
            worker = _Worker(connection, mark)
            while connection.poll(IDLE_TIMEOUT):
                worker.answer(connection.recv())
        except (EOFError, OSError):
            pass
        # do not wait for threads or exit handlers left by a case
        os._exit(0)


class _Worker:
    """A process that serves a connection."""

    def __init__(self, connection: Connection, mark: str) -> None:
        self._connection, self._mark, self._number = connection, mark, os.getpid()
        self._loaded: Record | None = None

    def answer(self, request: Setup | Batch) -> None:
        """Carry out a request, and send the answers."""
        if isinstance(request, Setup):
            self._send(None, self._set_up(request))
        else:
            self._compute(request)

    def _set_up(self, request: Setup) -> str:
        """Read the study; return why it cannot be read, or an empty text."""
        try:
            sys.path[:] = request.path
            os.environ.clear()
            os.environ.update(request.environment | {WORKER_VARIABLE: self._mark})
            self._work: Work = pickle.loads(request.work)
            warm_up()
        except Exception as error:  # noqa: BLE001 (a study's module may do anything)
            return failed(error, "setup", 0.0).error
        self._interpreter_state = InterpreterState.now()
        return ""

    def _compute(self, batch: Batch) -> None:
        """Compute or time cases until the batch has taken its time, and send an answer for each."""
        begun, count = perf_counter(), len(batch.names)
        cases: Any = None
        try:
            cases = pickle.loads(batch.cases)
        except Exception as error:  # noqa: BLE001 (a study's class may do anything)
            content: Any = failed(
                error, "setup" if batch.first + 1 == count else READING_STAGE, 0.0
            )
        follows, index = True, batch.first
        while follows:
            self._interpreter_state.restore(batch.names[index])
            if cases is not None and batch.task == "clock":
                content = timed(cases[index], batch.limit)
            elif cases is not None:
                content = compute(cases[index], self._work)
            if os.getpid() != self._number:
                # a case has forked, and this is its child, which must not answer
                os._exit(0)
            follows = index + 1 < count and perf_counter() - begun < batch.seconds
            self._send(index, content, follows=follows)
            index += 1

    def _send(self, index: int | None, content: Any, *, follows: bool = False) -> None:
        """Send an answer, or a failure where it cannot be pickled."""
        loaded = LOADED.scan()
        news = None if loaded is self._loaded else loaded
        try:
            self._connection.send((self._number, index, content, follows, news))
        except OSError:
            raise
        except Exception as error:  # noqa: BLE001 (a measure's own class may do anything)
            seconds = content.seconds if isinstance(content, Outcome) else 0.0
            failure = failed(error, "measure", seconds)
            self._connection.send((self._number, index, failure, follows, news))
        self._loaded = loaded


def _end_with_supervisor(mark: str) -> None:
    """End this process, and all that it started, when the supervisor ends."""
    supervisor = multiprocessing.parent_process()
    assert supervisor is not None
    wait([supervisor.sentinel])
    end_all(os.getpid(), mark)
    os._exit(1)

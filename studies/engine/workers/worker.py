"""Program of a worker process, which computes cases for its supervisor, one after the other.

An answer is a tuple: id of this process, index of the case in the batch (-1 for the set-up), outcome (None for a
study that was unpickled), whether another answer follows, and what the process has loaded (None where this is as
before).
"""

import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from time import perf_counter
from typing import Any, Literal

from threadpoolctl import threadpool_limits

from studies.engine.workers.compute import compute, failed, timed, warm_up
from studies.engine.workers.interpreter_state import InterpreterState
from studies.engine.workers.process_tree import WORKER_VARIABLE, kill_process_tree
from studies.model.outcome import Outcome, RunSettings
from studies.store.fingerprint.modules import RECORDER, Fingerprints

IDLE_TIMEOUT = 120.0  # seconds without a request after which it ends
BATCH_SECONDS = 0.25  # seconds of work after which no further case of a batch is begun
UNPICKLING_STAGE = "unpickling"  # stage of the failure of cases that cannot be unpickled together
Answer = tuple[int, int, Outcome | None, bool, Fingerprints | None]
Task = Literal["compute", "time"]


@dataclass(frozen=True)
class Batch:
    """Request to compute, or to time once, pickled cases from the index `first` on: one answer for each.

    Earlier cases have been answered. If the cases cannot be unpickled together, every answer is a failure. A case
    takes at most `limit` [s].
    """

    cases: bytes
    names: tuple[str, ...]
    limit: float | None
    task: Task = "compute"
    first: int = 0


def main(
    connection: Connection,
    worker_id: str,
    path: Sequence[str],
    environment: Mapping[str, str],
    settings: bytes,
) -> None:
    """Unpickle the study, and answer the supervisor's requests until it is gone or none comes for a long time.

    `worker_id` marks this process and all that it starts; import path and environment are those of the supervisor.
    """
    # an interrupt from outside ends the process, and is no error of the case
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    if hasattr(os, "setsid"):
        os.setsid()
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=connection.close)
    threading.Thread(target=_end_with_supervisor, args=(worker_id,), daemon=True).start()
    sys.path[:] = path
    os.environ.clear()
    os.environ.update({**environment, WORKER_VARIABLE: worker_id})
    # do not wait for threads or exit handlers left by a case
    with threadpool_limits(1), suppress(EOFError, OSError):
        worker = _Worker(connection)
        if worker.set_up(settings):
            while connection.poll(IDLE_TIMEOUT):
                worker.compute(connection.recv())
    os._exit(0)


class _Worker:
    """A process that serves a connection."""

    def __init__(self, connection: Connection) -> None:
        self._connection, self._pid = connection, os.getpid()
        self._loaded: Fingerprints | None = None

    def set_up(self, settings: bytes) -> bool:
        """Unpickle the study, answer, and return whether it could be unpickled."""
        problem = None
        try:
            self._settings: RunSettings = pickle.loads(settings)
            warm_up()
        except Exception as error:  # noqa: BLE001 (a study's module may do anything)
            problem = failed(error, "setup")
        self._interpreter_state = InterpreterState.now()
        self._send(-1, problem)
        return problem is None

    def compute(self, batch: Batch) -> None:
        """Compute or time cases until the batch has taken its time, and send an answer for each."""
        begun, count = perf_counter(), len(batch.names)
        cases: Any = None
        try:
            cases = pickle.loads(batch.cases)
        except Exception as error:  # noqa: BLE001 (a study's class may do anything)
            outcome = failed(error, "setup" if count == 1 else UNPICKLING_STAGE)
        follows, index = True, batch.first
        while follows:
            self._interpreter_state.restore(batch.names[index])
            if cases is not None and batch.task == "time":
                outcome = timed(cases[index], batch.limit)
            elif cases is not None:
                outcome = compute(cases[index], self._settings)
            if os.getpid() != self._pid:
                # a case has forked, and this is its child, which must not answer
                os._exit(0)
            follows = index + 1 < count and perf_counter() - begun < BATCH_SECONDS
            self._send(index, outcome, follows=follows)
            index += 1

    def _send(self, index: int, outcome: Outcome | None, *, follows: bool = False) -> None:
        """Send an answer, or a failure where it cannot be pickled."""
        loaded = RECORDER.scan()
        news = None if loaded is self._loaded else loaded
        try:
            self._connection.send((self._pid, index, outcome, follows, news))
        except OSError:
            raise
        except Exception as error:  # noqa: BLE001 (a measure's own class may do anything)
            failure = failed(error, "measure", outcome.seconds if outcome else 0.0)
            self._connection.send((self._pid, index, failure, follows, news))
        self._loaded = loaded


def _end_with_supervisor(worker_id: str) -> None:
    """End this process, and all that it started, when the supervisor ends."""
    supervisor = multiprocessing.parent_process()
    assert supervisor is not None
    wait([supervisor.sentinel])
    kill_process_tree(os.getpid(), worker_id)
    os._exit(1)

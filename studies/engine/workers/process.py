"""Supervised worker processes: a case that hangs or dies affects no other case.

Pools of libraries are not used, since they limit and lose a whole batch, and accept answers from a process that a case
has forked.
"""

import atexit
import multiprocessing
import os
import secrets
import signal
import sys
import threading
from collections.abc import Iterator, MutableMapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from pathlib import Path
from time import monotonic, perf_counter
from types import ModuleType
from typing import Any, Self

import cloudpickle

from contactstudy import InvalidInput
from studies.engine.workers.compute import deadline, timed_out
from studies.engine.workers.process_tree import kill_process_tree
from studies.engine.workers.worker import UNPICKLING_STAGE, Answer, Batch, Task, main
from studies.model.outcome import CaseStatus, Failure, Outcome, RunSettings
from studies.store.fingerprint.modules import RECORDER, Fingerprints

START_TIMEOUT = 120.0  # seconds in which a new process must be ready
RESTART_DELAY = 0.5  # seconds after which the fork server is started again
MAX_STARTS = 3  # processes that may end before their first case
# a process that has imported the libraries is forked, where the system can; a fork of macOS may not use its libraries
METHOD = "forkserver" if sys.platform == "linux" and hasattr(os, "fork") else "spawn"
PROCESSES: Any = multiprocessing.get_context(METHOD)
START_LOCK = threading.Lock()


def pickled_settings(settings: RunSettings) -> bytes:
    """Return `settings` pickled for another process; raise InvalidInput where it cannot be pickled."""
    try:
        return bytes(cloudpickle.dumps(settings))
    except Exception as error:  # noqa: BLE001 (a study's own objects may do anything)
        raise InvalidInput(
            f"measures cannot be sent to a worker process ({type(error).__name__}: {error}): keep open files "
            "and the like out of the file's top level, or run with --workers 0."
        ) from None


@contextmanager
def _plain_process() -> Iterator[None]:
    """Let a process start without the script of this one, without files of the current folder, and from a dask worker.

    A script without a guard would run again. A file of the user's may be called like a module of Python's. A default
    dask worker may not have child processes by its settings.
    """
    root = str(Path(__file__).parents[3])
    path = os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH"))))
    settings = multiprocessing.current_process()._config  # type: ignore[attr-defined]
    with (
        START_LOCK,
        _interrupts_blocked(),
        _changed(sys.modules, "__main__", ModuleType("__main__")),
        _changed(settings, "daemon", False),  # noqa: FBT003 (a value)
        _changed(os.environ, "PYTHONSAFEPATH", "1"),
        _changed(os.environ, "PYTHONPATH", path),
    ):
        yield


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block Ctrl-C in this thread, and so in the processes that it starts, which would print a traceback for it."""
    if METHOD != "forkserver":
        yield
        return
    resource_tracker.ensure_running()  # starting it unblocks the signal
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _changed(mapping: MutableMapping[str, Any], name: str, value: object) -> Iterator[None]:
    """Change an entry of a mapping for a block."""
    before = mapping.pop(name, None)
    mapping[name] = value
    try:
        yield
    finally:
        del mapping[name]
        if before is not None:
            mapping[name] = before


class SupervisedProcess:
    """A supervised process for the pickled `settings`, started with the first case and again after each death.

    The event `ended` is set by :meth:`end`.
    """

    def __init__(self, settings: bytes) -> None:
        self.settings = settings
        self._process: Any = None
        self._loaded: Fingerprints = RECORDER.record
        self.ended = threading.Event()
        atexit.register(self.end)

    def run(
        self, cases: bytes, names: Sequence[str], limit: float | None, task: Task = "compute"
    ) -> Iterator[Outcome]:
        """Yield the outcome of each pickled case, in order and at once, until a batch has taken its time.

        After the death of a process the remaining cases go to a new one; the case that it computed is tried once more,
        which shows whether it causes deaths. Nothing is yielded after :meth:`end`, and for several cases that cannot
        be unpickled together. A case takes at most `limit` [s]. The task is to "compute" each case, or to "time" it
        once, for a sample.
        """
        batch, index, deaths = Batch(cases, tuple(names), limit, task), 0, 0
        while index < len(names) and self._is_ready():
            try:
                self._connection.send(replace(batch, first=index))
            except OSError:  # it had been idle for long, and ended
                self._discard()
                continue
            follows = True
            while follows:
                outcome, follows = self._receive(index, limit)
                if self.ended.is_set():
                    return
                if outcome.case_status is CaseStatus.KILLED and not deaths:
                    deaths = 1
                    break
                index, deaths = index + 1, 0
                if outcome.failure is None or outcome.failure.stage != UNPICKLING_STAGE:
                    yield replace(outcome, loaded=self._loaded)
            if self._process is not None:
                return

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.end()

    def end(self) -> None:
        """End the process at once; no other is started."""
        self.ended.set()
        atexit.unregister(self.end)
        self._discard()

    def _receive(self, index: int, limit: float | None) -> tuple[Outcome, bool]:
        """Return the outcome of a case, and whether another one follows."""
        start = perf_counter()
        # the worker's own alarm comes first, and spares it; the deadline is for what the alarm cannot reach
        answer = self._next(deadline(limit))
        if isinstance(answer, tuple) and answer[1] == index and answer[2] is not None:
            return answer[2], answer[3]
        code = self._discard(wait=2.0 if answer is EOFError else 0.0)
        seconds = perf_counter() - start
        if answer is TimeoutError:
            return timed_out(limit, "unknown", seconds), False
        if answer is EOFError:
            status, kind = CaseStatus.KILLED, "Killed"
            sentence = f"its process {_ending(code)} while it was computed"
        else:
            status, kind = CaseStatus.FAILED, "UnexpectedAnswer"
            sentence = (
                "the worker received a message of another process or another case in place of its answer: "
                "end the processes that the case starts"
            )
        return Outcome(status, {}, Failure(kind, f"{kind}: {sentence}", "unknown"), seconds), False

    def _next(self, until: float | None) -> Answer | type[Exception]:
        """Return the next answer of the process; an exception's class where it is late, gone, or another's."""
        process = self._process
        if process is None:
            return EOFError
        try:
            timeout = None if until is None else max(until - monotonic(), 0.0)
            ready = wait([self._connection, process.sentinel], timeout)
            # an answer may have come just before the process ended
            if self._connection not in ready and not self._connection.poll():
                return EOFError if ready else TimeoutError
            answer: Answer = self._connection.recv()
            if answer[0] != process.pid:
                return ValueError
            self._loaded = self._loaded if answer[4] is None else answer[4]
        except (EOFError, OSError):  # also where another thread has closed it
            return EOFError
        except Exception:  # noqa: BLE001 (a study's own class may do anything)
            return ValueError
        return answer

    def _is_ready(self) -> bool:
        """Return whether a process has unpickled the study, started if need be; False after :meth:`end`."""
        starts, code = 0, None
        while self._process is None and not self.ended.is_set():
            if starts == MAX_STARTS:
                raise InvalidInput(
                    f"{MAX_STARTS} worker processes ended before their first case, the last "
                    f"{_ending(code)}: see their messages above, or run with --workers 0."
                )
            starts += 1
            self._start()
            answer = self._next(monotonic() + START_TIMEOUT)
            if not isinstance(answer, tuple):
                code = self._discard(wait=0.5)
            elif answer[2] is not None:
                self._discard()
                problem = answer[2].error
                raise InvalidInput(f"The study cannot be unpickled in a worker process: {problem}")
        return not self.ended.is_set()

    def _start(self) -> None:
        """Start a process, unless the fork server ends; raise InvalidInput where the system allows no more."""
        self._connection: Connection
        self._worker_id = secrets.token_hex(8)
        setup = tuple(sys.path), dict(os.environ), self.settings
        try:
            self._connection, end = PROCESSES.Pipe()
            with end, _plain_process():
                if METHOD == "forkserver":
                    PROCESSES.set_forkserver_preload(["studies.engine.workers.preload"])
                process = PROCESSES.Process(target=main, args=(end, self._worker_id, *setup))
                process.start()
        except (EOFError, ConnectionError):
            # or the next one is asked of the same fork server, while the system ends it
            self.ended.wait(RESTART_DELAY)
            return
        except OSError as error:
            raise InvalidInput(
                f"A worker process cannot be started ({error.strerror}): give fewer with --workers."
            ) from None
        self._process = process
        if self.ended.is_set():  # meanwhile
            self._discard()

    def _discard(self, wait: float = 0.0) -> int | None:
        """End the process, after up to `wait` [s] of its own ending, and all that it started; return its exit code."""
        process, self._process = self._process, None
        if process is None:
            return None
        process.join(wait)
        kill_process_tree(process.pid, self._worker_id)
        process.join()
        self._connection.close()
        return int(process.exitcode)


def _ending(code: int | None) -> str:
    """Return a text on how a process ended."""
    if code is None or code >= 0:
        return "ended" if code is None else f"ended with exit code {code}"
    name = signal.Signals(-code).name
    hint = ", perhaps out of memory" if name == "SIGKILL" else ""
    return f"was ended by {name}{hint}"

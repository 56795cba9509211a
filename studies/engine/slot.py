"""A slot: one supervised process that performs tasks, and is started again when a task has ended it or exceeds its time.

A task that hangs, also in compiled code, or dies affects no other. Pools of libraries are not used, since they limit and
lose a whole batch, and accept answers from a process that a case has forked.
"""

import atexit
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator, MutableMapping
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from pathlib import Path
from time import perf_counter
from types import ModuleType
from typing import Any, Self

import cloudpickle
import psutil

from contactstudy import InvalidInput
from studies.engine.compute import ended
from studies.engine.serving import main
from studies.model.outcome import CaseStatus, Outcome, RunSettings
from studies.store.program import Program

START_TIMEOUT = 120.0  # seconds in which a new process must be ready
RESTART_DELAY = 0.5  # seconds after which the fork server is started again
LONGEST_WAIT = 1e6  # seconds, twelve days: the system takes no more
REMEDY = "; give more with --time-limit and --retry timeout"
MAX_STARTS = 3  # processes in a row that may end before their first case
# a process that has imported the libraries is forked, where the system can; a fork of macOS may not use its libraries
METHOD = "forkserver" if sys.platform == "linux" and hasattr(os, "fork") else "spawn"
PROCESSES: Any = multiprocessing.get_context(METHOD)
START_LOCK = threading.Lock()


def pickled_settings(settings: RunSettings, program: Program) -> bytes:
    """Return what every task needs, pickled for another process; raise InvalidInput where it cannot be pickled."""
    try:
        return bytes(cloudpickle.dumps((settings, program)))
    except Exception as error:  # noqa: BLE001 (a study's own objects may do anything)
        raise InvalidInput(
            f"measures cannot be sent to a worker process ({type(error).__name__}: {error}): keep open files "
            "and the like out of the file's top level, or run with --workers 0."
        ) from None


class Slot:
    """A slot for tasks with pickled `settings`; a message about its program names the place `where` it is.

    A process is started for the first task, and again after each death. The event `ended` is set by :meth:`end`.
    """

    def __init__(self, settings: bytes, where: str = "") -> None:
        self.settings, self.ended = settings, threading.Event()
        self._where = where
        self._process: Any = None
        atexit.register(self.end)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.end()

    def perform(self, tasks: bytes, count: int, limit: float | None, remedy: str = REMEDY) -> list[Outcome]:
        """Return the outcomes of the first of `count` pickled tasks, in order, as many as a batch has time for.

        A task takes at most `limit` [s]; the `remedy` is said of one that takes longer. One that its process dies of is
        performed once more, alone, which shows whether it is the cause. There are fewer outcomes after :meth:`end`, and
        none of several tasks that cannot be unpickled together.

        Raises
        ------
        InvalidInput
            If the process has another program than this one, or cannot be started.
        """
        outcomes: list[Outcome] = []
        is_again = False  # of a task that its process has died of
        while len(outcomes) < count and self._is_ready():
            first = len(outcomes)
            try:
                self._connection.send((tasks, first, first + 1 if is_again else count))
            except OSError:  # the process ended while it was idle
                self._discard()
                continue
            while isinstance(answer := self._answer(limit), Outcome):
                outcomes.append(answer)
                is_again = False
            if isinstance(answer, str):
                if answer:
                    raise InvalidInput(answer)
                return outcomes
            if self.ended.is_set():
                break
            kind, seconds, code = answer
            if kind is TimeoutError:
                sentence = f"not done after {limit:g} s{remedy}"
                outcomes.append(ended(CaseStatus.TIMEOUT, "TimeLimitError", sentence, seconds))
            elif is_again:
                sentence = f"its process {_ending(code)} while it was computed"
                outcomes.append(ended(CaseStatus.KILLED, "Killed", sentence, seconds))
            is_again = kind is not TimeoutError and not is_again
        return outcomes

    def end(self) -> None:
        """End the process at once, and all that it started; no other is started."""
        self.ended.set()
        atexit.unregister(self.end)
        self._discard()

    def _answer(self, limit: float | None) -> Outcome | str | tuple[type[Exception], float, int | None]:
        """Return the next answer; where it is late or does not come, the error, the seconds and the exit code."""
        start, process = perf_counter(), self._process
        kind: type[Exception] = EOFError
        with suppress(Exception):  # another thread may have ended the process, or its answer cannot be unpickled
            ready = wait([self._connection, process.sentinel], limit and min(limit, LONGEST_WAIT))
            # an answer may have come just before the process ended
            if self._connection in ready or self._connection.poll():
                return self._connection.recv()  # type: ignore[no-any-return]
            kind = EOFError if ready else TimeoutError
        code = self._discard(wait=0.0 if kind is TimeoutError else 5.0)
        return kind, perf_counter() - start, code

    def _is_ready(self) -> bool:
        """Return whether a process has unpickled the settings, started if need be; False after :meth:`end`."""
        starts, code = 0, None
        while self._process is None and not self.ended.is_set():
            if starts == MAX_STARTS:
                raise InvalidInput(
                    f"{MAX_STARTS} worker processes ended before their first case, the last "
                    f"{_ending(code)}: see their messages above, or run with --workers 0."
                )
            starts += 1
            self._start()
            answer = self._answer(START_TIMEOUT)
            if isinstance(answer, tuple):
                code = answer[2]
            elif answer:
                self._discard()
                raise InvalidInput(f"The study cannot be unpickled in a worker process: {answer}")
        return not self.ended.is_set()

    def _start(self) -> None:
        """Start a process, unless the fork server ends; raise InvalidInput where the system allows no more."""
        self._connection: Connection
        try:
            self._connection, end = PROCESSES.Pipe()
            with end, _plain_process():
                if METHOD == "forkserver":
                    PROCESSES.set_forkserver_preload(["studies.engine.serving"])
                arguments = (end, tuple(sys.path), dict(os.environ), self.settings, self._where)
                process = PROCESSES.Process(target=main, args=arguments)
                process.start()
        except (EOFError, ConnectionError):
            # without the delay the next process would be asked of this fork server too, which is ending
            self.ended.wait(RESTART_DELAY)
            return
        except OSError as error:
            raise InvalidInput(
                f"A worker process cannot be started ({error.strerror}): give fewer with --workers."
            ) from None
        self._process = process
        if self.ended.is_set():  # while it was started
            self._discard()

    def _discard(self, wait: float = 0.0) -> int | None:
        """End the process, after up to `wait` [s] of its own ending, and all that it started; return its exit code."""
        process, self._process = self._process, None
        if process is None:
            return None
        process.join(wait)
        if METHOD == "forkserver":
            process.terminate()  # its keeper ends what it started
            process.join(5.0)
        else:
            with suppress(psutil.Error):
                for started in psutil.Process(process.pid).children(recursive=True):
                    started.kill()
        process.kill()
        if hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
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


@contextmanager
def _plain_process() -> Iterator[None]:
    """Let a process start without the script of this one, without files of the current folder, and from a dask worker.

    A script without a guard would run again. A file of the user's may be called like a module of Python's. A default
    dask worker may not have child processes by its settings.
    """
    root = str(Path(__file__).parents[2])
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

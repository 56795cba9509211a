"""Program of the process in a slot, which performs tasks for its supervisor, one after the other.

An answer is an outcome of a task. After the last one of a batch comes a text: why the program is another one than the
supervisor's, and empty if it is not; the first answer is why the settings cannot be unpickled.
"""

import ctypes
import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from time import perf_counter
from typing import Any, NoReturn

import psutil
from threadpoolctl import threadpool_limits

from contactstudy import InvalidInput
from studies.engine.compute import failed, perform, warm_up
from studies.model.outcome import RunSettings
from studies.store.program import look, own_digests

IDLE_TIMEOUT = 120.0  # seconds without a request after which it ends
BATCH_SECONDS = 0.25  # seconds of work after which no further task of a batch is begun
# of Linux: signal at the end of the parent process; orphans below become child processes of this one
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36

# the fork server imports this module, and with it what tasks need
warm_up()
own_digests()


def main(
    connection: Connection, path: Sequence[str], environment: Mapping[str, str], settings: bytes, where: str
) -> None:
    """Unpickle the settings, and answer requests of the supervisor until it is gone or none comes for a long time.

    On Linux a child process does so, and this one is its keeper: it ends with it, and ends all that it started.
    Import path and environment are those of the supervisor. `where` is the place that a message names.
    """
    if hasattr(os, "setsid"):
        os.setsid()
    if sys.platform == "linux" and hasattr(os, "fork"):
        _keep_child(connection)
    else:
        threading.Thread(target=_end_with_supervisor, daemon=True).start()
    # an interrupt from outside ends the process, and is no error of the case
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=connection.close)
    sys.path[:] = path
    os.environ.clear()
    os.environ.update(environment)
    # do not wait for threads or exit handlers left by a case
    with threadpool_limits(1), suppress(EOFError, OSError):
        _serve(connection, settings, where)
    os._exit(0)


def _serve(connection: Connection, settings: bytes, where: str) -> None:
    """Unpickle the settings, and answer requests: pickled tasks, and the first of them and the one after the last."""
    problem = ""
    try:
        run, program = pickle.loads(settings)
        look()
    except Exception as error:  # noqa: BLE001 (a study's module may do anything)
        problem = failed(error).error
    connection.send(problem)
    while not problem and connection.poll(IDLE_TIMEOUT):
        tasks, first, end = connection.recv()
        _perform(connection, run, tasks, first, end)
        try:
            program.check(where)
            connection.send("")
        except InvalidInput as refusal:
            connection.send(str(refusal))


def _perform(connection: Connection, run: RunSettings, pickled: bytes, first: int, end: int) -> None:
    """Perform tasks until the batch has taken its time, and send each outcome."""
    begun = perf_counter()
    try:
        tasks: Any = pickle.loads(pickled)
    except Exception as error:  # noqa: BLE001 (a study's class may do anything)
        if end == first + 1:
            connection.send(failed(error))
        return
    for number in range(first, end):
        outcome = perform(tasks[number], run)
        try:
            connection.send(outcome)
        except OSError:
            raise
        except Exception as error:  # noqa: BLE001 (a measure's own class may do anything)
            connection.send(failed(error, outcome.seconds))
        if perf_counter() - begun > BATCH_SECONDS:
            return


def _keep_child(connection: Connection) -> None:
    """Fork; return in the child, and in this process end as the child does, with all that it started.

    The child also ends if the supervisor does, or if this process is asked to end.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    system = ctypes.CDLL(None)
    system.prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    read, write = os.pipe()
    os.set_blocking(write, False)
    signal.set_wakeup_fd(write)
    for number in (signal.SIGCHLD, signal.SIGTERM):
        signal.signal(number, lambda *_: None)  # it wakes the keeper
    child = os.fork()
    if child == 0:
        system.prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
        signal.set_wakeup_fd(-1)
        for number in (signal.SIGCHLD, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        os.close(read)
        os.close(write)
        return
    connection.close()
    supervisor = multiprocessing.parent_process()
    assert supervisor is not None
    statuses: dict[int, int] = {}
    while child not in statuses and read in wait([read, supervisor.sentinel]):
        if signal.SIGTERM in os.read(read, 1000):
            break
        _reap(statuses)
    while True:  # what is killed may have forked meanwhile
        for process in psutil.Process().children(recursive=True):
            with suppress(psutil.Error):
                process.kill()
        try:
            pid, status = os.waitpid(-1, 0)
        except ChildProcessError:
            break
        statuses[pid] = status
    _end_as(os.waitstatus_to_exitcode(statuses[child]))


def _reap(statuses: dict[int, int]) -> None:
    """Take note of the child processes that have ended."""
    with suppress(ChildProcessError):
        while (ended := os.waitpid(-1, os.WNOHANG))[0]:
            statuses[ended[0]] = ended[1]


def _end_as(code: int) -> NoReturn:
    """End this process with an exit code, or by a signal where it is negative."""
    if code < 0:
        with suppress(OSError):
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    os._exit(code)


def _end_with_supervisor() -> None:
    """End this process when the supervisor ends."""
    supervisor = multiprocessing.parent_process()
    assert supervisor is not None
    wait([supervisor.sentinel])
    os._exit(1)

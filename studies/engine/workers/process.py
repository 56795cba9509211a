"""Processes that compute cases: how they are started, forked, recognised and ended, on every system.

A supervisor starts a *keeper*, with one end of a socket pair and with a pipe that closes when the supervisor ends.
Where the system can, the keeper reads the study and forks the process that computes: when that one dies, another is
there within milliseconds, where a new interpreter takes most of a second. Elsewhere the keeper computes by itself.
"""

import os
import pickle
import secrets
import select
import signal
import socket
import subprocess
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from time import monotonic, sleep
from typing import Any

import psutil

from studies.engine.workers.channel import (
    ENDING,
    FORK,
    REQUEST,
    REQUEST_KEY,
    SETUP,
    Address,
    Channel,
    ClosedError,
    Ending,
    ForgedError,
    Fork,
    LateError,
    Request,
    Setup,
    channel_pair,
    new_key,
)

MARK = "CONTACTSTUDY_WORKER"  # in the environment of a worker, and so of what it starts
STDIN = 0
START = 120.0  # seconds in which a new process must be ready
# Linux: a fork of macOS may not use its system's libraries
CAN_FORK = all(hasattr(os, name) for name in ("fork", "setsid", "pidfd_open"))


class WorkerProcess:
    """A process that computes, as its supervisor sees it, with the channel to it and its number.

    Raises
    ------
    OSError
        If no more processes can be started.
    """

    def __init__(self) -> None:
        self._control, end = channel_pair()
        self._mark = secrets.token_hex(8)
        with end:
            self._keeper = _start(end, self._mark)
        self.channel, self.number = self._control, self._keeper.pid
        self._descriptor = -1
        self._work = b""

    def is_ready(self, work: bytes) -> bool:
        """Return whether a process is running that has read the pickled `work`."""
        return self._work == work and (self.is_forked or not CAN_FORK)

    def set_up(self, work: bytes) -> str:
        """Provide a process that has read the pickled `work`; return why it cannot be read, or an empty text.

        Raises
        ------
        ClosedError, ForgedError, LateError
            If the keeper has ended.
        """
        if self._work != work:
            self.end_fork()
            key = new_key()
            send_requests(self._control, [Setup(tuple(sys.path), work, key)])
            if problem := str(self._answer(SETUP, key)):
                return problem
            self._work = work
        if CAN_FORK:
            self._fork()
        return ""

    def _fork(self) -> None:
        """Let the keeper fork the process that computes."""
        channel, end = channel_pair()
        key = new_key()
        with end:
            send_requests(self._control, [Fork(key)])
            self._control.send_socket(end)
            number = int(self._answer(FORK, key))
        self.channel, self.number = channel, number
        with suppress(ProcessLookupError):  # it has ended already, and was waited for
            self._descriptor = os.pidfd_open(number)

    def _answer(self, place: int, key: bytes) -> Any:
        """Return the keeper's answer to a request."""
        until = monotonic() + START
        address = Address(place, self._keeper.pid, key)
        body = self._control.receive(
            address, until=until, is_alive=lambda: not _has_ended(self._keeper)
        )
        return pickle.loads(body)

    @property
    def is_forked(self) -> bool:
        """True where the process that computes is a fork of the keeper, which can fork another."""
        return self.channel is not self._control

    def has_ended(self) -> bool:
        """Return whether the process that computes has ended; its number stays its own until it is waited for."""
        if not self.is_forked:
            return _has_ended(self._keeper)
        if self._descriptor < 0:
            return True
        return bool(select.select([self._descriptor], [], [], 0)[0])

    def end_fork(self, wait: float = 0.0) -> int | None:
        """End the fork and all that it started, after up to ``wait`` [s] of its own ending; returns its exit code.

        None where there is no fork, or where its keeper is gone.
        """
        self._wait(wait)
        if not self.is_forked:
            return None
        end_all(self.number, self._mark, spared=self._keeper.pid)
        if self._descriptor >= 0:
            os.close(self._descriptor)
        number, self._descriptor = self.number, -1
        self.channel.close()
        self.channel, self.number = self._control, self._keeper.pid
        key = new_key()
        try:
            send_requests(self._control, [Ending(number, key)])
            return int(self._answer(ENDING, key))
        except (ClosedError, ForgedError, LateError):
            return None

    def end(self, wait: float = 0.0) -> int | None:
        """End all processes, after up to ``wait`` [s] of their own ending; returns the exit code of the keeper."""
        self._wait(wait)
        end_all(self._keeper.pid, self._mark)
        self._keeper.wait()
        assert self._keeper.stdin is not None
        with suppress(OSError):
            self._keeper.stdin.close()
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
        return self._keeper.returncode

    def _wait(self, seconds: float) -> None:
        """Wait up to `seconds` for the process that computes to end."""
        until = monotonic() + seconds
        while seconds and not self.has_ended() and monotonic() < until:
            sleep(0.01)


def send_requests(channel: Channel, requests: Sequence[Request]) -> None:
    """Send ``requests`` to a worker; raises :class:`ClosedError` where it is gone."""
    channel.send(Address(REQUEST, os.getpid(), REQUEST_KEY), pickle.dumps(requests))


def _start(end: socket.socket, mark: str) -> subprocess.Popen[bytes]:
    """Start a keeper that has ``end``; raises OSError where there can be no more processes.

    Its standard input says which socket that is, and stays open for as long as this process lives. It is in a
    session or group of its own: a terminal's Ctrl-C is for this process.
    """
    # -P: a file of the user's may be called like a module of Python's
    command = [sys.executable, "-P", "-m", "studies.engine.workers.worker"]
    environment = os.environ | {MARK: mark}
    share = getattr(end, "share", None)  # Windows, where a process inherits no sockets
    if share:
        # past the launcher of a virtual environment, whose number is not that of the worker
        environment["__PYVENV_LAUNCHER__"] = sys.executable
        command[0] = getattr(sys, "_base_executable", sys.executable)
    process = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        pass_fds=() if share else (end.fileno(),),
        start_new_session=True,
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        env=environment,
    )
    assert process.stdin is not None
    shared = share(process.pid) if share else str(end.fileno()).encode()
    with suppress(OSError):  # it has ended already, which its supervisor will find
        process.stdin.write(f"{os.getpid()} {shared.hex()}\n".encode())
        process.stdin.flush()
    return process


def take_over() -> tuple[socket.socket, int, int]:
    """Return a keeper's socket, its supervisor's number, and a descriptor to read when that one has ended.

    What a case starts inherits neither, and finds an empty standard input.
    """
    line = b""
    while not line.endswith(b"\n"):
        if not (part := os.read(STDIN, 4096)):
            sys.exit(1)  # the supervisor is gone
        line += part
    supervisor, shared = line.decode().split()
    leash = os.dup(STDIN)
    empty = os.open(os.devnull, os.O_RDONLY)
    os.dup2(empty, STDIN)
    os.close(empty)
    name = bytes.fromhex(shared)
    if hasattr(socket, "fromshare"):
        return socket.fromshare(name), int(supervisor), leash
    os.set_inheritable(int(name), False)  # noqa: FBT003 (the system's own way)
    return socket.socket(fileno=int(name)), int(supervisor), leash


def fork() -> int:
    """Fork a keeper into a process in a session of its own; returns its number, or 0 in that process itself."""
    with (
        warnings.catch_warnings()
    ):  # of threads of a numerical library, which ends them itself before a fork
        warnings.simplefilter("ignore", DeprecationWarning)
        number = os.fork()
    if number == 0:
        os.setsid()
    return number


def runs(number: int | None) -> bool:
    """Return whether the process that this keeper forked has not ended."""
    if number is None:
        return False
    try:
        return os.waitid(os.P_PID, number, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None
    except ChildProcessError:
        return False


def exit_code(number: int) -> int | None:
    """Wait for the end of the process that this keeper forked, and return its exit code."""
    try:
        return os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])
    except ChildProcessError:
        return None


def end_all(worker: int, mark: str, spared: int | None = None) -> None:
    """Kill ``worker``, the process group that it leads where there are groups, and all that bears its ``mark``.

    The process ``spared`` bears the mark and lives on.
    """
    for process in psutil.process_iter() if mark else ():
        with suppress(psutil.Error, OSError):  # it has ended, or is another user's
            if (
                process.pid not in (worker, spared, os.getpid())
                and process.environ().get(MARK) == mark
            ):
                process.kill()
    with suppress(psutil.Error, ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(worker, signal.SIGKILL)
        else:
            psutil.Process(worker).kill()


def _has_ended(process: subprocess.Popen[Any]) -> bool:
    """Return whether the process has ended; where the system can, its number stays its own until it is waited for."""
    if process.returncode is not None:
        return True
    if hasattr(os, "waitid"):
        try:
            options = os.WEXITED | os.WNOHANG | os.WNOWAIT
            return os.waitid(os.P_PID, process.pid, options) is not None
        except ChildProcessError:
            pass
    return process.poll() is not None

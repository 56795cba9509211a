"""Processes that compute cases: how they are started, forked, recognised and ended, on every system.

A supervisor starts a *keeper*, with one end of a socket pair and with a pipe that closes when the supervisor ends.
Where the system can, the keeper reads the study and forks the process that computes: when that one dies, another is
there within milliseconds, where a new interpreter takes most of a second. Elsewhere the keeper computes by itself.
"""

import os
import secrets
import signal
import socket
import subprocess
import sys
import warnings
from contextlib import suppress
from time import monotonic, sleep
from typing import Any

import psutil

from studies.engine.workers.channel import (
    EXIT_CODE,
    FORK,
    REQUEST,
    SETUP,
    ClosedError,
    ForgedError,
    LateError,
    Setup,
    channel_pair,
)

MARK = "CONTACTSTUDY_WORKER"  # environment variable of a worker, inherited by what it starts
STDIN = 0
START = 120.0  # seconds in which a new process must be ready
# Linux: a fork of macOS may not use its system's libraries
CAN_FORK = sys.platform == "linux" and all(hasattr(os, name) for name in ("fork", "waitid"))


class WorkerProcess:
    """A process that computes, as its supervisor sees it, with the channel to it and its process number.

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
            self._control.send(REQUEST, Setup(tuple(sys.path), work))
            if problem := str(self._answer(SETUP)):
                return problem
            self._work = work
        if CAN_FORK:
            channel, end = channel_pair()
            with end:
                self._control.send(REQUEST, FORK)
                self._control.send_socket(end, self._keeper.pid)
                self.channel, self.number = channel, int(self._answer(FORK))
        return ""

    def _answer(self, subject: str) -> Any:
        """Return the keeper's answer to a request."""
        return self._control.receive(
            subject,
            self._keeper.pid,
            until=monotonic() + START,
            is_alive=lambda: not _has_ended(self._keeper),
        )

    @property
    def is_forked(self) -> bool:
        """True where the process that computes is a fork of the keeper, which can fork another."""
        return self.channel is not self._control

    def has_ended(self) -> bool:
        """Return whether the process that computes has ended."""
        # the keeper sends the exit code of its fork
        return self._control.poll() if self.is_forked else _has_ended(self._keeper)

    def end_fork(self, wait: float = 0.0) -> int | None:
        """End the fork and all that it started, and return its exit code.

        Parameters
        ----------
        wait
            Time [s] in which it may end by itself.

        Returns
        -------
        int or None
            None where there is no fork, or where its keeper has ended.
        """
        self._wait(wait)
        if not self.is_forked:
            return None
        end_all(self.number, self._mark, spared=self._keeper.pid)
        self.channel.close()
        self.channel, self.number = self._control, self._keeper.pid
        try:
            return int(self._answer(EXIT_CODE))
        except (ClosedError, ForgedError, LateError):
            return None

    def end(self, wait: float = 0.0) -> int | None:
        """End all processes, after up to `wait` [s] of their own ending, and return the exit code of the keeper."""
        self._wait(wait)
        end_all(self._keeper.pid, self._mark)
        self._keeper.wait()
        assert self._keeper.stdin is not None
        with suppress(OSError):
            self._keeper.stdin.close()
        return self._keeper.returncode

    def _wait(self, seconds: float) -> None:
        """Wait up to `seconds` for the process that computes to end."""
        until = monotonic() + seconds
        while seconds and not self.has_ended() and monotonic() < until:
            sleep(0.01)


def _start(end: socket.socket, mark: str) -> subprocess.Popen[bytes]:
    """Start a keeper with the socket `end`; raise OSError where no more processes can be started.

    The socket is named on its standard input, which stays open until this process ends. The keeper is in a session
    or group of its own, so that Ctrl-C in a terminal reaches this process alone.
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
    """Return the socket of a keeper, the number of its supervisor, and a pipe that closes when the supervisor ends.

    Processes that a case starts inherit neither, and have an empty standard input.
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
    """Fork a keeper into a process in a session of its own; return its number, or 0 in that process itself."""
    with warnings.catch_warnings():
        # about threads of a numerical library, which ends them itself before a fork
        warnings.simplefilter("ignore", DeprecationWarning)
        number = os.fork()
    if number == 0:
        os.setsid()
    return number


def exit_code(number: int) -> int:
    """Wait for the end of a fork and return its exit code; its number stays reserved until :func:`release`."""
    ended = os.waitid(os.P_PID, number, os.WEXITED | os.WNOWAIT)
    assert ended is not None
    return ended.si_status if ended.si_code == os.CLD_EXITED else -ended.si_status


def release(number: int) -> None:
    """Let the system give the number of a fork that has ended to another process."""
    os.waitpid(number, 0)


def end_all(worker: int, mark: str, spared: int | None = None) -> None:
    """Kill the process `worker`, its process group where the system has groups, and all processes with its `mark`.

    The process `spared` has the mark and is not killed.
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
    """Return whether the process has ended; where the system can, its number stays reserved until it is waited for."""
    if process.returncode is not None:
        return True
    if hasattr(os, "waitid"):
        try:
            options = os.WEXITED | os.WNOHANG | os.WNOWAIT
            return os.waitid(os.P_PID, process.pid, options) is not None
        except ChildProcessError:
            pass
    return process.poll() is not None

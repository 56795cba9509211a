"""Messages between a supervisor and its worker process. Each names its subject and the process that sends it."""

import os
import pickle
import socket
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import reduction
from multiprocessing.connection import Connection
from time import monotonic
from typing import Any, Literal

LOOK = 0.25  # seconds between two checks of whether the sender is alive
REQUEST, SETUP, FORK, EXIT_CODE = "request", "set-up", "fork", "exit code"  # subjects besides cases
UNREAD = "reading"  # stage of the failure of several cases that cannot be unpickled together
Task = Literal["compute", "clock"]


class ClosedError(Exception):
    """Raised where the other end is closed, or its process has ended."""


class LateError(Exception):
    """Raised where no message arrived in time."""


class ForgedError(Exception):
    """Raised for a message with another subject or from another process than expected."""


@dataclass(frozen=True)
class Setup:
    """Request to use the supervisor's import paths and its pickled `work`; the answer is an error text, or empty."""

    path: tuple[str, ...]
    work: bytes


@dataclass(frozen=True)
class Batch:
    """Request to compute or to time cases; there is one answer for each, with the subject ``(number, place)``.

    Attributes
    ----------
    number
        Number of the request, which no other request of the supervisor has.
    cases
        All cases, pickled together. If they cannot be unpickled, every answer is a failure.
    names
        Name of each case.
    first
        Place of the first case to compute; earlier ones have been answered.
    task
        Whether to compute or to time.
    limit
        Longest time of a case [s]; None without a limit.
    """

    number: int
    cases: bytes
    names: tuple[str, ...]
    first: int
    task: Task
    limit: float | None


class Channel:
    """Messages over one end of a socket pair."""

    def __init__(self, end: socket.socket) -> None:
        self._connection = Connection(end.detach())
        self.close = self._connection.close

    def send(self, subject: object, message: object) -> None:
        """Send a message; raise :class:`ClosedError` where nobody reads, and any error of pickling."""
        body = pickle.dumps((subject, os.getpid(), message), pickle.HIGHEST_PROTOCOL)
        try:
            self._connection.send_bytes(body)
        except OSError:
            raise ClosedError from None

    def receive(
        self,
        subject: object,
        process: int,
        *,
        until: float | None = None,
        is_alive: Callable[[], bool] = lambda: True,
    ) -> Any:
        """Return the next message.

        Parameters
        ----------
        subject, process
            Subject and sender that the message must have.
        until
            Time (of ``monotonic``) to wait for; None waits without limit.
        is_alive
            Returns whether the sender is alive.

        Raises
        ------
        LateError
            If no message arrived in time.
        ClosedError
            If the other end is closed, or its process has ended.
        ForgedError
            For any other message.
        """
        while not self.poll():
            patience = LOOK if until is None else min(LOOK, max(until - monotonic(), 0.0))
            # checked before the last look: a message sent before the process ended is there at once
            was_alive = is_alive()
            if self.poll(patience):
                break
            if not was_alive:
                raise ClosedError
            if until is not None and monotonic() >= until:
                raise LateError
        try:
            body = self._connection.recv_bytes()
        except (EOFError, OSError):
            raise ClosedError from None
        try:
            *address, message = pickle.loads(body)
        except Exception:  # noqa: BLE001 (a study's own class may do anything)
            raise ForgedError from None
        if address != [subject, process]:
            raise ForgedError
        return message

    def poll(self, seconds: float = 0.0) -> bool:
        """Return whether a message, or the end of the channel, can be read within `seconds`."""
        try:
            return self._connection.poll(seconds)
        except OSError:  # closed in this process: reading raises ClosedError
            return True

    def send_socket(self, other: socket.socket, process: int) -> None:
        """Send a socket to `process`, where the system can, after the message that announces it."""
        try:
            reduction.send_handle(self._connection, other.fileno(), process)
        except OSError:
            raise ClosedError from None

    def receive_socket(self) -> socket.socket:
        """Return the socket that was sent."""
        return socket.socket(fileno=reduction.recv_handle(self._connection))


def channel_pair() -> tuple[Channel, socket.socket]:
    """Return a channel for this process, and the socket of its other end for a worker."""
    end, worker_end = socket.socketpair()
    return Channel(end), worker_end

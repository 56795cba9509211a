"""Messages between a supervisor and its worker: each names its case and its process, and is sealed.

The seal is a keyed hash of the whole message; its key is drawn anew for every case. What a process that
a case has forked may write, or what is left of a message, cannot be taken for the answer of a case.
"""

import hashlib
import secrets
import socket
import struct
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import wait
from time import monotonic
from typing import Literal

KEY = 16  # bytes
# mark, case, process, length of the body, seal
HEADER = struct.Struct("!4sqqQ16s")
MARK = b"cst2"
LOOK = 0.25  # seconds between two looks at whether the other process is alive
LONGEST_WAIT = 1e6  # seconds, which the system's own count of milliseconds can hold
LARGEST = 2**40  # bytes of a body; more is no message
PIECE = 2**20


class ClosedError(Exception):
    """Raised where the other end is gone."""


class LateError(Exception):
    """Raised where no complete message came in time."""


class ForgedError(Exception):
    """Raised for bytes that are not the message of the awaited case and process."""


@dataclass(frozen=True)
class Address:
    """Address of a message: its ``case``, the ``process`` that sends it, and the ``key`` of the case."""

    case: int
    process: int
    key: bytes


def new_key() -> bytes:
    """Draw a key that no message had before."""
    return secrets.token_bytes(KEY)


class Channel:
    """Channel of messages over a socket pair, seen from this process."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end

    def close(self) -> None:
        """Close this end, in this process."""
        self._end.close()

    def __del__(self) -> None:
        """Close the socket, which another thread may have been reading to the end."""
        self._end.close()

    def send_socket(self, other: socket.socket) -> None:
        """Send ``other``, where the system can, after the message that announces it."""
        try:
            socket.send_fds(self._end, [b"-"], [other.fileno()])
        except OSError:
            raise ClosedError from None

    def receive_socket(self) -> socket.socket:
        """Return the socket that was sent."""
        _, descriptors, _, _ = socket.recv_fds(self._end, 1, 1)
        return socket.socket(fileno=descriptors[0])

    def send(self, address: Address, body: bytes) -> None:
        """Send `body`; raise :class:`ClosedError` where nobody reads."""
        try:
            self._end.sendall(_header(address, body) + body)
        except OSError:
            raise ClosedError from None

    def receive(
        self,
        address: Address,
        *,
        until: float | None = None,
        is_alive: Callable[[], bool] = lambda: True,
    ) -> bytes:
        """Return the body of the next message.

        Parameters
        ----------
        address
            Case, process and key that the message must have.
        until
            Time (of ``monotonic``) to wait for; None waits without limit.
        is_alive
            Returns whether the sender is alive.

        Raises
        ------
        LateError
            If no complete message came in time.
        ClosedError
            If the other end is closed, or its process is not alive.
        ForgedError
            For any other message.
        """
        head = self._read(HEADER.size, until, is_alive)
        mark, case, process, length, _ = HEADER.unpack(head)
        if (mark, case, process) != (MARK, address.case, address.process) or length > LARGEST:
            raise ForgedError
        body = self._read(length, until, is_alive)
        if head != _header(address, body):
            raise ForgedError
        return body

    def wait(self, seconds: float) -> bool:
        """Return whether something can be read within `seconds`."""
        try:
            return bool(wait([self._end], min(seconds, LONGEST_WAIT)))
        except (OSError, ValueError):  # closed in this process: reading says so
            return True

    def _read(self, size: int, until: float | None, is_alive: Callable[[], bool]) -> bytes:
        """Return exactly `size` bytes."""
        parts, lacking = [], size
        while lacking:
            if not self.wait(0):
                patience = LOOK if until is None else min(LOOK, until - monotonic())
                # what a process wrote before it died is there at once
                was_alive = is_alive()
                if not self.wait(max(patience, 0.0)):
                    if not was_alive:
                        raise ClosedError
                    if until is not None and monotonic() >= until:
                        raise LateError
                    continue
            try:
                part = self._end.recv(min(lacking, PIECE))
            except OSError:
                part = b""
            if not part:
                raise ClosedError
            parts.append(part)
            lacking -= len(part)
        return b"".join(parts)


def _header(address: Address, body: bytes) -> bytes:
    """Return the header of a message, with its seal."""
    named = struct.pack("!qq", address.case, address.process)
    seal = hashlib.blake2b(body, key=address.key, person=named, digest_size=16).digest()
    return HEADER.pack(MARK, address.case, address.process, len(body), seal)


def channel_pair() -> tuple[Channel, socket.socket]:
    """Make a channel for this process, and the bare socket of its other end for a worker."""
    own_end, other_end = socket.socketpair()
    return Channel(own_end), other_end


Task = Literal["compute", "clock"]
# requests come from one process only, and are addressed with this
REQUEST_KEY, REQUEST = b"\0" * KEY, -1
SETUP, FORK, ENDING = -2, -3, -4  # what is answered, where it is no case
UNREAD = "reading"  # stage of the failure of several cases that cannot be read together


@dataclass(frozen=True)
class Setup:
    """Request to take the supervisor's import paths and its ``work`` (pickled); the answer is an error, or empty."""

    path: tuple[str, ...]
    work: bytes
    key: bytes


@dataclass(frozen=True)
class Fork:
    """Request to fork a process that serves the socket sent after this; the answer is the number of the process."""

    key: bytes


@dataclass(frozen=True)
class Ending:
    """Request for the exit code of the forked ``process``, which has ended or is about to."""

    process: int
    key: bytes


@dataclass(frozen=True)
class Order:
    """Order to compute one case of a batch, or to run it once against the clock.

    The answer, sealed with `key`, is an Outcome; for the clock a Sample or a Failure.

    Attributes
    ----------
    place
        Position of the case in the batch.
    name
        Name of the case.
    key
        Key of the answer.
    task
        Whether to compute or to time.
    limit
        Longest time [s]; None without a limit.
    """

    place: int
    name: str
    key: bytes
    task: Task
    limit: float | None


@dataclass(frozen=True)
class Batch:
    """Request to carry out the orders of a batch, whose cases are pickled together; each order has an answer.

    Cases that cannot be read are answered with a Failure to each order.
    """

    cases: bytes
    orders: tuple[Order, ...]


Request = Setup | Fork | Ending | Batch

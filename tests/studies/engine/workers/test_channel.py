"""Messages between a supervisor and its worker."""

import os
import pickle
import socket
import threading
from collections.abc import Callable
from time import monotonic
from typing import Any

import pytest

from studies.engine.workers import channel
from studies.engine.workers.channel import (
    Channel,
    ClosedError,
    ForgedError,
    LateError,
    channel_pair,
)

SUBJECT, HERE = (7, 3), os.getpid()
PATIENCE = 45.0  # seconds until a message that does not arrive is an error


def received(send: Callable[[Channel], object], process: int = HERE) -> Any:
    ours, theirs = map(Channel, socket.socketpair())
    sending = threading.Thread(target=send, args=(theirs,))
    sending.start()
    try:
        return ours.receive(SUBJECT, process, until=monotonic() + PATIENCE)
    finally:
        ours.close()
        sending.join()


@pytest.mark.parametrize("length", [0, 1, 2**20, 2**21 + 3])
def test_a_message_arrives_whole_whatever_its_length(length: int) -> None:
    body = bytes(range(256)) * (length // 256) + b"x" * (length % 256)
    assert received(lambda end: end.send(SUBJECT, body)) == body


def test_messages_arrive_in_order() -> None:
    ours, theirs = channel_pair()
    other = Channel(theirs)
    for message in ("first", "", "third"):
        other.send(SUBJECT, message)
    until = monotonic() + PATIENCE
    messages = [ours.receive(SUBJECT, HERE, until=until) for _ in range(3)]
    assert messages == ["first", "", "third"]
    ours.close()
    with pytest.raises(ClosedError):
        other.send(SUBJECT, "nobody reads")


def test_a_message_on_another_case_or_from_another_process_is_no_answer() -> None:
    for subject, process in (((7, 4), HERE), ((8, 3), HERE), (SUBJECT, HERE + 1)):
        with pytest.raises(ForgedError):
            received(lambda end, subject=subject: end.send(subject, 1.0), process)  # type: ignore[misc]


@pytest.mark.parametrize("body", [b"no pickle", pickle.dumps(3.0)])
def test_bytes_that_are_no_message_are_no_answer(body: bytes) -> None:
    with pytest.raises(ForgedError):
        received(lambda end: end._connection.send_bytes(body))


def test_a_message_of_a_process_that_has_ended_is_read_before_its_end_is_seen() -> None:
    ours, theirs = map(Channel, socket.socketpair())
    theirs.send(SUBJECT, "its last")
    assert ours.receive(SUBJECT, HERE, is_alive=lambda: False) == "its last"
    # its end is still open in a process that it has started
    with pytest.raises(ClosedError):
        ours.receive(SUBJECT, HERE, is_alive=lambda: False)
    theirs.close()
    with pytest.raises(ClosedError):
        ours.receive(SUBJECT, HERE)


def test_a_message_is_waited_for_until_its_time_and_no_longer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The other process is looked at every so often, and the last look is at the very end."""
    ours, theirs = map(Channel, socket.socketpair())
    waits, now = [], [100.0]
    monkeypatch.setattr(channel, "monotonic", lambda: now[0])

    def poll(seconds: float) -> bool:
        waits.append(seconds)
        now[0] += seconds
        return False

    monkeypatch.setattr(ours._connection, "poll", poll)
    until = 100 + 2.5 * channel.LOOK
    with pytest.raises(LateError):
        ours.receive(SUBJECT, HERE, until=until)
    assert [wait for wait in waits if wait > 0] == pytest.approx(
        [channel.LOOK, channel.LOOK, 0.5 * channel.LOOK]
    )
    assert now[0] == pytest.approx(until)
    theirs.close()

"""Messages between a supervisor and its worker."""

import os
import socket
import threading
from collections.abc import Callable
from dataclasses import replace
from time import monotonic

import pytest

from studies.engine.workers import channel
from studies.engine.workers.channel import (
    Address,
    Channel,
    ClosedError,
    ForgedError,
    LateError,
    channel_pair,
    new_key,
)

RIGHT = Address(3, os.getpid(), b"k" * 16)
PATIENCE = 45.0  # seconds until what does not come is an error


def received(send: Callable[[Channel], object], address: Address = RIGHT) -> bytes:
    ours, theirs = map(Channel, socket.socketpair())
    sending = threading.Thread(target=send, args=(theirs,))
    sending.start()
    try:
        return ours.receive(address, until=monotonic() + PATIENCE)
    finally:
        ours.close()
        sending.join()


@pytest.mark.parametrize("length", [0, 1, channel.PIECE, 2 * channel.PIECE + 3])
def test_a_message_comes_whole_whatever_its_length(length: int) -> None:
    body = bytes(range(256)) * (length // 256) + b"x" * (length % 256)
    assert received(lambda end: end.send(RIGHT, body)) == body


def test_messages_come_one_after_the_other() -> None:
    ours, theirs = channel_pair()
    other = Channel(theirs)
    for body in (b"first", b"", b"third"):
        other.send(RIGHT, body)
    until = monotonic() + PATIENCE
    assert [ours.receive(RIGHT, until=until) for _ in range(3)] == [b"first", b"", b"third"]
    ours.close()
    with pytest.raises(ClosedError):
        other.send(RIGHT, b"nobody reads")


def test_a_message_of_another_case_process_or_key_is_no_answer() -> None:
    for wrong in (
        replace(RIGHT, case=4),
        replace(RIGHT, process=RIGHT.process + 1),
        replace(RIGHT, key=new_key()),
    ):
        with pytest.raises(ForgedError):
            received(lambda end, wrong=wrong: end.send(wrong, b"a number"))  # type: ignore[misc]


def test_a_length_that_no_message_has_is_not_waited_for() -> None:
    head = channel.HEADER.pack(channel.MARK, RIGHT.case, RIGHT.process, 2**62, b"seal")
    with pytest.raises(ForgedError):
        received(lambda end: end._end.sendall(head))


def test_a_changed_byte_is_seen() -> None:
    sealed = channel._header(RIGHT, b"a number")
    with pytest.raises(ForgedError):
        received(lambda end: end._end.sendall(sealed + b"a nvmber"))


def test_what_a_process_wrote_before_it_ended_is_read_and_then_it_is_gone() -> None:
    ours, theirs = map(Channel, socket.socketpair())
    theirs.send(RIGHT, b"its last")
    assert ours.receive(RIGHT, is_alive=lambda: False) == b"its last"
    # its end is still open in a process that it has started
    with pytest.raises(ClosedError):
        ours.receive(RIGHT, is_alive=lambda: False)
    theirs.close()
    with pytest.raises(ClosedError):
        ours.receive(RIGHT)


def test_nothing_is_waited_for_beyond_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """A look at the other process comes every so often, and the last look at the very end."""
    ours, theirs = map(Channel, socket.socketpair())
    waits, now = [], [100.0]
    monkeypatch.setattr(channel, "monotonic", lambda: now[0])

    def wait(ends: object, seconds: float) -> list[object]:
        waits.append(seconds)
        now[0] += seconds
        return []

    monkeypatch.setattr(channel, "wait", wait)
    until = 100 + 2.5 * channel.LOOK
    with pytest.raises(LateError):
        ours.receive(RIGHT, until=until)
    assert [one for one in waits if one > 0] == pytest.approx(
        [channel.LOOK, channel.LOOK, 0.5 * channel.LOOK]
    )
    assert now[0] == pytest.approx(until)
    waits.clear()
    assert not ours.wait(1e300)
    assert waits == [channel.LONGEST_WAIT]
    theirs.close()

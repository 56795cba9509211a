"""One run at a time on one output."""

import errno
import json
import os
import socket
import threading
from pathlib import Path

import psutil
import pytest

from contactstudy import InvalidInput
from studies.store.files import lock as module
from studies.store.files.lock import locked
from tests.conftest import HANGS
from tests.studies.conftest import NEVER, POSIX, quiet


def signed(path: Path, **held: object) -> Path:
    mine = {"pid": os.getpid(), "host": socket.gethostname(), "since": "2026-01-02T03:04:05"}
    path.write_text(json.dumps(mine | held), encoding="utf-8")
    return path


def test_a_file_that_was_removed_or_replaced_is_not_the_one_that_is_open(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    with path.open("w") as file:
        assert module._is_at(file.fileno(), path)
        other = tmp_path / "other"
        other.write_text("another run's")
        assert not module._is_at(file.fileno(), other)
        if os.name == "posix":
            other.replace(path)
            assert not module._is_at(file.fileno(), path)
            path.unlink()
            assert not module._is_at(file.fileno(), path)


def test_the_file_says_who_holds_it_and_is_removed_at_the_end(tmp_path: Path) -> None:
    path = tmp_path / ".study.lock"
    with locked(path, quiet):
        held = json.loads(path.read_text(encoding="utf-8"))
        assert (held["pid"], held["host"]) == (os.getpid(), socket.gethostname())
    assert not path.exists()


@POSIX
def test_who_comes_second_says_who_is_first_and_waits(tmp_path: Path) -> None:
    path = tmp_path / ".study.lock"
    said: list[str] = []
    order: list[str] = []
    waits = threading.Event()

    def log(text: str) -> None:
        said.append(text)
        waits.set()

    def second() -> None:
        with locked(path, log):
            order.append("second")

    thread = threading.Thread(target=second)
    with locked(path, quiet):
        since = json.loads(path.read_text(encoding="utf-8"))["since"]
        thread.start()
        assert waits.wait(HANGS)
        order.append("first")
    thread.join()
    assert order == ["first", "second"]
    holder = f"process {os.getpid()} on {socket.gethostname()} (since {since})"
    assert said == [f"study: waiting for {holder}, which writes to the same output"]
    assert not path.exists()


def test_who_signed_is_read_to_the_letter(tmp_path: Path) -> None:
    path = signed(tmp_path / "lock", pid=17, host="there")
    with path.open() as file:
        held = module._signature(file.fileno())
    assert held == {"pid": 17, "host": "there", "since": "2026-01-02T03:04:05"}
    assert module._who(held) == "process 17 on there (since 2026-01-02T03:04:05)"
    path.write_text("{", encoding="utf-8")
    with path.open() as file:
        assert module._signature(file.fileno()) is None
    assert module._who(None) == "another process"


def test_a_holder_here_is_alive_if_there_is_its_process_and_one_elsewhere_may_be() -> None:
    here = socket.gethostname()
    parent = psutil.Process().ppid()
    assert module._may_be_alive({"pid": parent, "host": here})
    assert not module._may_be_alive({"pid": NEVER, "host": here})
    assert not module._may_be_alive({"pid": os.getpid(), "host": here})
    assert module._may_be_alive({"pid": NEVER, "host": "there"})


def test_without_locks_on_a_file_system_what_the_file_says_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unsupported(descriptor: int, *, wait: bool) -> None:
        raise OSError(errno.ENOLCK, "no locks")

    monkeypatch.setattr(module, "lock", unsupported)
    path = signed(tmp_path / "lock", host="there")
    with pytest.raises(InvalidInput, match=r"is held by process \d+ on there \(since 2026-01-02"):
        locked(path, quiet).__enter__()
    assert path.exists()
    signed(path, pid=NEVER)
    with locked(path, quiet):
        assert json.loads(path.read_text(encoding="utf-8"))["pid"] == os.getpid()


def test_a_lock_that_cannot_be_taken_says_why(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    path.mkdir()
    with pytest.raises(InvalidInput, match=r"cannot be taken .*: remove it or give another folder"):
        locked(path, quiet).__enter__()

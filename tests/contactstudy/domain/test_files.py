import errno
import os
import re
import shutil
import socket
from pathlib import Path
from types import SimpleNamespace

import psutil
import pytest

from contactstudy import InvalidInput
from contactstudy.domain import files as module
from contactstudy.domain.files import (
    is_alive,
    locked,
    read_verified,
    reason,
    remove_partial_files,
    replacing,
    write_with_checksum,
)
from tests.studies.conftest import NEVER


def test_a_file_stays_as_it_was_until_the_new_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "new" / "one.txt"
    with replacing(path) as partial:
        assert partial.parent == path.parent
        assert partial.suffix == ".txt"
        partial.write_text("first")
        assert not path.exists()
    with pytest.raises(ZeroDivisionError), replacing(path) as partial:
        partial.write_text(f"{1 / 0} half")
    assert path.read_text() == "first"
    assert list(path.parent.iterdir()) == [path]


def test_only_partial_files_of_processes_that_ended_are_removed(tmp_path: Path) -> None:
    alive, host = psutil.Process().ppid(), socket.gethostname()
    (tmp_path / "figures").mkdir()
    names = {
        f".a.nc.{NEVER}@{host}.partial.nc": False,
        f"figures/.b.png.{NEVER}@{host}.partial.png": False,
        f".c.nc.{os.getpid()}@{host}.partial.nc": False,  # of an earlier process of that number
        f".d.nc.{alive}@{host}.partial.nc": True,
        f".e.nc.{NEVER}@not-{host}.partial.nc": True,  # whether it runs on another machine is not known
        f"e.nc.{NEVER}@{host}.partial.nc": True,
        ".f.partial": True,
    }
    for name in names:
        (tmp_path / name).write_text("")
    remove_partial_files(tmp_path)
    assert {name: (tmp_path / name).exists() for name in names} == names
    assert (is_alive(alive), is_alive(NEVER), is_alive(10**30)) == (True, False, False)


def test_why_a_file_was_not_written_is_said_in_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, denied = tmp_path / "file", PermissionError(errno.EACCES, "denied")
    assert reason(denied) == "denied"
    assert reason(RuntimeError("NetCDF: HDF error")) == "the file system takes no more"
    assert reason(denied, tmp_path / "removed" / "file") == "its folder was removed"
    for free, said in ((2**20 - 1, "No space left on device"), (2**20, "denied")):
        monkeypatch.setattr(shutil, "disk_usage", lambda _, free=free: SimpleNamespace(free=free))
        assert reason(denied, path) == said


def test_a_file_with_a_checksum_gives_its_content_or_is_found_damaged(tmp_path: Path) -> None:
    path = tmp_path / "state"
    for content in (b"", b"\n", bytes(range(16))):
        write_with_checksum(path, content)
        assert read_verified(path) == content
    raw = path.read_bytes()
    for place in range(len(raw)):
        path.write_bytes(raw[:place] + bytes([raw[place] ^ 1]) + raw[place + 1 :])
        assert read_verified(path) is None
        path.write_bytes(raw[:place])
        assert read_verified(path) is None


def test_a_second_holder_of_a_lock_is_refused_with_the_name_of_the_first(tmp_path: Path) -> None:
    path = tmp_path / ".study.lock"
    with locked(path, "it"):
        holder = path.read_text(encoding="utf-8")
        assert holder.startswith(f"process {os.getpid()} on {socket.gethostname()} (since 20")
        with pytest.raises(InvalidInput, match=re.escape(f"it is locked by {holder}: run again")):
            locked(path, "it").__enter__()
    assert not path.exists()
    path.mkdir()
    with pytest.raises(InvalidInput, match=r"cannot be taken .*: remove it, or give another folder"):
        locked(path, "it").__enter__()


def test_without_locks_on_a_file_system_what_the_file_says_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unsupported(descriptor: int, *, wait: bool) -> None:
        raise OSError(errno.ENOLCK, "no locks")

    monkeypatch.setattr(module, "lock_descriptor", unsupported)
    path = tmp_path / "lock"
    path.write_text(f"process {os.getpid()} on there (since 2026-01-02)", encoding="utf-8")
    with pytest.raises(InvalidInput, match=r"is locked by process \d+ on there \(since 2026-01-02"):
        locked(path, "it").__enter__()
    path.write_text(f"process {NEVER} on {socket.gethostname()} (since 2026-01-02)", encoding="utf-8")
    with locked(path, "it"):
        assert path.read_text(encoding="utf-8").startswith(f"process {os.getpid()} on")

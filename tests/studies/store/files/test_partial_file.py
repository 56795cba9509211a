"""Files that are written whole or not at all."""

import errno
import os
import shutil
from pathlib import Path
from types import SimpleNamespace

import psutil
import pytest

from studies.store.files.descriptor import open_descriptor, read_at, write_whole
from studies.store.files.partial_file import is_alive, reason, remove_partial_files, replacing
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


def test_what_processes_that_ended_left_is_removed_and_nothing_else(tmp_path: Path) -> None:
    alive = psutil.Process().ppid()
    (tmp_path / "figures").mkdir()
    names = {
        f".a.nc.{NEVER}.partial.nc": False,
        f"figures/.b.png.{NEVER}.partial.png": False,
        f".c.nc.{os.getpid()}.partial.nc": False,  # of an earlier process of that number
        f".d.nc.{alive}.partial.nc": True,
        f"e.nc.{NEVER}.partial.nc": True,
        ".f.partial": True,
    }
    for name in names:
        (tmp_path / name).write_text("")
    remove_partial_files(tmp_path)
    assert {name: (tmp_path / name).exists() for name in names} == names
    assert (is_alive(alive), is_alive(NEVER), is_alive(10**30)) == (True, False, False)


def test_why_a_file_was_not_written_is_said_in_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "file"
    link = OSError(errno.ELOOP, "too many links")
    assert reason(link, path) == "it is a symbolic link, which is not followed"
    denied = PermissionError(errno.EACCES, "denied")
    assert reason(denied) == "denied"
    assert reason(RuntimeError("NetCDF: HDF error")) == "the file system takes no more"
    assert reason(RuntimeError("other")) == "other"
    assert reason(denied, tmp_path / "removed" / "file") == "its folder was removed"
    for free, said in ((2**20, "denied"), (2**20 - 1, "No space left on device")):
        monkeypatch.setattr(shutil, "disk_usage", lambda _, free=free: SimpleNamespace(free=free))
        assert reason(denied, path) == said


def test_bytes_are_read_at_a_place_and_written_in_place_of_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where a system has no reading at a place."""
    path = tmp_path / "file"
    descriptor = open_descriptor(path, os.O_RDWR | os.O_CREAT)
    for _ in range(2):
        write_whole(descriptor, b"0123456789")
        assert read_at(descriptor, 3, 4) == b"456"
        write_whole(descriptor, b"abc")
        assert (read_at(descriptor, 10, 0), path.read_bytes()) == (b"abc", b"abc")
        monkeypatch.delattr(os, "pread", raising=False)
    os.close(descriptor)

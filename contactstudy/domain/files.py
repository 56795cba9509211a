"""Files that are written whole or not at all."""

import errno
import json
import os
import re
import shutil
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from time import sleep
from typing import Any

from contactstudy.domain.checks import InvalidInput

NAME = re.compile(r"^\..+\.(\d+)\.partial(\.\w+)?$")
ROOM = 2**20  # bytes: where a disk has less, a library's vague error is for want of room


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path to write to, which takes the place of ``path`` once all is written."""
    path.parent.mkdir(exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial{path.suffix}")
    try:
        yield partial
        partial.replace(path)
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def remove_partial_files(folder: Path) -> None:
    """Remove what processes that were killed have left in ``folder`` and in the folders of figures in it."""
    with suppress(OSError):
        for path in (*folder.glob(".*.partial*"), *folder.glob("*/.*.partial*")):
            named = NAME.match(path.name)
            if named and not is_alive(int(named[1])):
                path.unlink(missing_ok=True)


def is_alive(process: int) -> bool:
    """Whether another process has this number."""
    import psutil  # for those who find such a file

    try:
        return bool(psutil.pid_exists(process)) and process != os.getpid()
    except OverflowError:
        return False


def reason(error: Exception, path: Path | None = None) -> str:
    """Why a file could not be written, in the system's words; ``path`` tells whether there is no room."""
    if isinstance(error, OSError) and error.errno == errno.ELOOP:
        return "it is a symbolic link, which is not followed"
    if path is not None:
        folder = next((one for one in path.parents if one.is_dir()), Path("/"))
        if folder != path.parent:
            return "its folder was removed"
        with suppress(OSError):
            if shutil.disk_usage(folder).free < ROOM:
                return "No space left on device"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    # what HDF5 says of a size limit or a quota
    return "the file system takes no more" if "HDF error" in str(error) else str(error)


# one of the two is there: the first on Linux and macOS, the other on Windows
_fcntl: Any = import_module("fcntl") if find_spec("fcntl") else None
_msvcrt: Any = None if _fcntl else import_module("msvcrt")
# bytes as they are, not for processes that are started, no links, no waiting for a pipe; where there are such flags
ALWAYS = sum(getattr(os, name, 0) for name in ("O_BINARY", "O_CLOEXEC", "O_NOFOLLOW", "O_NONBLOCK"))
# the byte that is locked on Windows: far beyond what is written, which stays readable
LOCKED = 2**30
LOOK = 0.1  # seconds between two tries of a lock on Windows


def open_descriptor(path: Path, flags: int) -> int:
    """A descriptor of ``path``, as bytes; raises OSError, ELOOP for a link."""
    if not hasattr(os, "O_NOFOLLOW") and path.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    return os.open(path, flags | ALWAYS, 0o666)


def read_at(descriptor: int, size: int, start: int) -> bytes:
    """Up to ``size`` bytes from ``start``."""
    if hasattr(os, "pread"):
        return os.pread(descriptor, size, start)
    os.lseek(descriptor, start, os.SEEK_SET)
    return os.read(descriptor, size)


def write_whole(descriptor: int, text: bytes) -> None:
    """``text``, and nothing else, as the contents."""
    os.ftruncate(descriptor, 0)
    os.lseek(descriptor, 0, os.SEEK_SET)
    os.write(descriptor, text)


def lock_descriptor(descriptor: int, *, wait: bool) -> None:
    """Lock the open file until it is closed; without ``wait``, raises BlockingIOError where another has it."""
    if _fcntl:
        _fcntl.flock(descriptor, _fcntl.LOCK_EX if wait else _fcntl.LOCK_EX | _fcntl.LOCK_NB)
        return
    while True:
        os.lseek(descriptor, LOCKED, os.SEEK_SET)
        try:
            _msvcrt.locking(descriptor, _msvcrt.LK_NBLCK, 1)
        except OSError as error:
            if error.errno not in (errno.EACCES, errno.EDEADLK):
                raise
            if not wait:
                raise BlockingIOError(*error.args) from None
            sleep(LOOK)
        else:
            return


UNSUPPORTED = frozenset({errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL})


@contextmanager
def locked(path: Path, log: Callable[[str], object]) -> Iterator[None]:
    """Hold the lock at ``path``; where another run holds it, say which, and wait for it.

    The file says who holds it, and is removed at the end. Where the file system has no locks, that text
    alone is what others go by. Raises :class:`~contactstudy.InvalidInput` for a link in its place, and for
    a holder on another machine of which nobody can say whether it still runs.
    """
    try:
        descriptor = _acquired(path, log)
    except OSError as error:
        raise InvalidInput(
            f"Lock {str(path)!r} cannot be taken ({reason(error, path)}): remove it or give another folder "
            "with --out."
        ) from None
    try:
        yield
    finally:
        with suppress(OSError):  # Windows removes no open file: there it stays, unlocked
            # only ours: the folder may have been removed, and made again by another run
            if _is_at(descriptor, path):
                path.unlink()
        os.close(descriptor)


def _acquired(path: Path, log: Callable[[str], object]) -> int:
    said = False
    while True:
        descriptor = open_descriptor(path, os.O_RDWR | os.O_CREAT)
        try:
            holder = _lock(descriptor, path, wait=said)
            # the last holder may have removed the file between our opening and our locking it
            if holder is None and _is_at(descriptor, path):
                _sign(descriptor)
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)
        if holder is not None:
            log(f"{path.stem.lstrip('.')}: waiting for {holder}, which writes to the same output")
            said = True


def _lock(descriptor: int, path: Path, *, wait: bool) -> str | None:
    """None once it is locked, or else who holds it."""
    try:
        lock_descriptor(descriptor, wait=wait)
    except BlockingIOError:
        return _who(_signature(descriptor))
    except OSError as error:
        if error.errno not in UNSUPPORTED:
            raise
        held = _signature(descriptor)
        if held is not None and _may_be_alive(held):
            raise InvalidInput(
                f"Lock {str(path)!r} is held by {_who(held)}, and this file system cannot tell whether that "
                "still runs: if it does not, remove the file."
            ) from None
    return None


def _is_at(descriptor: int, path: Path) -> bool:
    try:
        there, ours = path.lstat(), os.fstat(descriptor)
    except OSError:
        return False
    return (there.st_ino, there.st_dev) == (ours.st_ino, ours.st_dev)


def _sign(descriptor: int) -> None:
    now = datetime.now(UTC).isoformat(timespec="seconds")
    held = {"pid": os.getpid(), "host": socket.gethostname(), "since": now}
    with suppress(OSError):  # on a full disk it is a lock all the same
        write_whole(descriptor, json.dumps(held).encode())


def _signature(descriptor: int) -> dict[str, object] | None:
    try:
        held = json.loads(read_at(descriptor, 1000, 0))
        return {"pid": int(held["pid"]), "host": str(held["host"]), "since": str(held["since"])}
    except (OSError, ValueError, KeyError, TypeError):  # it has only just been taken
        return None


def _who(held: dict[str, object] | None) -> str:
    if held is None:
        return "another process"
    return f"process {held['pid']} on {held['host']} (since {held['since']})"


def _may_be_alive(held: dict[str, object]) -> bool:
    if held["host"] != socket.gethostname():
        return True
    return is_alive(int(str(held["pid"])))

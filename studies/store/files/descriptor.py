"""Open files where systems differ: how they are opened, read at a place, and locked."""

import errno
import os
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from time import sleep
from typing import Any

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


def lock(descriptor: int, *, wait: bool) -> None:
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

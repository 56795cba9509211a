"""One run at a time on one study's output."""

import errno
import json
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

from contactstudy import InvalidInput
from studies.store.files.descriptor import lock, open_descriptor, read_at, write_whole
from studies.store.files.partial_file import is_alive, reason

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
        lock(descriptor, wait=wait)
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

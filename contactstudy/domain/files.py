"""Files that are written whole or not at all, that show their own damage, and that one process at a time may hold.

Systems differ in how files are opened, read at a place, locked and brought to the disk: here, and nowhere else.
"""

import errno
import hashlib
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
from typing import Any, BinaryIO

from contactstudy.domain.checks import InvalidInput

PARTIAL = re.compile(r"^\..+\.(\d+)\.partial(\.\w+)?$")
ROOM = 2**20  # bytes: where a disk has less, a library's vague error means that it is full
# one of the two is there: the first on Linux and macOS, the other on Windows
_fcntl: Any = import_module("fcntl") if find_spec("fcntl") else None
_msvcrt: Any = None if _fcntl else import_module("msvcrt")
# bytes as they are, not for processes that are started, no links, no waiting for a pipe; where there are such flags
ALWAYS = sum(getattr(os, name, 0) for name in ("O_BINARY", "O_CLOEXEC", "O_NOFOLLOW", "O_NONBLOCK"))
# the byte that is locked on Windows: far beyond what is written, which stays readable
LOCKED_BYTE = 2**30
POLL = 0.1  # seconds between two tries of a lock on Windows
UNSUPPORTED = frozenset({errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL})
SEAL = (
    b"\ncontactstudy "  # at the end of a sealed file, before the digits of a digest of its content
)
DIGEST = 32


def open_descriptor(path: Path, flags: int) -> int:
    """Open ``path`` for bytes and return its descriptor; raises OSError, with ELOOP for a link."""
    if not hasattr(os, "O_NOFOLLOW") and path.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    return os.open(path, flags | ALWAYS, 0o666)


def read_at(descriptor: int, size: int, start: int) -> bytes:
    """Read up to ``size`` bytes from the place ``start`` of an open file."""
    if hasattr(os, "pread"):
        return os.pread(descriptor, size, start)
    os.lseek(descriptor, start, os.SEEK_SET)
    return os.read(descriptor, size)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a path to write to, and put what was written in the place of ``path``, on the disk, when the block ends.

    Until then, and after a kill or an error at any moment, ``path`` is what it was before. The folder of ``path``
    is made if need be.
    """
    path.parent.mkdir(exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial{path.suffix}")
    try:
        yield partial
        with partial.open("r+b") as file:  # Windows brings to the disk only what may be written to
            os.fsync(file.fileno())
        partial.replace(path)
        _sync_folder(path.parent)
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def _sync_folder(folder: Path) -> None:
    """Bring the names in ``folder`` to the disk, where a folder can be opened."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def remove_partial_files(folder: Path) -> None:
    """Remove what killed processes have left in ``folder`` and in the folders in it."""
    with suppress(OSError):
        for path in (*folder.glob(".*.partial*"), *folder.glob("*/.*.partial*")):
            match = PARTIAL.match(path.name)
            if match and not is_alive(int(match[1])):
                path.unlink(missing_ok=True)


def seal(path: Path) -> None:
    """Append a checksum of its content to the file at ``path``; readers of netCDF do not look beyond its end."""
    with path.open("r+b") as file:
        digest = _digest(file, path.stat().st_size)
        file.seek(0, os.SEEK_END)
        file.write(SEAL + digest)


def is_damaged(path: Path) -> bool:
    """Return whether the content of a sealed file differs from what was sealed; not so for a file without a seal."""
    size = path.stat().st_size - len(SEAL) - DIGEST
    if size < 0:
        return False
    with path.open("rb") as file:
        file.seek(size)
        mark, digest = file.read(len(SEAL)), file.read()
        file.seek(0)
        return mark == SEAL and digest != _digest(file, size)


def write_sealed(path: Path, content: bytes) -> None:
    """Write ``content`` under a checksum, in the place of ``path`` and on the disk when this returns."""
    with replacing(path) as partial:
        partial.write_bytes(content)
        seal(partial)


def read_sealed(path: Path) -> bytes | None:
    """Return what :func:`write_sealed` wrote, or None where the file is damaged; raises OSError without a file."""
    raw = path.read_bytes()
    content, mark = raw[: -len(SEAL) - DIGEST], raw[-len(SEAL) - DIGEST : -DIGEST]
    return content if mark == SEAL and not is_damaged(path) else None


def _digest(file: BinaryIO, size: int) -> bytes:
    """Return the digest of the next ``size`` bytes of a file."""
    digest = hashlib.blake2b(digest_size=DIGEST // 2)
    while size and (part := file.read(min(size, ROOM))):
        digest.update(part)
        size -= len(part)
    return digest.hexdigest().encode()


def set_aside(path: Path) -> Path:
    """Rename a damaged file so that it blocks nothing and nothing is lost, and return its new path."""
    damaged = path.with_name(f"{path.name}.damaged")
    path.replace(damaged)
    return damaged


def is_alive(process: int) -> bool:
    """Return whether a process other than this one has the number ``process``."""
    import psutil  # needed only where such a file is found

    try:
        return bool(psutil.pid_exists(process)) and process != os.getpid()
    except OverflowError:
        return False


def reason(error: Exception, path: Path | None = None) -> str:
    """Return in the system's words why a file could not be written; `path` tells whether there is no room."""
    if isinstance(error, OSError) and error.errno == errno.ELOOP:
        return "it is a symbolic link, which is not followed"
    if path is not None:
        folder = next((parent for parent in path.parents if parent.is_dir()), Path("/"))
        if folder != path.parent:
            return "its folder was removed"
        with suppress(OSError):
            if shutil.disk_usage(folder).free < ROOM:
                return "No space left on device"
            if _lacks_inodes(folder):
                return "the disk holds as many files as it can: no inode is left"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    # what HDF5 says of a size limit or a quota
    return "the file system takes no more" if "HDF error" in str(error) else str(error)


def _lacks_inodes(folder: Path) -> bool:
    """Return whether the file system counts its files and can take no other."""
    if not hasattr(os, "statvfs"):
        return False
    counts = os.statvfs(folder)
    return counts.f_files > 0 and counts.f_favail == 0


@contextmanager
def locked(path: Path, log: Callable[[str], object]) -> Iterator[None]:
    """Hold the lock at ``path``; where another process holds it, say which one to ``log``, and wait for it.

    The file names its holder and is removed at the end. Where the file system has no locks, that name alone decides.
    No library is used: those found either cannot tell who holds a lock on every system, or truncate the file.
    Raises :class:`~contactstudy.InvalidInput` for a link in its place, and, without locks, for a holder on another
    machine of which nobody can say whether it still runs.
    """
    try:
        descriptor = _acquire(path, log)
    except OSError as error:
        raise InvalidInput(
            f"Lock {str(path)!r} cannot be taken ({reason(error, path)}): remove it or give another folder "
            "with --out."
        ) from None
    try:
        yield
    finally:
        with suppress(OSError):  # Windows removes no open file: there it stays, unlocked
            # only this one: the folder may have been removed, and made again by another process
            if _is_at(descriptor, path):
                path.unlink()
        os.close(descriptor)


def _acquire(path: Path, log: Callable[[str], object]) -> int:
    """Return the descriptor of the file at ``path``, locked and signed."""
    wait = False
    while True:
        descriptor = open_descriptor(path, os.O_RDWR | os.O_CREAT)
        try:
            holder = _holder(descriptor, path, wait=wait)
            # the last holder may have removed the file between the opening and the locking of it
            if holder is None and _is_at(descriptor, path):
                _sign(descriptor)
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)
        if holder is not None:
            log(f"{path.stem.lstrip('.')}: waiting for {holder}, which writes to the same output")
            wait = True


def _holder(descriptor: int, path: Path, *, wait: bool) -> str | None:
    """Lock the open file and return None, or return in words who holds it."""
    try:
        lock_descriptor(descriptor, wait=wait)
    except BlockingIOError:
        return _in_words(_signature(descriptor))
    except OSError as error:
        if error.errno not in UNSUPPORTED:
            raise
        signature = _signature(descriptor)
        if signature is not None and _may_be_alive(signature):
            raise InvalidInput(
                f"Lock {str(path)!r} is held by {_in_words(signature)}, and this file system cannot tell whether "
                "that still runs: if it does not, remove the file."
            ) from None
    return None


def lock_descriptor(descriptor: int, *, wait: bool) -> None:
    """Lock the open file until it is closed; without ``wait``, raises BlockingIOError where another has it."""
    if _fcntl:
        _fcntl.flock(descriptor, _fcntl.LOCK_EX if wait else _fcntl.LOCK_EX | _fcntl.LOCK_NB)
        return
    while True:
        os.lseek(descriptor, LOCKED_BYTE, os.SEEK_SET)
        try:
            _msvcrt.locking(descriptor, _msvcrt.LK_NBLCK, 1)
        except OSError as error:
            if error.errno not in (errno.EACCES, errno.EDEADLK):
                raise
            if not wait:
                raise BlockingIOError(*error.args) from None
            sleep(POLL)
        else:
            return


def _is_at(descriptor: int, path: Path) -> bool:
    """Return whether the open file is the one at ``path``."""
    try:
        at_path, opened = path.lstat(), os.fstat(descriptor)
    except OSError:
        return False
    return (at_path.st_ino, at_path.st_dev) == (opened.st_ino, opened.st_dev)


def _sign(descriptor: int) -> None:
    """Write this process, its machine and the time as the whole content of the open file."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    signature = {"pid": os.getpid(), "host": socket.gethostname(), "since": now}
    with suppress(OSError):  # on a full disk it is a lock all the same
        os.ftruncate(descriptor, 0)
        os.lseek(descriptor, 0, os.SEEK_SET)
        os.write(descriptor, json.dumps(signature).encode())


def _signature(descriptor: int) -> dict[str, object] | None:
    """Return who signed the open file; None for a file that has only just been made."""
    try:
        signed = json.loads(read_at(descriptor, 1000, 0))
        return {
            "pid": int(signed["pid"]),
            "host": str(signed["host"]),
            "since": str(signed["since"]),
        }
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _in_words(signature: dict[str, object] | None) -> str:
    """Return the name of the process that signed a lock."""
    if signature is None:
        return "another process"
    return f"process {signature['pid']} on {signature['host']} (since {signature['since']})"


def _may_be_alive(signature: dict[str, object]) -> bool:
    """Return whether the process that signed may still run: on another machine, any may."""
    if signature["host"] != socket.gethostname():
        return True
    return is_alive(int(str(signature["pid"])))

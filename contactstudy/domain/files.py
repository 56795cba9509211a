"""Files and the identity of what is in them: atomic replacement, checksums, locks between processes, digests of values.

All differences between operating systems in opening, reading, locking and syncing files are in this module. A digest of
a value says whether a computation was done before; a checksum at the end of a file says whether the file is still as it
was written. Formats of files are not known here.
"""

import errno
import hashlib
import os
import re
import shutil
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass
from datetime import UTC, datetime
from enum import Enum, Flag
from functools import cache, cached_property, partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path, PurePath
from time import sleep
from types import BuiltinFunctionType, CodeType, FunctionType, MappingProxyType, MethodType
from typing import Any, BinaryIO

import numpy as np

from contactstudy.domain.validation import InvalidInput

# What was met in digests: under the id of a dataclass the object, so that no other one gets its id, and its digest;
# under the name of a class the class, and under "def " and the name of a function the function, each with "". From
# these a caller learns which modules a value depends on.
Memo = dict[int | str, tuple[object, str]]
# Types whose repr is their whole state.
PLAIN = (str, int, float, complex, bytes)
# Hexadecimal digits of a digest: 96 bits, so that two of a billion values have the same one by a chance of 1e-11.
DIGITS = 24


def digest(value: object, memo: Memo | None = None) -> str:
    """Return 24 hexadecimal digits that identify `value`: dataclasses, arrays, numbers, text, and containers of them.

    Numbers count with all their digits and with their types: 1, 1.0, True, "1" and numpy's 1 differ, as do 0.0 and
    -0.0. Fields that a dataclass does not compare are left out. A function counts by its name, its own code, its
    defaults and what it encloses, and so do the methods of a class made in a function.

    Parameters
    ----------
    value
        Value of these kinds, to any depth.
    memo
        Dataclasses with their digests, which are not computed again, classes and functions that were met before. Those
        of `value` are added.

    Raises
    ------
    InvalidInput
        For any other object, which may have hidden state, and for two classes of one name.
    """
    return hashed(repr(_parts(value, {} if memo is None else memo)).encode())


def hashed(content: bytes) -> str:
    """Return 24 hexadecimal digits that identify the `content` of a file."""
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def _parts(value: Any, memo: Memo) -> Any:
    """Return a value as text, None, True, False, and tuples of these, which differ where two values differ.

    A container is its class and what it holds; a dataclass is its digest; an array its class, type, shape, strides if
    not contiguous, and a digest of its bytes; a function its name, its code, and what it encloses.
    """
    kind = type(value)
    if value is None or kind is bool:
        return value
    if kind in PLAIN:
        return repr(value)
    name = _name(kind, memo)
    if isinstance(value, Enum):  # a flag of several bits may have no name
        return name, repr(value.value) if isinstance(value, Flag) else value.name
    if isinstance(value, np.ndarray | np.generic):
        if not value.dtype.hasobject and (kind in (np.ndarray, value.dtype.type)):
            # sums over other strides differ in their last bits
            strides = () if value.flags.c_contiguous else value.strides
            content = hashed(np.ascontiguousarray(value).tobytes())
            return name, repr(value.dtype), value.shape, strides, content
    elif is_dataclass(value) and not isinstance(value, type):
        if id(value) not in memo:
            memo[id(value)] = value, hashed(repr((name, _of_dataclass(value, memo))).encode())
        return memo[id(value)][1]
    elif kind in (tuple, list):
        return name, tuple(_parts(item, memo) for item in value)
    elif kind in (dict, MappingProxyType):
        return name, tuple((_parts(k, memo), _parts(v, memo)) for k, v in value.items())
    elif kind in (set, frozenset):
        return name, tuple(sorted(digest(item, memo) for item in value))
    elif isinstance(value, PurePath):
        return name, str(value)
    elif isinstance(value, type | BuiltinFunctionType | np.ufunc):
        return name, f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', value)}"
    elif kind is partial:
        return name, _parts((value.func, value.args, value.keywords), memo)
    elif kind is MethodType:
        return name, _parts((value.__func__, value.__self__), memo)
    elif kind is FunctionType:
        known = f"{value.__module__}.{value.__qualname__}"
        memo[f"def {known}"] = value, ""
        enclosed = tuple(cell.cell_contents for cell in value.__closure__ or ())
        held = value.__defaults__, value.__kwdefaults__, enclosed
        return name, known, _code(value.__code__), _parts(held, memo)
    raise InvalidInput(
        f"What identifies a solve holds {value!r:.100}, whose state cannot be seen: make its class a frozen dataclass."
    )


def _name(kind: type, memo: Memo) -> str:
    """Return module and name of a class; raise InvalidInput if another class has the same."""
    name = f"{kind.__module__}.{kind.__qualname__}"
    if memo.setdefault(name, (kind, ""))[0] is not kind:
        raise InvalidInput(f"Two classes are called {name!r}: give each a name of its own.")
    return name


def _of_dataclass(value: Any, memo: Memo) -> Any:
    """Return pairs of name and parts: of the compared fields of a dataclass and of its further attributes.

    Methods of a class that was made in a function follow, with empty names.
    """
    kind: Any = type(value)
    compared, known = _fields(kind)
    further = getattr(value, "__dict__", {}).keys() - known
    parts = [(name, _parts(getattr(value, name), memo)) for name in (*compared, *sorted(further))]
    if "<locals>" in kind.__qualname__:
        methods = (member for member in vars(kind).values() if isinstance(member, FunctionType))
        # the file of methods that dataclasses makes is "<string>"
        parts += [("", _parts(method, memo)) for method in methods if method.__code__.co_filename != "<string>"]
    return parts


def _code(code: CodeType) -> tuple[object, ...]:
    """Return bytecode, names and constants of a function, which do not depend on its place in a file."""
    constants = (
        _code(constant)
        if isinstance(constant, CodeType)
        else sorted(map(repr, constant))
        if isinstance(constant, frozenset)
        else repr(constant)
        for constant in code.co_consts
    )
    return code.co_code, code.co_names, tuple(constants)


@cache
def _fields(kind: Any) -> tuple[list[str], set[str]]:
    """Return the names of the fields that a dataclass compares, and those of all its fields and cached properties.

    Raises InvalidInput for a dataclass that is a container or a number as well, whose content is no field.
    """
    if issubclass(kind, (*PLAIN, list, tuple, dict, set, frozenset, np.ndarray)):
        raise InvalidInput(
            f"{kind.__qualname__} is a dataclass and a container or number as well: give its content a field."
        )
    every = fields(kind)
    members = [member for base in kind.__mro__ for member in vars(base).items()]
    cached = {name for name, member in members if isinstance(member, cached_property)}
    return [part.name for part in every if part.compare], {part.name for part in every} | cached


# Text of a lock file: process, machine and time of its holder.
HOLDER = re.compile(r"process (\d+) on (.*) \(since .*\)")
# Name of an unfinished file: that of the whole one, with the process that writes it and its machine.
PARTIAL = re.compile(r"^\..+\.(\d+)@(.+)\.partial(\.\w+)?$")
# With less free space [bytes], too little for a file of numbers, an unspecific error of a library is a full disk.
MIN_FREE_BYTES = 2**20
# one of the two exists: the first on Linux and macOS, the other on Windows
_fcntl: Any = import_module("fcntl") if find_spec("fcntl") else None
_msvcrt: Any = None if _fcntl else import_module("msvcrt")
# binary mode, not inherited by child processes, no symbolic links, no waiting for a pipe; as far as the system has them
OPEN_FLAGS = sum(getattr(os, name, 0) for name in ("O_BINARY", "O_CLOEXEC", "O_NOFOLLOW", "O_NONBLOCK"))
# the byte that is locked on Windows: far beyond the content, which stays readable
LOCKED_BYTE = 2**30
POLL_SECONDS = 0.1  # seconds between two tries of a lock on Windows, little beside the writing that it waits for
MAGIC = b"\ncontactstudy "  # at the end of a file with a checksum, before the digits of the checksum of its content
CHECKSUM_DIGITS = 32  # number of these digits
CHUNK = 2**20  # bytes read at a time, so that a large file does not fill the memory


def open_descriptor(path: Path, flags: int) -> int:
    """Open ``path`` for bytes and return its descriptor; raises OSError, with ELOOP for a link."""
    if not hasattr(os, "O_NOFOLLOW") and path.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    return os.open(path, flags | OPEN_FLAGS, 0o666)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path, and replace ``path`` by the file written there when the block ends, synced to the disk.

    Until then, and after a kill or an error at any moment, ``path`` is unchanged. The folder of ``path`` is created if
    it does not exist; the one above it must.
    """
    path.parent.mkdir(exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}@{socket.gethostname()}.partial{path.suffix}")
    try:
        yield partial
        with partial.open("r+b") as file:  # Windows syncs only files that are open for writing
            os.fsync(file.fileno())
        partial.replace(path)
        _sync_folder(path.parent)
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def _sync_folder(folder: Path) -> None:
    """Sync the entries of ``folder`` to the disk, on systems that can open a folder."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def remove_partial_files(folder: Path) -> None:
    """Remove the partial files of this machine's killed processes from ``folder`` and its direct subfolders.

    Call it under the folder's lock: files with this process's own id are taken for those of an earlier one with that id,
    and removed. Those of other machines stay, since whether their processes run is not known.
    """
    with suppress(OSError):
        for path in (*folder.glob(".*.partial*"), *folder.glob("*/.*.partial*")):
            match = PARTIAL.match(path.name)
            if match and match[2] == socket.gethostname() and not is_alive(int(match[1])):
                path.unlink(missing_ok=True)


def append_checksum(path: Path) -> None:
    """Append a checksum of its content to the file at ``path``; readers of netCDF ignore it."""
    with path.open("r+b") as file:
        checksum = _checksum(file, path.stat().st_size)
        file.seek(0, os.SEEK_END)
        file.write(MAGIC + checksum)


def is_damaged(path: Path) -> bool:
    """Return whether the content of a file differs from its checksum; False for a file without one."""
    size = path.stat().st_size - len(MAGIC) - CHECKSUM_DIGITS
    if size < 0:
        return False
    with path.open("rb") as file:
        file.seek(size)
        magic, checksum = file.read(len(MAGIC)), file.read()
        file.seek(0)
        return magic == MAGIC and checksum != _checksum(file, size)


def write_with_checksum(path: Path, content: bytes) -> None:
    """Replace the file at ``path`` by ``content`` and its checksum, synced to the disk."""
    with replacing(path) as partial:
        partial.write_bytes(content)
        append_checksum(partial)


def read_verified(path: Path) -> bytes | None:
    """Return the content written by :func:`write_with_checksum`, or None if it is damaged or has no checksum.

    Raises OSError without a file.
    """
    raw = path.read_bytes()
    content, magic = raw[: -len(MAGIC) - CHECKSUM_DIGITS], raw[-len(MAGIC) - CHECKSUM_DIGITS : -CHECKSUM_DIGITS]
    return content if magic == MAGIC and not is_damaged(path) else None


def _checksum(file: BinaryIO, size: int) -> bytes:
    """Return the checksum of the next ``size`` bytes of a file, in hexadecimal digits."""
    checksum = hashlib.blake2b(digest_size=CHECKSUM_DIGITS // 2)
    while size and (part := file.read(min(size, CHUNK))):
        checksum.update(part)
        size -= len(part)
    return checksum.hexdigest().encode()


def set_aside(path: Path) -> Path:
    """Rename a damaged file, so that it is kept under another name, and return its new path."""
    damaged = path.with_name(f"{path.name}.damaged")
    path.replace(damaged)
    return damaged


def is_alive(process: int) -> bool:
    """Return whether another process with the id ``process`` is running."""
    import psutil  # needed only where an unfinished file or a lock is found

    try:
        return bool(psutil.pid_exists(process)) and process != os.getpid()
    except OverflowError:  # larger than the system's ids
        return False


def reason(error: Exception, path: Path | None = None) -> str:
    """Return the system's reason why a file could not be written.

    With its `path`, a folder that was removed and a full disk are recognised, before the system's own reason.
    """
    if isinstance(error, OSError) and error.errno == errno.ELOOP:
        return "it is a symbolic link, which is not followed"
    if path is not None:
        folder = next((parent for parent in path.parents if parent.is_dir()), Path("/"))
        if folder != path.parent:
            return "its folder was removed"
        with suppress(OSError):
            if shutil.disk_usage(folder).free < MIN_FREE_BYTES:
                return "No space left on device"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    # HDF5 reports a size limit or a quota so
    return "the file system takes no more" if "HDF error" in str(error) else str(error)


@contextmanager
def locked(path: Path, what: str) -> Iterator[None]:
    """Hold the lock at ``path`` during the block; `what` is locked, as the message calls it.

    The file names its holder and is removed at the end. On a file system without locks the holder that the file names
    decides. Raises :class:`~contactstudy.InvalidInput` if another process holds the lock, which the message names, or
    if the lock cannot be taken, as where the path is a symbolic link.
    """
    try:
        descriptor = open_descriptor(path, os.O_RDWR | os.O_CREAT)
    except OSError as error:
        raise InvalidInput(
            f"Lock {str(path)!r} cannot be taken ({reason(error, path)}): remove it, or give another folder."
        ) from None
    try:
        holder = _read_holder(descriptor)
        # a holder that ends removes the file, which may be between the opening and the locking of it
        if not _lock_unless_held(descriptor, holder) or not _is_at(descriptor, path):
            raise InvalidInput(
                f"{what} is locked by {holder or 'another process'}: run again when that has ended, or give another "
                f"folder; if it does not run, remove {str(path)!r}."
            )
        _write_holder(descriptor)
        try:
            yield
        finally:
            with suppress(OSError):  # Windows does not remove an open file: it stays, unlocked
                # only this file: the folder may have been removed, and created again by another process
                if _is_at(descriptor, path):
                    path.unlink()
    finally:
        os.close(descriptor)


def _lock_unless_held(descriptor: int, holder: str) -> bool:
    """Lock the open file, and return True; return False instead if another process holds it.

    On a file system without locks the `holder` that the file names decides: it holds the file if it runs, and on another
    machine always, since whether it runs there is not known.
    """
    try:
        lock_descriptor(descriptor, wait=False)
    except BlockingIOError:
        return False
    except OSError:
        named = HOLDER.fullmatch(holder)
        return named is None or (named[2] == socket.gethostname() and not is_alive(int(named[1])))
    return True


def lock_descriptor(descriptor: int, *, wait: bool) -> None:
    """Lock the open file until it is closed; without ``wait``, raise BlockingIOError if another process holds it."""
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
            sleep(POLL_SECONDS)
        else:
            return


def _is_at(descriptor: int, path: Path) -> bool:
    """Return whether the open file is the one at ``path``."""
    with suppress(OSError):
        return os.path.samestat(path.lstat(), os.fstat(descriptor))
    return False


def _write_holder(descriptor: int) -> None:
    """Write this process, its machine and the time as the whole content of the open file."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    with suppress(OSError):  # on a full disk the lock is held without saying by whom
        os.ftruncate(descriptor, 0)
        os.lseek(descriptor, 0, os.SEEK_SET)
        os.write(descriptor, f"process {os.getpid()} on {socket.gethostname()} (since {now})".encode())


def _read_holder(descriptor: int) -> str:
    """Return process, machine and time from the open lock file; empty for a new file."""
    with suppress(OSError, UnicodeDecodeError):
        os.lseek(descriptor, 0, os.SEEK_SET)
        return os.read(descriptor, 1000).decode()
    return ""

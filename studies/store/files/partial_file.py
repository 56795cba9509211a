"""Files that are written whole or not at all."""

import errno
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

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

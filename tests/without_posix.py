"""A pytest plugin, ``-p tests.without_posix``: the standard library as on Windows, as far as Linux can act it.

Functions, flags and modules that Windows lacks are gone, also in worker processes; sockets are shared and bytes locked
as they are there; a file that this process has open is neither replaced nor removed. What it cannot act: paths, the
console, the end of processes.
"""

import errno
import os
import select
import signal
import socket
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

GONE = {
    os: "O_CLOEXEC O_NOFOLLOW O_NONBLOCK fork forkpty killpg pread pwrite register_at_fork "
    "sched_getaffinity setsid waitid",
    signal: "SIGALRM SIGHUP SIGQUIT alarm pthread_kill setitimer",
    select: "epoll poll",
}
MODULES = ("fcntl", "grp", "pwd", "resource", "termios", "tty")
# they ask when they are imported, and would go on to what only Windows has
KNOW_THE_SYSTEM = ("locket", "psutil", "subprocess")
FOR_WORKERS = f"import runpy\nrunpy.run_path({__file__!r})\n"


def remove() -> None:
    import fcntl

    for name in KNOW_THE_SYSTEM:
        with suppress(ModuleNotFoundError):
            import_module(name)

    sys.modules["msvcrt"] = _msvcrt(fcntl)
    sys.modules.update(dict.fromkeys(MODULES))  # type: ignore[arg-type]
    for module, names in GONE.items():
        for name in names.split():
            vars(module).pop(name, None)
    if hasattr(os, "process_cpu_count"):  # from Python 3.13 on; it asks what is gone
        os.process_cpu_count = os.cpu_count
    for name in ("remove", "rename", "replace", "unlink"):
        setattr(os, name, _refusing(getattr(os, name)))
    socket.socket.share = _share  # type: ignore[attr-defined]
    socket.fromshare = _from_share  # type: ignore[attr-defined]


def _msvcrt(fcntl: ModuleType) -> ModuleType:
    made = ModuleType("msvcrt")

    def locking(descriptor: int, mode: int, size: int) -> None:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OSError(errno.EACCES, "Permission denied") from None

    vars(made).update(locking=locking, LK_NBLCK=2)
    return made


def _refusing(change: Callable[..., Any]) -> Callable[..., Any]:
    def changed(*paths: Any, **named: Any) -> Any:
        if "dir_fd" not in named:
            wanted = {os.path.abspath(path) for path in paths}  # noqa: PTH100
            for number in os.listdir("/proc/self/fd"):  # noqa: PTH208
                try:
                    place = os.readlink(f"/proc/self/fd/{number}")  # noqa: PTH115
                except OSError:
                    continue
                if place in wanted:
                    raise PermissionError(errno.EACCES, "The file is open", place)
        return change(*paths, **named)

    return changed


def _share(end: socket.socket, process: int) -> bytes:
    """Where the other process may fetch a duplicate."""
    path = f"{tempfile.mkdtemp()}/end"
    door = socket.socket(socket.AF_UNIX)
    door.bind(path)
    door.listen()
    copy = end.dup()

    def give() -> None:
        with door, copy, door.accept()[0] as taker:
            socket.send_fds(taker, [b"-"], [copy.fileno()])

    threading.Thread(target=give, daemon=True).start()
    return path.encode()


def _from_share(shared: bytes) -> socket.socket:
    with socket.socket(socket.AF_UNIX) as taker:
        taker.connect(shared.decode())
        return socket.socket(fileno=socket.recv_fds(taker, 1, 1)[1][0])


def act_in_workers() -> None:
    """Worker processes import ``sitecustomize`` from here before all else."""
    folder = Path(tempfile.mkdtemp())
    (folder / "sitecustomize.py").write_text(FOR_WORKERS, encoding="utf-8")
    sys.path.append(str(folder))  # where this process finds what its workers have loaded
    paths = [str(folder), *filter(None, [os.environ.get("PYTHONPATH")])]
    os.environ["PYTHONPATH"] = os.pathsep.join(paths)


remove()
if __name__ == "tests.without_posix":
    act_in_workers()

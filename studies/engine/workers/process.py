"""A worker's process: started with one end of a socket pair, and with a pipe that closes when its supervisor ends."""

import os
import signal
import socket
import subprocess
import sys
from contextlib import suppress

import psutil

MARK = "CONTACTSTUDY_WORKER"  # in the environment of a worker, and so of what it starts
STDIN = 0


def start(end: socket.socket, mark: str) -> subprocess.Popen[bytes]:
    """A process that has ``end``; raises OSError where there can be no more.

    Its standard input says which end that is, and stays open for as long as this process lives. It is in a
    session or group of its own: a terminal's Ctrl-C is for this process.
    """
    # -P: a file of the user's may be called like a module of Python's
    command = [sys.executable, "-P", "-m", "studies.engine.workers.worker"]
    environment = os.environ | {MARK: mark}
    share = getattr(end, "share", None)  # Windows, where a process inherits no sockets
    if share:
        # past the launcher of a virtual environment, whose number is not that of the worker
        environment["__PYVENV_LAUNCHER__"] = sys.executable
        command[0] = getattr(sys, "_base_executable", sys.executable)
    process = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        pass_fds=() if share else (end.fileno(),),
        start_new_session=True,
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        env=environment,
    )
    assert process.stdin is not None
    given = share(process.pid) if share else str(end.fileno()).encode()
    with suppress(OSError):  # it has ended already, which its supervisor will find
        process.stdin.write(f"{os.getpid()} {given.hex()}\n".encode())
        process.stdin.flush()
    return process


def take_over() -> tuple[socket.socket, int, int]:
    """In the worker: its end, the supervisor's number, and a descriptor that can be read when that has ended.

    What a case starts inherits neither, and finds an empty standard input.
    """
    line = b""
    while not line.endswith(b"\n"):
        if not (part := os.read(STDIN, 4096)):
            sys.exit(1)  # the supervisor is gone
        line += part
    supervisor, given = line.decode().split()
    leash = os.dup(STDIN)
    empty = os.open(os.devnull, os.O_RDONLY)
    os.dup2(empty, STDIN)
    os.close(empty)
    shared = bytes.fromhex(given)
    if hasattr(socket, "fromshare"):
        return socket.fromshare(shared), int(supervisor), leash
    os.set_inheritable(int(shared), False)  # noqa: FBT003 (the system's own way)
    return socket.socket(fileno=int(shared)), int(supervisor), leash


def end_all(worker: int, mark: str) -> None:
    """Kill ``worker``, the process group that it leads where there are groups, and all that bears its ``mark``."""
    for process in psutil.process_iter() if mark else ():
        with suppress(psutil.Error, OSError):  # it has ended, or is another user's
            if process.pid not in (worker, os.getpid()) and process.environ().get(MARK) == mark:
                process.kill()
    with suppress(psutil.Error, ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(worker, signal.SIGKILL)
        else:
            psutil.Process(worker).kill()

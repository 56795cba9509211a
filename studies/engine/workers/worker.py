"""A worker's process: started with one end of a socket pair, and with a pipe that closes when its supervisor ends."""

import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
from contextlib import suppress
from typing import Any

import psutil
from threadpoolctl import threadpool_limits

from studies.engine.workers.channel import (
    REQUEST,
    REQUEST_KEY,
    SETUP,
    Address,
    Channel,
    ClosedError,
    ForgedError,
    Order,
    Setup,
)
from studies.engine.workers.compute import compute, failed, timed, warm_up
from studies.model.outcome import Outcome, Work

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


IDLE = 120.0  # seconds without a request after which it ends


def main() -> None:
    """Answer the supervisor's requests, in their order."""
    own = os.getpid()
    end, supervisor, leash = take_over()
    channel = Channel(end)
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=channel.close)
    threading.Thread(target=_end_with_supervisor, args=(leash,), daemon=True).start()
    # an interrupt from outside ends the process, and is no error of the case
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        with threadpool_limits(1):
            _serve(channel, own, supervisor)
    except (ClosedError, ForgedError):
        pass
    # a case may have left threads or exit handlers, for which nobody waits
    os._exit(0)


def _serve(channel: Channel, own: int, supervisor: int) -> None:
    requests = Address(REQUEST, supervisor, REQUEST_KEY)
    work: Work | None = None
    while channel.wait(IDLE):
        for request in pickle.loads(channel.receive(requests)):
            if isinstance(request, Setup):
                problem = ""
                try:
                    sys.path[:] = request.path
                    work = pickle.loads(request.work)
                    warm_up()
                except Exception as error:  # noqa: BLE001 (a study's module may do anything)
                    problem = failed(error, "setup", 0.0).error
                answer: Any = problem
                number, key = SETUP, request.key
            else:
                assert work is not None
                answer, number, key = _answer(request, work), request.number, request.key
            if os.getpid() != own:
                # a case has forked, and this is the other one: the answer is not its to give
                os._exit(0)
            channel.send(Address(number, own, key), _packed(answer))


def _answer(order: Order, work: Work) -> Any:
    try:
        case = pickle.loads(order.case)
    except Exception as error:  # noqa: BLE001 (a study's class may do anything)
        return failed(error, "setup", 0.0)
    if order.task == "clock":
        return timed(case, order.limit)
    return compute(case, work)


def _packed(answer: Any) -> bytes:
    try:
        return pickle.dumps(answer, pickle.HIGHEST_PROTOCOL)
    except Exception as error:  # noqa: BLE001 (a measure's own class may do anything)
        seconds = answer.seconds if isinstance(answer, Outcome) else 0.0
        return pickle.dumps(failed(error, "measure", seconds))


def _end_with_supervisor(leash: int) -> None:
    """End with the other process, whatever ended it: its end of the pipe closes then."""
    try:
        os.read(leash, 1)
    finally:
        end_all(os.getpid(), os.environ.get(MARK, ""))
        os._exit(1)


if __name__ == "__main__":
    main()

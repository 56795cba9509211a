"""Processes that cases have started, which end with the worker process."""

import os
import signal
from contextlib import suppress

import psutil

# environment variable of a worker, inherited by its child processes
WORKER_VARIABLE = "CONTACTSTUDY_WORKER"


def end_all(worker: int, mark: str) -> None:
    """Kill the process `worker`, its descendants and its process group, and all processes with its `mark`."""
    with suppress(psutil.Error):
        for process in psutil.Process(worker).children(recursive=True):
            _kill(process)
    for process in psutil.process_iter():
        with suppress(psutil.Error, OSError):  # it has ended, or is another user's
            if process.environ().get(WORKER_VARIABLE) == mark:
                _kill(process)
    with suppress(ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(worker, signal.SIGKILL)
    with suppress(psutil.Error):
        _kill(psutil.Process(worker))


def _kill(process: psutil.Process) -> None:
    """Kill a process other than this one."""
    if process.pid != os.getpid():
        process.kill()

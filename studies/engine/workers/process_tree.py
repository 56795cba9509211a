"""Processes that cases have started, which end with the worker process."""

import os
import signal
from contextlib import suppress

import psutil

# environment variable of a worker, inherited by its child processes
WORKER_VARIABLE = "CONTACTSTUDY_WORKER"


def kill_process_tree(worker: int, worker_id: str) -> None:
    """Kill the process `worker`, its descendants and its process group, and all processes with its `worker_id`."""
    with suppress(psutil.Error):
        for process in psutil.Process(worker).children(recursive=True):
            _kill(process)
    for process in psutil.process_iter():
        with suppress(psutil.Error, OSError):  # it has ended, or is another user's
            if process.environ().get(WORKER_VARIABLE) == worker_id:
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

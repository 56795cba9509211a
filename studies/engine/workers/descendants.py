"""The processes that a case has started, which must not outlive it."""

import os
import signal
from contextlib import suppress
from pathlib import Path

MARK = "CONTACTSTUDY_WORKER"  # in the environment of a worker, and so of what it starts


def end_all(worker: int, mark: str) -> None:
    """Kill the process group of ``worker``, and what has left the group but bears its ``mark``."""
    for stray in _marked(mark) if mark else ():
        if stray not in (worker, os.getpid()):
            with suppress(ProcessLookupError, PermissionError):
                os.kill(stray, signal.SIGKILL)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(worker, signal.SIGKILL)


def _marked(mark: str) -> list[int]:
    """Where the system shows the environment of processes, as Linux does."""
    wanted = f"{MARK}={mark}".encode()
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if wanted in (folder / "environ").read_bytes().split(b"\0"):
                found.append(int(folder.name))
        except OSError:  # it has ended, or is another user's
            continue
    return found

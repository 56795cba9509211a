"""Cases in a process of their own, so that one that hangs or dies takes no other with it.

Not a pool from a library: those limit and lose a whole batch, where here each case of a batch is known
by itself, and those of multiprocessing may not be started inside a dask worker.
"""

import pickle
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection
from time import perf_counter

import cloudpickle

from studies.model.case import Computation
from studies.model.outcome import CaseStatus, Failure, Outcome, timed_out


class WorkerSupervisor:
    """A child process for ``work`` (pickled), started with the first case and again after each death."""

    def __init__(self, work: bytes) -> None:
        self._work = work
        self._limit: float | None = pickle.loads(work).time_limit
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection | None = None
        self._lock = threading.Lock()
        self._over = threading.Event()

    def run(self, cases: Sequence[Computation]) -> Iterator[Outcome]:
        """The outcome of each case, as soon as there is one; stops short after :meth:`end`."""
        done = 0
        while done < len(cases):
            connection = self._ready()
            if connection is None:
                return
            try:
                connection.send_bytes(cloudpickle.dumps(list(cases[done:])))
            except (BrokenPipeError, ConnectionResetError):  # it had been idle for long, and ended
                self._kill()
                continue
            for _ in cases[done:]:
                start = perf_counter()
                outcome = self._receive(connection, start)
                if self._over.is_set():
                    return
                done += 1
                yield outcome
                if self._process is None:
                    break

    def set_work(self, work: bytes) -> None:
        """Take other ``work`` from here on, in the same process if there is one."""
        self._work, self._limit = work, pickle.loads(work).time_limit
        if self._connection is not None:
            try:
                self._connection.send_bytes(work)
                self._connection.recv()
            except (EOFError, BrokenPipeError, ConnectionResetError):
                self._kill()  # the next one starts with the next case, and says if it cannot

    @property
    def has_ended(self) -> bool:
        """Whether :meth:`end` was called."""
        return self._over.is_set()

    def end(self) -> None:
        """End the process, at once, for good."""
        with self._lock:
            self._over.set()
        self._kill()

    def _receive(self, connection: Connection, start: float) -> Outcome:
        # the child's own alarm comes first, and spares it; here is for what the alarm cannot reach
        patience = None if self._limit is None else 1.1 * self._limit + 0.5
        try:
            if patience is None or connection.poll(patience):
                outcome = pickle.loads(connection.recv_bytes())
                assert isinstance(outcome, Outcome)
                return outcome
        except (EOFError, ConnectionResetError):
            sentence = f"Killed: its process {self._exit_text()} while it was computed"
            failure = Failure("Killed", sentence, "unknown")
            return Outcome(CaseStatus.KILLED, {}, failure, perf_counter() - start)
        self._kill()
        return timed_out(self._limit, "unknown", perf_counter() - start)

    def _ready(self) -> Connection | None:
        with self._lock:
            if self._over.is_set():
                return None
            if self._connection is None:
                ours, its = socket.socketpair()
                with its:
                    # -P: a file of the user's may be called like a module of Python's; its own
                    # session: a terminal's Ctrl-C is for the parent
                    self._process = subprocess.Popen(
                        [sys.executable, "-P", "-m", "studies.engine.worker", str(its.fileno())],
                        stdin=subprocess.PIPE,
                        pass_fds=[its.fileno()],
                        start_new_session=True,
                    )
                self._connection = Connection(ours.detach())
                fresh = True
            else:
                fresh = False
            connection = self._connection
        if fresh:
            try:
                connection.send(sys.path)
                connection.send_bytes(self._work)
                connection.recv()
            except (EOFError, BrokenPipeError, ConnectionResetError):
                if self._over.is_set():
                    return None
                raise ChildProcessError(
                    f"A worker process {self._exit_text()} before its first case: see its message above."
                ) from None
        return connection

    def _exit_text(self) -> str:
        """How the process ended, in words."""
        process = self._process
        self._kill(wait=2.0)
        code = process.returncode if process else None
        if code is None or code >= 0:
            return f"ended with exit code {code}"
        hint = ", perhaps for want of memory" if -code == signal.SIGKILL else ""
        return f"was ended by {signal.Signals(-code).name}{hint}"

    def _kill(self, wait: float = 0.0) -> None:
        with self._lock:
            process, connection = self._process, self._connection
            self._process = self._connection = None
        if process is not None:
            try:
                process.wait(wait)
            except subprocess.TimeoutExpired:
                process.kill()
            process.wait()
            if process.stdin is not None:
                process.stdin.close()
        if connection is not None and not self._over.is_set():
            connection.close()

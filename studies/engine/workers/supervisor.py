"""Cases in a process of their own, so that one that hangs or dies takes no other with it.

Not a pool from a library: those limit and lose a whole batch, where here each case of a batch is known
by itself; they take whatever comes through their pipe for an answer, also from a process that a case has
forked; and those of multiprocessing may not be started inside a dask worker.
"""

import os
import pickle
import secrets
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from time import monotonic, perf_counter
from typing import Any

import cloudpickle

from contactstudy import InvalidInput
from studies.engine.workers.channel import (
    REQUEST,
    REQUEST_KEY,
    SETUP,
    Address,
    Channel,
    ClosedError,
    ForgedError,
    LateError,
    Order,
    Setup,
    Task,
    channel_pair,
    new_key,
)
from studies.engine.workers.compute import failed, timed_out
from studies.engine.workers.worker import end_all, start
from studies.model.case import Computation
from studies.model.outcome import CaseStatus, Failure, Outcome, Sample

START = 120.0  # seconds in which a new process must be ready
STARTS = 3  # processes that may end before their first case
# sent from outside, by a person or for want of memory; a second process shows whether the case was to blame
FROM_OUTSIDE = frozenset({"SIGTERM", "SIGKILL", "SIGINT", "SIGHUP", "SIGQUIT"})
Answer = Outcome | Sample | Failure


class WorkerSupervisor:
    """A worker process for ``work`` (pickled), started with the first case and again after each death."""

    def __init__(self, work: bytes) -> None:
        self._work = work
        self._limit: float | None = pickle.loads(work).time_limit
        self._process: subprocess.Popen[bytes] | None = None
        self._channel: Channel | None = None
        self._mark = ""
        self._lock = threading.Lock()
        self._over = threading.Event()

    def run(self, cases: Sequence[Computation]) -> Iterator[Outcome]:
        """The outcome of each case, as soon as there is one; stops short after :meth:`end`."""
        for answer in self._answers(cases, "compute", self._limit):
            if isinstance(answer, Outcome):
                yield answer
            elif isinstance(answer, Failure):
                yield Outcome(CaseStatus.FAILED, {}, answer)

    def time_once(self, case: Computation, limit: float | None) -> Sample | Failure | None:
        """One run of ``case`` against the clock, or why there is none; None after :meth:`end`."""
        for answer in self._answers([case], "clock", limit):
            return answer.failure if isinstance(answer, Outcome) else answer
        return None

    def set_work(self, work: bytes) -> None:
        """Take other ``work`` from here on, in the same process if there is one."""
        if work == self._work:
            return
        self._work, self._limit = work, pickle.loads(work).time_limit
        channel, process = self._channel, self._process
        if channel is not None and process is not None:
            try:
                self._set_up(channel, process)
            except (ClosedError, ForgedError, LateError):
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

    def _answers(
        self, cases: Sequence[Computation], task: Task, limit: float | None
    ) -> Iterator[Answer]:
        done, again = 0, -1
        while done < len(cases):
            ready = self._ready()
            if ready is None:
                return
            channel, process = ready
            orders = [_order(n, cases[n], task, limit) for n in range(done, len(cases))]
            sendable = [order for order in orders if isinstance(order, Order)]
            try:
                if sendable:
                    _request(channel, sendable)
            except ClosedError:  # it had been idle for long, and ended
                self._kill()
                continue
            for order in orders:
                if not isinstance(order, Order):
                    done += 1
                    yield order
                    continue
                start = perf_counter()
                answer = self._receive(channel, process, order, start)
                if self._over.is_set():
                    return
                if answer is None and again < done:
                    again = done
                    break
                if answer is None:
                    answer = self._killed(process, start)
                done += 1
                yield answer
                if self._process is None:
                    break

    def _receive(
        self, channel: Channel, process: subprocess.Popen[bytes], order: Order, start: float
    ) -> Answer | None:
        """None where the process was ended from outside."""
        # the worker's own alarm comes first, and spares it; here is for what the alarm cannot reach
        until = None if order.limit is None else monotonic() + 1.1 * order.limit + 0.5
        address = Address(order.number, process.pid, order.key)
        try:
            body = channel.receive(address, until=until, is_alive=lambda: not _has_ended(process))
            answer = pickle.loads(body)
            if isinstance(answer, Outcome | Sample | Failure):
                return answer
            raise ForgedError
        except LateError:
            self._kill()
            return timed_out(order.limit, "unknown", perf_counter() - start)
        except ClosedError:
            self._kill(wait=2.0)
            if _signal(process.returncode) in FROM_OUTSIDE:
                return None
            return self._killed(process, start)
        except (ForgedError, pickle.UnpicklingError, EOFError, AttributeError, ImportError):
            self._kill()
            sentence = (
                "ForgedError: what came in place of its answer is from another process or another case; "
                "does it start processes that go on after it?"
            )
            failure = Failure("ForgedError", sentence, "unknown")
            return Outcome(CaseStatus.FAILED, {}, failure, perf_counter() - start)

    def _killed(self, process: subprocess.Popen[bytes], start: float) -> Outcome:
        sentence = f"Killed: its process {_ending(process.returncode)} while it was computed"
        failure = Failure("Killed", sentence, "unknown")
        return Outcome(CaseStatus.KILLED, {}, failure, perf_counter() - start)

    def _ready(self) -> tuple[Channel, subprocess.Popen[bytes]] | None:
        for _ in range(STARTS):
            with self._lock:
                if self._over.is_set():
                    return None
                if self._channel is not None and self._process is not None:
                    return self._channel, self._process
                channel, process = self._start()
            try:
                self._set_up(channel, process)
            except (ClosedError, ForgedError, LateError):
                self._kill(wait=0.5)
                if self._over.is_set():
                    return None
            else:
                return channel, process
        raise InvalidInput(
            f"{STARTS} worker processes ended before their first case, the last "
            f"{_ending(process.returncode)}: see their messages above, or run with --workers 0."
        )

    def _start(self) -> tuple[Channel, subprocess.Popen[bytes]]:
        self._channel, theirs = channel_pair()
        self._mark = secrets.token_hex(8)
        with theirs:
            try:
                self._process = start(theirs, self._mark)
            except OSError as error:
                raise InvalidInput(
                    f"A worker process cannot be started ({error.strerror}): give fewer with --workers."
                ) from None
        return self._channel, self._process

    def _set_up(self, channel: Channel, process: subprocess.Popen[bytes]) -> None:
        key = new_key()
        _request(channel, [Setup(tuple(sys.path), self._work, key)])
        problem = pickle.loads(
            channel.receive(
                Address(SETUP, process.pid, key),
                until=monotonic() + START,
                is_alive=lambda: not _has_ended(process),
            )
        )
        if problem:
            raise InvalidInput(f"The study cannot be read in a worker process: {problem}")

    def _kill(self, wait: float = 0.0) -> None:
        with self._lock:
            process, channel = self._process, self._channel
            self._process = self._channel = None
        if process is not None:
            until = monotonic() + wait
            while not _has_ended(process) and monotonic() < until:
                threading.Event().wait(0.01)
            end_all(process.pid, self._mark)
            process.wait()
            assert process.stdin is not None
            with suppress(OSError):
                process.stdin.close()
        if channel is not None and not self._over.is_set():
            channel.close()


def _order(number: int, case: Computation, task: Task, limit: float | None) -> Order | Outcome:
    try:
        return Order(number, cloudpickle.dumps(case), new_key(), task, limit)
    except Exception as error:  # noqa: BLE001 (a study's class may do anything)
        return failed(error, "setup", 0.0)


def _request(channel: Channel, request: Sequence[Setup | Order]) -> None:
    channel.send(Address(REQUEST, os.getpid(), REQUEST_KEY), pickle.dumps(request))


def _has_ended(process: subprocess.Popen[Any]) -> bool:
    """Whether it has; its number stays its own until it is waited for, where the system can tell so."""
    if process.returncode is not None:
        return True
    if hasattr(os, "waitid"):
        try:
            options = os.WEXITED | os.WNOHANG | os.WNOWAIT
            return os.waitid(os.P_PID, process.pid, options) is not None
        except ChildProcessError:
            pass
    return process.poll() is not None


def _ending(code: int | None) -> str:
    """How a process ended, in words."""
    name = _signal(code)
    hint = ", perhaps for want of memory" if name == "SIGKILL" else ""
    return f"was ended by {name}{hint}" if name else f"ended with exit code {code}"


def _signal(code: int | None) -> str:
    """The name of the signal that ended a process; empty where none did."""
    return signal.Signals(-code).name if code is not None and code < 0 else ""

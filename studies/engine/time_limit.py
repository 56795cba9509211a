"""The time limit of a case: its alarm, the deadline of its supervisor, the limit of a timed run, and its message."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from types import FrameType
from typing import NoReturn

from studies.model.outcome import CaseStatus, Failure, Outcome

LONGEST_ALARM = 1e8  # seconds, three years: the system's timer takes no more
CAN_INTERRUPT = hasattr(signal, "setitimer")


class TimeLimitError(BaseException):
    """Raised in a case that takes too long; not an Exception, so that code of a study does not catch it."""


@contextmanager
def alarm(limit: float | None) -> Iterator[None]:
    """Raise :class:`TimeLimitError` in the block after `limit` [s], in Python code of the main thread.

    Compiled code that never returns is not interrupted, and Windows has no alarm: there the supervisor ends the
    process at its :func:`deadline`.
    """
    if (
        limit is None
        or not CAN_INTERRUPT
        or threading.current_thread() is not threading.main_thread()
    ):
        yield
        return

    def ring(_: int, __: FrameType | None) -> NoReturn:
        raise TimeLimitError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, min(limit, LONGEST_ALARM))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def deadline(limit: float | None) -> float | None:
    """Return the time (of ``monotonic``) at which a supervisor ends a process that its alarm has not reached."""
    return None if limit is None else monotonic() + 1.1 * limit + 0.5


def limit_of_timed_run(expected: float, limit: float | None) -> float:
    """Return the time [s] after which a timed run of a case that took ``expected`` is given up."""
    longest = 5 + 10 * expected
    return longest if limit is None else min(longest, limit)


def timed_out(limit: float | None, stage: str, seconds: float) -> Outcome:
    """Return the outcome of a case that took longer than ``limit`` [s]."""
    sentence = f"TimeLimitError: not done after {limit:g} s; give more with --time-limit"
    return Outcome(CaseStatus.TIMEOUT, {}, Failure("TimeLimitError", sentence, stage), seconds)

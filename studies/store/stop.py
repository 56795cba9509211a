"""Signals that stop a run, such as Ctrl-C, where all results are stored and no library is in the midst of a file."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, Self

# the signals of this system
SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name))
MAX_SIGNALS = 3  # signals after which the process ends at once


class StopRun(BaseException):
    """Raised to stop the run; any other error during a case is a failure of the case."""


class Stop:
    """Record of signals that ask to stop, in a ``with`` statement; outside the main thread none is recorded.

    :meth:`check` raises :class:`StopRun` for a signal that came, and :meth:`interruptible` lets signals raise it at
    once. The block ends with what ends a program that was stopped by the signal: KeyboardInterrupt, or the exit of the
    signal.
    """

    def __init__(self) -> None:
        self.signal: int | None = None
        self._count = 0
        self._is_interruptible = False
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in SIGNALS:
                before = signal.getsignal(number)
                # ignored signals (nohup) stay ignored, and a handler of the caller is kept
                if before in (signal.SIG_DFL, signal.default_int_handler):
                    self._before[number] = signal.signal(number, self._handle)
        return self

    def __exit__(self, kind: type[BaseException] | None, *raised: object) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)
        self._before.clear()
        if self.signal is not None and kind in (None, StopRun):
            is_interrupt = self.signal == signal.SIGINT
            raise KeyboardInterrupt if is_interrupt else SystemExit(128 + self.signal) from None

    def check(self) -> None:
        """Raise :class:`StopRun` if one of the signals came."""
        if self.signal is not None:
            raise StopRun(self.signal)

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """Let a signal raise :class:`StopRun` at any place in the block."""
        self.check()
        self._is_interruptible = True
        try:
            yield
        finally:
            self._is_interruptible = False

    def _handle(self, number: int, _: FrameType | None) -> None:
        """Record a signal; the third one ends the process."""
        self.signal, self._count = number, self._count + 1
        if self._count >= MAX_SIGNALS:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        if self._is_interruptible:
            self._is_interruptible = False
            raise StopRun(number)

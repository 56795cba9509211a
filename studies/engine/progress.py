"""Progress of a run: a bar in a terminal, a line from time to time elsewhere."""

import os
import sys
from collections.abc import Callable
from contextlib import suppress
from time import monotonic
from typing import Self

from tqdm import tqdm

LINE_INTERVAL = 30.0  # seconds between two lines


class Progress:
    """Progress of a job, in a ``with`` statement: number done, rate, and remaining time.

    Parameters
    ----------
    name, what
        Name of the study, and of the job.
    total
        Number of items.
    unit
        Name of an item.
    log
        Takes the lines where there is no terminal.
    """

    def __init__(
        self, name: str, what: str, total: int, unit: str, log: Callable[[str], object]
    ) -> None:
        self._what, self._total, self._unit, self._log = what, total, unit, log
        self._count = 0
        self._start = self._last_line = monotonic()
        self._bar: tqdm[None] | None = None
        if total and _is_terminal():
            self._bar = tqdm(
                total=total, desc=f"{name}: {what}", unit=unit, ncols=_columns(), nrows=24
            )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def add(self, count: int = 1, afterwards: float = 0.0) -> None:
        """Count `count` more items as done.

        Parameters
        ----------
        count
            Number of items.
        afterwards
            Seconds that the timing of all items done so far will take after the job.
        """
        self._count += count
        timing = afterwards * self._total / self._count if self._count else 0.0
        if self._bar is not None:
            if timing:
                self._bar.set_postfix_str(f"then {timing:.0f} s timing", refresh=False)
            self._bar.update(count)
            return
        now = monotonic()
        if now > self._last_line + LINE_INTERVAL and self._count:
            self._last_line = now
            rate = self._count / (now - self._start)
            remaining = (self._total - self._count) / rate
            then = f", and then {timing:.0f} s of timing" if timing else ""
            self._log(
                f"{self._what}, {self._count} of {self._total} {self._unit}s, {rate:.3g} a second, "
                f"{remaining:.0f} s left{then}"
            )


def _is_terminal() -> bool:
    """Return whether the standard error is a terminal."""
    with suppress(AttributeError, ValueError):  # there may be no standard error, or a closed one
        return sys.stderr.isatty()
    return False


def _columns() -> int:
    """Return the width of the terminal; 80 if it does not know its width."""
    with suppress(OSError, ValueError, AttributeError):
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    return 80

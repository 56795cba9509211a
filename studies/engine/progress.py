"""How far a job is: a bar in a terminal, a line now and then elsewhere."""

import os
import sys
from collections.abc import Callable
from contextlib import suppress
from time import monotonic
from typing import Self

from tqdm import tqdm

SELDOM = 30.0  # seconds between two lines


class Progress:
    """Progress through ``total`` things of a ``unit``, in a ``with`` statement: how many, how fast, how long still."""

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
        """Count so many more as done. Timing what is done by now will take ``afterwards`` [s] when all is done."""
        self._count += count
        timing = afterwards * self._total / self._count if self._count else 0.0
        if self._bar is not None:
            if timing:
                self._bar.set_postfix_str(f"then {timing:.0f} s timing", refresh=False)
            self._bar.update(count)
            return
        now = monotonic()
        if now > self._last_line + SELDOM and self._count:
            self._last_line = now
            rate = self._count / (now - self._start)
            remaining = (self._total - self._count) / rate
            then = f", and then {timing:.0f} s of timing" if timing else ""
            self._log(
                f"{self._what}, {self._count} of {self._total} {self._unit}s, {rate:.3g} a second, "
                f"{remaining:.0f} s left{then}"
            )


def _is_terminal() -> bool:
    with suppress(AttributeError, ValueError):  # there may be no standard error, or a closed one
        return sys.stderr.isatty()
    return False


def _columns() -> int:
    """Return the terminal's width; one that does not know its own is taken to be 80 wide."""
    with suppress(OSError, ValueError, AttributeError):
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    return 80

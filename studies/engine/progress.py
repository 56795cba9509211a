"""Progress of a run: a bar in a terminal, a line from time to time elsewhere."""

import shutil
import sys
from contextlib import suppress
from typing import Any

from tqdm import tqdm

from studies.model.plain_text import Log

LINE_INTERVAL = 30.0  # seconds between two lines


def progress_of(name: str, what: str, total: int, unit: str, log: Log) -> "tqdm[Any]":
    """Return the progress of a job `what` of a study, over `total` items that are called `unit`: rate, remaining time.

    Lines go to `log` where there is no terminal.
    """
    shown: dict[str, Any] = {"total": total, "unit": unit, "disable": not total}
    if _is_terminal():
        columns, rows = shutil.get_terminal_size()  # 80 and 24 where it does not know
        return tqdm(**shown, desc=f"{name}: {what}", ncols=columns, nrows=rows)
    line = "{desc}, {n_fmt} of {total_fmt} {unit}s, {rate_fmt}, {remaining} left{postfix}"
    times = {"delay": LINE_INTERVAL, "mininterval": LINE_INTERVAL, "maxinterval": LINE_INTERVAL}
    return tqdm(**shown, **times, desc=what, file=_Lines(log), bar_format=line, leave=False)


class _Lines:
    """A text file whose lines go to a log."""

    def __init__(self, log: Log) -> None:
        self._log = log

    def write(self, text: str) -> None:
        """Take a line, without the control characters that clear a line."""
        if line := text.strip():
            self._log(line)

    def flush(self) -> None:
        """Do nothing."""


def _is_terminal() -> bool:
    """Return whether the standard error is a terminal."""
    with suppress(AttributeError, ValueError):  # there may be no standard error, or a closed one
        return sys.stderr.isatty()
    return False

"""Progress of a run: a bar in a terminal, a line from time to time elsewhere."""

import shutil
import sys
from contextlib import suppress
from typing import Any

from tqdm import tqdm

from studies.model.plain_text import Log

LINE_INTERVAL = 10.0  # seconds between two lines


def bar_of(in_terminal: str, elsewhere: str, log: Log, **shown: Any) -> "tqdm[Any]":
    """Return a bar in one of two forms: in a terminal, or of lines that go to `log`."""
    if not is_terminal():
        return tqdm(**shown | {"bar_format": elsewhere, "file": Lines(log), "leave": False})
    columns, rows = shutil.get_terminal_size()  # 80 and 24 where it does not know
    return tqdm(**shown, bar_format=in_terminal, ncols=columns, nrows=rows)


def progress_of(name: str, what: str, total: int, unit: str, log: Log) -> "tqdm[Any]":
    """Return the progress of a job `what` of a study, over `total` items that are called `unit`.

    Lines go to `log` where there is no terminal.
    """
    names = ("delay", "mininterval", "maxinterval")
    times = {} if is_terminal() else dict.fromkeys(names, LINE_INTERVAL)
    return bar_of(
        "{desc}: {percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} [{elapsed}<{remaining}{postfix}]",
        "{desc}, {n_fmt} of {total_fmt} {unit}s in {elapsed}, {remaining} left{postfix}", log,
        total=total, unit=unit, desc=f"{name}: {what}" if is_terminal() else what, **times,
    )  # fmt: skip


class Lines:
    """A text file whose lines go to a log."""

    def __init__(self, log: Log) -> None:
        self._log = log

    def write(self, text: str) -> None:
        """Take a line, without the control characters that clear a line."""
        if line := text.strip():
            self._log(line)

    def flush(self) -> None:
        """Do nothing."""


def is_terminal() -> bool:
    """Return whether the standard error shows a bar: it is a terminal or the output of a notebook."""
    with suppress(AttributeError, ValueError):  # there may be no standard error, or a closed one
        return type(sys.stderr).__module__.startswith("ipykernel") or sys.stderr.isatty()
    return False

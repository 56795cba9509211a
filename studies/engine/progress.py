"""Progress of a run: a bar in a terminal, a line from time to time elsewhere."""

import shutil
import sys
from contextlib import suppress
from time import monotonic
from typing import Any, Self

from tqdm import tqdm

from studies.model.plain_text import Log, two_digits

LINE_INTERVAL = 10.0  # seconds between two lines


def bar_of(in_terminal: str, elsewhere: str, log: Log, **shown: Any) -> "tqdm[Any]":
    """Return a bar in one of two forms: in a terminal, or of lines that go to `log`."""
    if not is_terminal():
        return tqdm(**shown | {"bar_format": elsewhere, "file": Lines(log), "leave": False})
    columns, rows = shutil.get_terminal_size()  # 80 and 24 where it does not know
    return tqdm(**shown, bar_format=in_terminal, ncols=columns, nrows=rows)


def progress_of(name: str, what: str, total: int, unit: str, log: Log) -> "Progress":
    """Return the progress of a job `what` of a study, over `total` items that are called `unit`.

    Lines go to `log` where there is no terminal.
    """
    names = ("delay", "mininterval", "maxinterval")
    times = {} if is_terminal() else dict.fromkeys(names, LINE_INTERVAL)
    line = "{desc}: {percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} [{elapsed}{postfix}]"
    return Progress(
        bar_of(
            line, "{desc}, {n_fmt} of {total_fmt} {unit}s in {elapsed}{postfix}", log,
            total=total, unit=unit, disable=not total, desc=f"{name}: {what}" if is_terminal() else what, **times,
        )
    )  # fmt: skip


class Progress:
    """Progress over the items of a `bar`, to be used in a ``with`` statement.

    Attributes
    ----------
    count
        Items that are done.
    further
        Seconds that another job will take after this one.
    """

    def __init__(self, bar: "tqdm[Any]") -> None:
        self.bar, self.count, self.further = bar, 0, 0.0
        self._instants = [monotonic()]  # of each item

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.bar.close()

    def update(self) -> None:
        """Count an item that is done."""
        self.count += 1
        self._instants.append(monotonic())
        left = seconds_left(self._instants, int(self.bar.total or 0))
        texts = [f"about {two_digits(left)} s left"] if left is not None else []
        texts += [f"then {two_digits(self.further)} s timing"] if self.further else []
        self.bar.set_postfix_str(", ".join(texts), refresh=False)
        self.bar.update()


def seconds_left(instants: list[float], total: int) -> float | None:
    """Return the seconds that the remaining items of `total` will take; None where that is not known within a factor 2.

    Parameters
    ----------
    instants
        Instant of the beginning, and of the end of each item so far [s].
    total
        Number of all items.

    The last half of the items tells the time of one, without the start of processes, if its two halves agree.
    """
    done = len(instants) - 1
    half, quarter = done // 2, done // 4
    if quarter < 2:
        return None
    begin, middle, end = (instants[done - of] for of in (half, quarter, 0))
    before, after = (middle - begin) / (half - quarter), (end - middle) / quarter
    if not before / 2 < after < 2 * before:
        return None
    return (end - begin) / half * (total - done)


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

"""A bar in a terminal; lines without control characters elsewhere."""

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from studies.engine import progress
from studies.engine.progress import Progress

SCRIPT = """
from studies.engine.progress import Progress
for what in ("solving", "timing", "drawing"):
    with Progress("mine", what, 3, "case", print) as bar:
        for _ in range(3):
            bar.add()
"""


def test_a_terminal_shows_cases_rate_and_time_left() -> None:
    ours, theirs = pty.openpty()
    with os.fdopen(ours, "rb", buffering=0) as terminal:
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT],
            cwd=Path(__file__).parents[3], stdout=subprocess.PIPE, stderr=theirs, check=True,
        )  # fmt: skip
        os.close(theirs)
        shown = b""
        try:
            while part := terminal.read(4096):
                shown += part
        except OSError:  # the other end is closed
            pass
    text = shown.decode()
    for what in ("solving", "timing", "drawing"):
        assert f"mine: {what}: 100%" in text
    assert "3/3 [" in text
    assert "case/s]" in text
    assert done.stdout == b""


def test_elsewhere_lines_say_how_many_how_fast_and_how_long_still(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = iter([0.0, 10.0, 40.0, 50.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(now))
    monkeypatch.setattr(progress, "_is_terminal", lambda: False)
    said: list[str] = []
    with Progress("mine", "solving", 100, "case", said.append) as bar:
        for count in (10, 10, 10):
            bar.add(count)
    assert said == ["solving, 20 of 100 cases, 0.5 a second, 160 s left"]

"""A bar in a terminal; lines without control characters elsewhere."""

import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest

from studies.engine import progress
from studies.engine.progress import progress_of

SCRIPT = """
from studies.engine.progress import progress_of
for what in ("solving", "timing", "drawing"):
    with progress_of("mine", what, 3, "case", print) as bar:
        for _ in range(3):
            bar.update()
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
    monkeypatch.setattr(progress, "_is_terminal", lambda: False)
    said: list[str] = []
    with progress_of("mine", "solving", 100, "case", said.append) as bar:
        bar.start_t = bar.last_print_t = bar.start_t - 40.0  # begun 40 s ago
        bar.update(20)
        bar.update(1)
    assert len(said) == 1
    assert re.fullmatch(r"solving, 20 of 100 cases, +2\.00s/case, 02:40 left", said[0]), said

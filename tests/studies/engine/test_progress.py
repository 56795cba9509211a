import re

import pytest

from studies.engine import progress
from studies.engine.progress import progress_of


def test_lines_say_how_many_how_fast_and_how_long_still(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "_is_terminal", lambda: False)
    said: list[str] = []
    with progress_of("mine", "solving", 100, "case", said.append) as bar:
        bar.start_t = bar.last_print_t = bar.start_t - 40.0  # begun 40 s ago
        bar.update(20)
        bar.update(1)
    assert len(said) == 1
    assert re.fullmatch(r"solving, 20 of 100 cases, +2\.00s/case, 02:40 left", said[0]), said

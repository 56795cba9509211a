import itertools
import re

import pytest

from studies.engine import progress
from studies.engine.progress import progress_of, seconds_left


def instants(*durations: float) -> list[float]:
    return list(itertools.accumulate(durations, initial=100.0))


def test_the_last_items_tell_what_is_left_and_the_start_of_processes_does_not() -> None:
    assert seconds_left(instants(*[2.0] * 20), 100) == pytest.approx(160)
    assert seconds_left(instants(30.0, *[0.5] * 19), 100) == pytest.approx(40)


def test_what_is_not_known_within_a_factor_of_two_is_not_said() -> None:
    assert seconds_left(instants(30.0), 100) is None
    assert seconds_left(instants(*[1.0] * 15, *[5.0] * 5), 100) is None
    # several come back at once
    assert seconds_left(instants(3.0, *[0.0] * 19), 100) is None


def test_lines_say_how_many_and_how_long_still(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "is_terminal", lambda: False)
    monkeypatch.setattr(progress, "LINE_INTERVAL", 0.0)
    monkeypatch.setattr(progress, "monotonic", itertools.count(0, 2).__next__)
    said: list[str] = []
    with progress_of("mine", "solving", 100, "case", said.append) as shown:
        for _ in range(20):
            shown.update()
    assert re.fullmatch(r"solving, 20 of 100 cases in 00:0\d, about 160 s left", said[-1]), said

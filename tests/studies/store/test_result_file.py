"""How often a result is written while cases are computed."""

from types import SimpleNamespace
from typing import Any

import pytest

from studies.store import result_file
from studies.store.result_file import ResultFile


@pytest.mark.parametrize(("took", "pause"), [(0.5, 60.0), (3.0, 60.0), (4.0, 80.0)])
def test_a_write_takes_a_twentieth_of_the_time_and_waits_a_minute_at_least(
    took: float, pause: float, monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    clock = iter((100.0, 100.0 + took))
    monkeypatch.setattr(result_file, "monotonic", lambda: next(clock))
    monkeypatch.setattr(result_file, "assemble", lambda *_: None)
    monkeypatch.setattr(result_file, "write", lambda *_: None)
    monkeypatch.setattr(ResultFile, "_attributes", lambda _: {})
    journal: Any = SimpleNamespace(contents=SimpleNamespace(score={}, samples={}))
    table: Any = SimpleNamespace(axes=(), keys=())
    study: Any = SimpleNamespace(name="x")
    written = ResultFile(study, None, tmp_path, journal, table)  # type: ignore[arg-type]
    written.write()
    assert written.next_write == pytest.approx(100 + took + pause)

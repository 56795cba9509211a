import re
from dataclasses import replace
from pathlib import Path

import pytest

from studies.engine import cost as module
from studies.engine.cost import estimate_cost
from studies.engine.options import RunOptions
from studies.engine.run import run
from tests.studies.engine import trouble
from tests.studies.engine.trouble import RAISES

ONE = RunOptions(workers=0, repeats=0)


def said(numbers: list[float], out: Path, options: RunOptions = ONE) -> list[str]:
    lines: list[str] = []
    run(trouble.study(numbers), out, options=options, log=lines.append)
    return [line.removeprefix("trouble: ") for line in lines]


def test_a_run_counts_what_is_stored_what_is_to_compute_and_what_failed(tmp_path: Path) -> None:
    """Failures are counted where they are requested, in any order of the values."""
    assert not any("stored" in line for line in said([5, RAISES, 1], tmp_path))
    for numbers, stored, missing, failed in (
        ([5, RAISES, 1, 4, 6, 8], 3, 3, 1),
        ([0.5, 5, 4], 2, 1, 0),
        ([0.5, 5, RAISES], 3, 0, 1),
    ):
        lines = said(numbers, tmp_path)
        assert f"{len(numbers)} points, {len(numbers)} distinct cases" in lines
        assert f"{stored} cases are stored, {missing} to compute" in lines
        failures = [line for line in lines if " failed" in line]
        assert [line.split()[:3] for line in failures] == [["1", "of", str(len(numbers))]] * failed
        assert any(str(tmp_path / "trouble.nc") in line for line in lines)


def test_a_dry_run_counts_the_timed_runs_that_are_missing(tmp_path: Path) -> None:
    """Of two good cases with one of three, and of three cases that are not computed yet; none of what failed."""
    said([1, 2, RAISES], tmp_path, replace(ONE, repeats=1))
    lines: list[str] = []
    options = RunOptions(workers=0, repeats=3)
    estimate_cost(trouble.study([1, 2, RAISES, 4, 5, 6]), tmp_path, options=options, log=lines.append)
    assert "6 distinct cases, 3 stored, 3 to compute, 13 timed runs to take" in "\n".join(lines)
    lines.clear()
    estimate_cost(trouble.study([1, 2]), tmp_path, options=ONE, log=lines.append)
    assert "2 stored, 0 to compute, 0 timed runs to take" in "\n".join(lines)


def test_a_dry_run_of_many_points_judges_by_some_of_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MANY_POINTS", 10)
    lines: list[str] = []
    estimate_cost(trouble.study([10.0 + n for n in range(40)]), tmp_path, options=ONE, log=lines.append)
    said_all = "\n".join(lines)
    assert "40 points, estimated from 10 of them in proportion" in said_all
    assert "40 distinct cases, 0 stored, 40 to compute, 0 timed runs to take" in said_all


def test_what_is_solved_says_how_long_its_times_will_take(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundred runs of each of three cases that take 0.01 s."""
    monkeypatch.setattr("studies.engine.progress.LINE_INTERVAL", 0.0)
    options, lines = RunOptions(workers=0, repeats=100), []
    run(trouble.study([1, 2, 4], seconds=0.01), tmp_path, options=options, log=lines.append)
    times = re.findall(r"then ([\d.]+) s timing", "\n".join(lines))
    assert 3 <= float(times[-1]) < 30

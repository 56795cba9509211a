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


def test_a_run_says_how_many_cases_are_stored_and_how_many_are_to_compute(tmp_path: Path) -> None:
    first = said([1, 2, RAISES], tmp_path)
    assert first[0] == "3 points, 3 distinct cases"
    assert not any("are stored" in line for line in first)
    assert any(line.startswith("1 of 3 cases failed, the first with Arith") for line in first)
    second = said([1, 2, RAISES, 4, 5, 6], tmp_path)
    assert second[:2] == ["6 points, 6 distinct cases", "3 cases are stored, 3 to compute"]
    third = said([1, 2, RAISES, 4, 5, 6], tmp_path)
    assert third[:2] == ["6 points, 6 distinct cases", "6 cases are stored, 0 to compute"]
    assert third[-1] == f"wrote {tmp_path / 'trouble.nc'}"


def test_of_values_in_any_order_those_that_failed_are_counted_where_they_are_requested(
    tmp_path: Path,
) -> None:
    said([5, RAISES, 1], tmp_path)
    assert said([0.5, 5, 2], tmp_path)[-1] == f"wrote {tmp_path / 'trouble.nc'}"
    again = said([0.5, 5, RAISES], tmp_path)
    assert any(line.startswith("1 of 3 cases failed, the first with Arith") for line in again)


def test_a_dry_run_counts_the_timed_runs_that_are_missing(tmp_path: Path) -> None:
    """Of two good cases with one of three, and of three cases that are not computed yet; none of what failed."""
    said([1, 2, RAISES], tmp_path, replace(ONE, repeats=1))
    lines: list[str] = []
    options = RunOptions(workers=0, repeats=3)
    estimate_cost(
        trouble.study([1, 2, RAISES, 4, 5, 6]), tmp_path, options=options, log=lines.append
    )
    assert lines[0] == (
        "trouble: 6 points, 6 distinct cases, 3 stored, 3 to compute, 13 timed runs to take"
    )
    lines.clear()
    estimate_cost(trouble.study([1, 2]), tmp_path, options=ONE, log=lines.append)
    assert lines == [
        "trouble: 2 points, 2 distinct cases, 2 stored, 0 to compute, 0 timed runs to take"
    ]


def test_a_dry_run_of_many_points_judges_by_some_of_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "MANY_POINTS", 10)
    lines: list[str] = []
    estimate_cost(
        trouble.study([10.0 + n for n in range(40)]), tmp_path, options=ONE, log=lines.append
    )
    assert lines[:2] == [
        "trouble: 40 points, estimated from 10 of them in proportion",
        "trouble: 40 points, 40 distinct cases, 0 stored, 40 to compute, 0 timed runs to take",
    ]


def test_what_is_solved_says_how_long_its_times_will_take(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hundred runs of each of three cases that take 0.01 s."""
    monkeypatch.setattr("studies.engine.progress.LINE_INTERVAL", 0.0)
    options, lines = RunOptions(workers=0, repeats=100), []
    run(trouble.study([1, 2, 4], seconds=0.01), tmp_path, options=options, log=lines.append)
    times = re.findall(r"then ([\d.]+) s timing", "\n".join(lines))
    assert 3 <= float(times[-1]) < 30

"""What a run says it will do, does and did, counted by hand."""

import inspect
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr

from studies.engine import run as module
from studies.engine import timing
from studies.engine.options import RunOptions
from studies.engine.progress import Progress
from studies.engine.run import estimate_cost, run
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


@pytest.mark.whole
def test_repeats_that_are_missing_are_taken_and_no_more(tmp_path: Path) -> None:
    for repeats, taken in ((1, 1), (3, 3), (2, 3)):
        run(trouble.study([1, 2]), tmp_path, workers=0, repeats=repeats, log=lambda text: None)
        with xr.open_dataset(tmp_path / "trouble.nc") as dataset:
            assert dataset.sizes["repeat"] == taken
            assert int(dataset["solve_time_all"].notnull().sum()) == 2 * taken


def test_every_case_and_every_timed_run_is_counted_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted: dict[str, list[int]] = {}

    class Counted(Progress):
        def __init__(self, name: str, what: str, total: int, *rest: object) -> None:
            super().__init__(name, what, total, *rest)  # type: ignore[arg-type]
            self.what = what
            counted[what] = [total, 0]

        def add(self, count: int = 1, afterwards: float = 0.0) -> None:
            counted[self.what][1] += count
            super().add(count, afterwards)

    monkeypatch.setattr(module, "Progress", Counted)
    monkeypatch.setattr(timing, "Progress", Counted)
    said([1, 2, RAISES, 4, 5], tmp_path, RunOptions(workers=0, repeats=2))
    assert counted == {"solving": [5, 5], "timing": [8, 8]}


def test_changed_cases_are_counted_by_what_changed(tmp_path: Path) -> None:
    said([1, 2, 4], tmp_path)

    def measures(case: object, result: float) -> Mapping[str, float]:
        return {"cube": result**1.5}

    lines: list[str] = []
    other = replace(trouble.study([1, 2, 4]), measures=measures)
    run(other, tmp_path, options=ONE, log=lines.append)
    anew = [line for line in lines if "computed anew" in line]
    assert len(anew) == 1
    assert anew[0].startswith("trouble: 3 stored cases are computed anew, since ")


def test_many_points_are_said_before_their_cases_are_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "MANY", 3)
    for count in (3, 4):
        lines: list[str] = []
        numbers = [10.0 + n for n in range(count)]
        estimate_cost(trouble.study(numbers), tmp_path, options=ONE, log=lines.append)
        made = [line for line in lines if "now made" in line]
        expected = ["trouble: 4 points, whose cases are now made"] if count == 4 else []
        assert made == expected


def test_a_run_has_the_options_of_a_run_by_default() -> None:
    defaults = inspect.signature(run).parameters
    options = RunOptions()
    assert defaults["workers"].default == options.workers
    assert defaults["repeats"].default == options.repeats

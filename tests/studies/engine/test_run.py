import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from threadpoolctl import threadpool_info, threadpool_limits

import contactstudy as cs
from contactstudy import InvalidInput
from studies.engine import cost, progress
from studies.engine.compute import Task
from studies.engine.cost import estimate_cost
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.outcome import CaseStatus, Outcome
from studies.registry import load
from studies.store.netcdf import read
from tests.studies.conftest import quiet
from tests.studies.engine import trouble
from tests.studies.engine.trouble import RAISES, lines

ONE = RunOptions(workers=0, repeats=0)


# What is stored


@pytest.fixture(scope="module")
def dataset(small_run: Path) -> xr.Dataset:
    return read(small_run / "padding.nc")


def test_a_padding_without_images_is_computed_once_and_broadcast(dataset: xr.Dataset) -> None:
    for name in ("pressure_error_l1", "solve_time"):  # times too: were the case run twice, they would differ
        exact = dataset[name].sel(padding="exact")
        assert (exact == exact.isel(images=0)).all()
    superposed = dataset["axis_pressure_error"].sel(padding="superposed", period=0.6, grid=24)
    assert len(set(superposed.values.tolist())) == 3


def test_the_file_says_where_its_numbers_come_from(dataset: xr.Dataset) -> None:
    for name in ("title", "git_revision", "cpu", "timing"):
        assert dataset.attrs[name], name
    # the instant of the first run, and its command
    assert datetime.fromisoformat(dataset.attrs["date_created"]).tzinfo == UTC
    assert dataset.attrs["history"].startswith(dataset.attrs["date_created"] + " ")
    assert f"contactstudy {cs.__version__}" in dataset.attrs["source"]
    assert "LineLoad(per_length=100000.0)" in dataset.attrs["first_case"]


@pytest.mark.whole
def test_a_case_that_another_study_in_the_folder_has_is_not_computed_again(tmp_path: Path) -> None:
    said: list[str] = []
    axes = {"padding": "exact,zero", "images": "1", "period": "2.4"}
    one, other = (load(name).override(axes | {"grid": on}) for name, on in (("padding", "16,24"), ("grid", "16,24,32")))
    first = run(one, tmp_path, workers=0, repeats=1, log=quiet)
    second = run(other, tmp_path, workers=0, repeats=1, log=said.append)
    assert "grid: 4 cases are stored, 2 to compute" in said
    for name in ("pressure_error_l1", "residual", "setup_time_all"):  # to the last bit, and the very same times
        np.testing.assert_array_equal(second[name].isel(grid=[0, 1]), first[name])
    assert np.isfinite(second["solve_time"]).all()


@dataclass(frozen=True)
class Threads(trouble.Square):
    """The largest number of threads of any library for linear algebra."""

    def run(self, prepared: float) -> float:
        np.ones((2, 2)) @ np.ones((2, 2))
        return max(library["num_threads"] for library in threadpool_info())


def test_a_case_has_one_thread_whatever_the_process_had(tmp_path: Path) -> None:
    study = trouble.study_of(Threads, [1.0], lambda case, result: {"threads": result}, "none")
    with threadpool_limits(2):
        assert run(study, tmp_path, workers=0, log=quiet)["threads"].values.tolist() == [1]
        assert Threads(0.0).run(0.0) == 2


def test_workers_and_repeats_stand_above_the_options_and_options_are_checked(tmp_path: Path) -> None:
    dataset = run(trouble.study([1]), tmp_path, options=RunOptions(workers=0), repeats=3, log=quiet)
    assert dataset.sizes["repeat"] == 3
    for name, value in (("workers", -1), ("repeats", 1.5), ("retry", ("all",))):
        with pytest.raises(InvalidInput, match=rf"^RunOptions\.{name}.* is "):
            RunOptions(**{name: value})


def test_one_case_is_computed_on_one_worker_of_those_that_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def on_workers(tasks: list[Task], *_: object, workers: int, **options: object) -> Iterator[tuple[Task, Outcome]]:
        assert workers == len(tasks) == 1
        yield tasks[0], Outcome(CaseStatus.OK, {"square": xr.Variable((), 4.0)})

    monkeypatch.setattr("studies.engine.cluster.perform_on_workers", on_workers)
    dataset = run(trouble.study([2]), tmp_path, options=RunOptions(workers=3, repeats=0), log=quiet)
    assert dataset["square"].values.tolist() == [4.0]


# What a run says


def test_a_run_counts_what_is_stored_what_is_to_compute_and_what_failed(tmp_path: Path) -> None:
    """Failures are counted where they are requested, in any order of the values."""
    run(trouble.study([5, RAISES, 1]), tmp_path, options=ONE, log=quiet)
    for numbers, stored, missing, failed in (([5, RAISES, 1, 4, 6, 8], 3, 3, 1), ([0.5, 5, 4], 2, 1, 0)):
        said: list[str] = []
        run(trouble.study(numbers), tmp_path, options=ONE, log=said.append)
        assert f"trouble: {len(numbers)} points, {len(numbers)} distinct cases" in said
        assert f"trouble: {stored} cases are stored, {missing} to compute" in said
        failures = [line for line in said if " failed" in line]
        assert [line.split()[1:4] for line in failures] == [["1", "of", str(len(numbers))]] * failed


def test_a_run_says_how_many_stored_cases_it_computes_again_and_what_changed(tmp_path: Path) -> None:
    run(trouble.study([1, 2]), tmp_path, options=ONE, log=quiet)
    changed = trouble.study_of(trouble.Trouble, [1, 2, 4], partial(trouble.measures))
    for again in (["trouble: 2 stored cases are computed again, since the study's measures changed"], []):
        said: list[str] = []
        run(changed, tmp_path, options=ONE, log=said.append)
        assert [line for line in said if "computed again" in line] == again


def test_a_dry_run_counts_the_timed_runs_that_are_missing_and_judges_many_points_by_some(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(trouble.study([1, 2, RAISES]), tmp_path, options=replace(ONE, repeats=1), log=quiet)
    said: list[str] = []
    options = replace(ONE, repeats=3)
    # two of each good case, three of each that is not computed yet; none of what failed
    assert estimate_cost(trouble.study([1, 2, RAISES, 4, 5, 6]), tmp_path, options=options, log=said.append) is None
    assert "6 distinct cases, 3 stored, 3 to compute, 13 timed runs to take" in said[-2]
    assert "the time is not known: its cases are not scenes on a grid" in said[-1]
    monkeypatch.setattr(cost, "MANY_POINTS", 10)
    estimate_cost(trouble.study([10.0 + n for n in range(40)]), tmp_path, options=ONE, log=said.append)
    assert "40 distinct cases, 0 stored, 40 to compute, 0 timed runs to take" in said[-2]


def test_the_time_of_what_is_missing_is_that_of_its_own_plans(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study = load("grid").override({"padding": "duplicated", "grid": "16"})
    run(study, tmp_path, options=ONE, log=quiet)
    planned: list[float] = []
    plan = cs.plan

    def recorded(scene: cs.Scene, *, grid: cs.Grid, **others: Any) -> Any:
        if grid.cells[0] > 24:
            raise InvalidInput(f"plan.padding is {others['padding']}: give another.")
        found = plan(scene, grid=grid, **others)
        planned.append(found.seconds)
        return found

    monkeypatch.setattr("contactstudy.plan", recorded)
    assert estimate_cost(study, tmp_path, options=ONE, log=quiet) == 0
    assert estimate_cost(study.override({"grid": "16,24"}), tmp_path, options=ONE, log=quiet) == planned[0] > 0
    assert len(planned) == 1
    said: list[str] = []
    assert estimate_cost(study.override({"grid": "32"}), tmp_path, options=ONE, log=said.append) is None
    assert said[-1].endswith("failed (InvalidInput: plan.padding is DuplicatedPadding(): give another.)")


def test_lines_say_how_many_and_how_long_their_times_will_take(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(progress, "is_terminal", lambda: False)
    monkeypatch.setattr(progress, "LINE_INTERVAL", 0.0)
    said: list[str] = []
    run(trouble.study([1, 2, 4]), tmp_path, options=replace(ONE, repeats=2), log=said.append)
    shown = [line for line in said if "solving" in line]
    assert re.fullmatch(r"trouble: solving, 3 of 3 cases in \d\d:\d\d, \d\d:\d\d left, then [\d.]+ s timing", shown[-1])


# Times


@pytest.mark.whole
def test_stored_times_are_not_taken_again_unless_asked(tmp_path: Path) -> None:
    log = tmp_path / "log"
    study = trouble.study([1.0, 2.0], log=str(log))

    def times(**settings: Any) -> tuple[np.ndarray, int]:
        before = len(lines(log))
        data = run(study, tmp_path, options=replace(ONE, **settings), log=quiet)["solve_time_all"].values
        return data, len(lines(log)) - before

    first, _ = times(repeats=2)
    again, taken = times(repeats=2)
    np.testing.assert_array_equal(first, again)
    assert taken == 0
    more, taken = times(repeats=3)
    np.testing.assert_array_equal(first, more[:, :2])
    assert taken == 2  # what was missing; the process is warm since the first run
    # by count, for two times may agree to the clock's last digit
    assert times(repeats=2, retry=("times",))[1] == 2 * 2


@dataclass(frozen=True)
class Once(trouble.Trouble):
    """A case that can be computed once, if it is that of 2."""

    def run(self, prepared: float) -> float:
        if self.number == 2 and "2.0" in lines(Path(self.log)):
            raise ArithmeticError
        return super().run(prepared)


def test_a_case_that_cannot_be_timed_is_given_up_and_the_others_are_timed(tmp_path: Path) -> None:
    log, said = tmp_path / "log", []
    study = trouble.study_of(lambda number: Once(number, log=str(log)), [1, 2, 4])
    dataset = run(study, tmp_path, options=RunOptions(workers=0, repeats=3), log=said.append)
    assert (dataset["case_status"] == CaseStatus.OK).all()
    assert dataset["solve_time_all"].notnull().sum("repeat").values.tolist() == [3, 0, 3]
    assert lines(log)[-6:] == ["1.0", "4.0"] * 3  # in turn
    assert any("1 case has no times, the first since ArithmeticError" in line for line in said)
    untimed = run(replace(study, times="none"), tmp_path / "other", options=RunOptions(workers=0), log=quiet)
    assert "solve_time" not in untimed

"""A smaller run does not shrink the file."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.axis import Axis
from studies.model.outcome import CaseStatus
from studies.model.study import Point, Study
from tests.studies.conftest import quiet
from tests.studies.engine.trouble import Trouble, measures

ALONE = RunOptions(workers=0, repeats=0)


def table(numbers: tuple[float, ...], offsets: tuple[float, ...]) -> Study:
    def scene_at(point: Point) -> Trouble:
        return Trouble(float(point["number"]), float(point["offset"]))

    axes = (Axis("number", numbers, "what is squared"), Axis("offset", offsets, "what is added"))
    return Study("table", "Sums.", axes, scene_at, measures)


def test_a_smaller_run_leaves_what_is_stored_in_the_file(tmp_path: Path) -> None:
    before = run(table((1.0, 2.0), (0.0, 10.0)), tmp_path, options=ALONE, log=quiet)
    after = run(table((2.0,), (10.0,)), tmp_path, options=ALONE, log=quiet)
    np.testing.assert_array_equal(before["square"], after["square"])
    assert after["number"].values.tolist() == [1.0, 2.0]


def test_what_is_missing_in_the_larger_table_is_not_run(tmp_path: Path) -> None:
    run(table((1.0, 2.0), (0.0,)), tmp_path, options=ALONE, log=quiet)
    dataset = run(table((4.0,), (10.0,)), tmp_path, options=ALONE, log=quiet)
    assert dataset["number"].values.tolist() == [1.0, 2.0, 4.0]
    ok, not_run = int(CaseStatus.OK), int(CaseStatus.NOT_RUN)
    assert dataset["case_status"].values.tolist() == [[ok, not_run], [ok, not_run], [not_run, ok]]
    assert dataset["square"].sel(number=4.0, offset=10.0).item() == 26.0
    assert np.isnan(dataset["square"].sel(number=4.0, offset=0.0))


def test_only_what_is_asked_for_on_request(tmp_path: Path) -> None:
    run(table((1.0, 2.0), (0.0,)), tmp_path, options=ALONE, log=quiet)
    only = replace(ALONE, table="requested")
    dataset = run(table((2.0,), (0.0,)), tmp_path, options=only, log=quiet)
    assert dataset["number"].values.tolist() == [2.0]
    whole = run(table((2.0,), (0.0,)), tmp_path, options=ALONE, log=quiet)
    assert whole["number"].values.tolist() == [1.0, 2.0]


def test_a_value_of_which_nothing_is_stored_leaves_no_empty_row(tmp_path: Path) -> None:
    study = table((1.0, 3.0), (0.0,))  # the latter raises
    stop = replace(ALONE, after_failure="stop")
    run(table((3.0, 7.0), (0.0,)), tmp_path, options=stop, log=quiet)  # 7 is never reached
    dataset = run(study, tmp_path, options=ALONE, log=quiet)
    assert dataset["number"].values.tolist() == [1.0, 3.0]

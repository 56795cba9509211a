from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from contactstudy import InvalidInput
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.outcome import CaseStatus, Sample, is_contended, timing_variables
from tests.studies.conftest import quiet
from tests.studies.engine import trouble


def sample(wall: float, cpu: float | None = None) -> Sample:
    return Sample(0.25 * wall, 0.75 * wall, 0.0, wall if cpu is None else cpu, 1)


@pytest.mark.parametrize(
    ("samples", "is_flagged"),
    [
        ([sample(1.0), sample(1.05)], False),
        ([sample(1.0), sample(3.0), sample(1.02)], False),
        ([sample(1.0), sample(1.2)], True),
        ([sample(1.0)], True),
        ([sample(1.0, cpu=0.8), sample(1.0)], True),
        ([sample(1.0), sample(1.05, cpu=0.5)], False),
    ],
)
def test_a_time_that_no_repeat_confirms_or_that_lacked_the_processor_is_flagged(
    samples: list[Sample], is_flagged: object
) -> None:
    assert is_contended(samples) is is_flagged


def test_a_time_taken_while_the_processor_was_slow_is_flagged() -> None:
    slow = [replace(sample(1.0), pace=1.2e-3)] * 2
    assert is_contended(slow, pace=1e-3)
    assert not is_contended(slow, pace=1.15e-3)


def test_every_sample_is_kept_with_least_median_and_processor_time() -> None:
    data = timing_variables(
        ("n",), np.arange(3), [[sample(1.0), sample(3.0), sample(2.0)], [sample(4.0)], []]
    )
    assert data["solve_time"].values[:2] == pytest.approx([0.75, 3.0])
    assert data["solve_time_median"].values[0] == pytest.approx(1.5)
    assert data["solve_time_cpu"].values[0] == pytest.approx(1.0)
    assert data["solve_time_all"].dims == ("n", "repeat")
    assert data["solve_time_all"].values[0] == pytest.approx([0.75, 2.25, 1.5])
    assert np.isnan(data["solve_time"].values[2])
    assert data["contended"].values.tolist() == [1, 1, 2]


@pytest.mark.whole
def test_stored_times_are_not_taken_again_unless_asked(tmp_path: Path) -> None:
    log = tmp_path / "log"
    study = trouble.study([1.0, 2.0], log=str(log))

    def times(settings: RunOptions) -> tuple[np.ndarray, int]:
        before = len(log.read_text(encoding="utf-8").splitlines()) if log.exists() else 0
        data = run(study, tmp_path, options=settings, log=quiet)["solve_time_all"].values
        return data, len(log.read_text(encoding="utf-8").splitlines()) - before

    once = RunOptions(workers=0, repeats=2)
    first, _ = times(once)
    again, taken = times(once)
    np.testing.assert_array_equal(first, again)
    assert taken == 0
    more, taken = times(replace(once, repeats=3))
    np.testing.assert_array_equal(first, more[:, :2])
    assert taken == 1 + 2 * 1  # a warm-up for two cases of a kind, and what was missing
    # by count, for two times may agree to the clock's last digit
    _, taken = times(replace(once, old_times="dropped"))
    assert taken == 1 + 2 * 2


def test_a_study_that_wants_no_times_is_not_timed(tmp_path: Path) -> None:
    log = tmp_path / "log"
    study = replace(trouble.study([1.0, 2.0], log=str(log)), times="none")
    dataset = run(study, tmp_path, options=RunOptions(workers=0), log=quiet)
    assert len(log.read_text(encoding="utf-8").splitlines()) == 2
    assert dataset["contended"].values.tolist() == [2, 2]
    with pytest.raises(InvalidInput, match=r"^times is 'some'"):
        replace(study, times="some")


@dataclass(frozen=True)
class Once(trouble.Trouble):
    """A case that can be computed once, if it is that of 2."""

    def run(self, prepared: float) -> float:
        log = Path(self.log)
        if log.exists() and self.number == 2 and "2.0" in log.read_text(encoding="utf-8"):
            raise ArithmeticError
        return super().run(prepared)


def test_a_case_that_cannot_be_timed_is_given_up_and_the_others_are_timed(tmp_path: Path) -> None:
    log, said = tmp_path / "log", []
    study = replace(
        trouble.study([1.0, 2.0, 4.0]),
        scene_at=lambda point: Once(float(point["number"]), log=str(log)),
    )
    dataset = run(study, tmp_path, options=RunOptions(workers=0, repeats=3), log=said.append)
    assert (dataset["case_status"] == CaseStatus.OK).all()
    counts = dataset["solve_time_all"].notnull().sum("repeat")
    assert counts.values.tolist() == [3, 0, 3]
    runs = log.read_text(encoding="utf-8").split()
    assert runs[-6:] == ["1.0", "4.0"] * 3  # in turn
    assert any("1 cases have no times, the first since ArithmeticError" in line for line in said)

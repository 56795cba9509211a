from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from contactstudy import InvalidInput
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.outcome import CaseStatus
from tests.studies.conftest import quiet
from tests.studies.engine import trouble


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
    assert taken == 2  # what was missing; the process is warm since the first run
    # by count, for two times may agree to the clock's last digit
    _, taken = times(replace(once, retry=("times",)))
    assert taken == 2 * 2


def test_a_study_that_wants_no_times_is_not_timed(tmp_path: Path) -> None:
    log = tmp_path / "log"
    study = replace(trouble.study([1.0, 2.0], log=str(log)), times="none")
    dataset = run(study, tmp_path, options=RunOptions(workers=0), log=quiet)
    assert len(log.read_text(encoding="utf-8").splitlines()) == 2
    assert "solve_time" not in dataset
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
    study = trouble.study_of(lambda number: Once(number, log=str(log)), [1, 2, 4])
    dataset = run(study, tmp_path, options=RunOptions(workers=0, repeats=3), log=said.append)
    assert (dataset["case_status"] == CaseStatus.OK).all()
    counts = dataset["solve_time_all"].notnull().sum("repeat")
    assert counts.values.tolist() == [3, 0, 3]
    runs = log.read_text(encoding="utf-8").split()
    assert runs[-6:] == ["1.0", "4.0"] * 3  # in turn
    assert any("1 case has no times, the first since ArithmeticError" in line for line in said)

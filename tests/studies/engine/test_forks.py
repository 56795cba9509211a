import ctypes
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.outcome import CaseStatus
from studies.model.study import Study
from tests.studies.conftest import POSIX, python, quiet
from tests.studies.engine.trouble import Square, study_of

NUMBERS = 30
FORKING = 5


def fork() -> None:
    os.fork()


def fork_of_c() -> None:
    ctypes.CDLL(None).fork()


FORKS = {one.__name__: one for one in (fork, fork_of_c)}


@dataclass(frozen=True)
class Forking(Square):
    how: str

    def run(self, prepared: float) -> float:
        if self.number == FORKING:
            FORKS[self.how]()
        return super().run(prepared)


def measures(case: Forking, result: float) -> dict[str, float]:
    return {"square": result, "own": case.number}


def study(how: str) -> Study:
    return study_of(lambda number: Forking(number, how), range(NUMBERS), measures, "none")


@POSIX
@pytest.mark.parametrize("how", FORKS)
def test_each_point_has_its_own_number(how: str, tmp_path: Path) -> None:
    dataset = run(study(how), tmp_path, options=RunOptions(workers=1, repeats=0), log=quiet)
    good = dataset["case_status"] == CaseStatus.OK
    others = dataset["number"] != FORKING
    assert (good | ~others).all()
    for name, expected in (("own", dataset["number"]), ("square", dataset["number"] ** 2)):
        np.testing.assert_array_equal(dataset[name].where(good, expected), expected)


SCRIPT = """
import sys
from pathlib import Path
from studies.engine.options import RunOptions
from studies.engine.run import run
from tests.studies.engine.test_forks import study
run(study("fork"), Path(sys.argv[1]), options=RunOptions(workers=0, repeats=0))
"""


@pytest.mark.whole
@POSIX
def test_a_case_that_forks_without_workers_does_not_make_two_runs(tmp_path: Path) -> None:
    done = python(SCRIPT, tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("wrote") == 1
    dataset = xr.load_dataset(tmp_path / "trouble.nc")
    np.testing.assert_array_equal(dataset["own"], dataset["number"])
    lines = (tmp_path / "cases.jsonl").read_bytes().splitlines()
    assert sum(b'"status":' in line for line in lines) == NUMBERS

import os
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

from studies.engine.run import run
from studies.model.study import Study
from studies.registry import load

# for tests that send signals, fork, or read what a shell of POSIX says
POSIX = pytest.mark.skipif(not hasattr(os, "killpg"), reason="this system has no POSIX signals")
NEVER = 2**22 + 1  # beyond the numbers that processes have
SMALL = {"images": "0:2", "period": "0.6,2.4", "grid": "16,24"}


def quiet(_: str) -> None:
    """For ``log``."""


def python(script: str, *words: object) -> subprocess.CompletedProcess[str]:
    """Run a script in a process of its own, in the folder of the project."""
    return subprocess.run(
        [sys.executable, "-c", script, *map(str, words)],
        cwd=Path(__file__).parents[2], capture_output=True, text=True,
    )  # fmt: skip


def measured(name: str, **point: object) -> xr.Dataset:
    """What a study stores of one case; an axis that is not given has its first value."""
    study = load(name)
    case = study.case_at({axis.name: axis.values[0] for axis in study.axes} | point)
    result = case.run(case.prepare())
    return xr.Dataset(case.record(result) | study.measures(case, result))


@pytest.fixture(scope="session")
def small_study() -> Study:
    return load("padding").override(SMALL)


@pytest.fixture(scope="session")
def small_run(small_study: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with padding.nc, computed in this process."""
    out = tmp_path_factory.mktemp("small")
    run(small_study, out, workers=0, repeats=1, log=quiet)
    return out

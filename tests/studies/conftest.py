import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes

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


def labelled(ax: Axes) -> dict[str, np.ndarray]:
    """x and y of the lines that have a label."""
    lines = {str(line.get_label()): np.asarray(line.get_xydata(), dtype=float).T for line in ax.lines}
    return {label: points for label, points in lines.items() if not label.startswith("_")}


@pytest.fixture(scope="session")
def small_study() -> Study:
    return load("padding").override(SMALL)


@pytest.fixture(scope="session")
def small_run(small_study: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with padding.nc, computed in this process."""
    out = tmp_path_factory.mktemp("small")
    run(small_study, out, workers=0, repeats=1, log=quiet)
    return out

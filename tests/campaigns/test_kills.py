"""A run that is killed at any of its events ends with every number when the same command is given again.

``KILL`` names a folder, whom to kill, with which signal, and at which event of which phase. The process that is at it
sends the signal, so that nothing is left to chance; a marker in the folder says that it was sent.
"""

import itertools
import os
import random
import signal
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import psutil
import pytest
import xarray as xr

from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.drawing import CaptionedFigure, Drawing
from studies.model.outcome import CaseStatus
from tests.campaigns.conftest import case_count
from tests.conftest import HANGS
from tests.studies.engine.trouble import Square, study_of

CASES = 24
# whom, at which event of which phase, with how many workers
PLACES = (
    ("parent", "solving", CASES, 2), ("worker", "solving", CASES, 2), ("keeper", "solving", CASES, 2),
    ("parent", "timing", CASES, 2), ("worker", "timing", CASES, 2), ("parent", "writing", 3, 2),
    ("parent", "drawing", 1, 2), ("parent", "solving", CASES, 0), ("parent", "writing", 3, 0),
)  # fmt: skip
SIGNALS = ("SIGKILL", "SIGTERM", "SIGKILL", "SIGTERM", "SIGINT")
DRAWS = random.Random(1)
KILLS = [
    (target, name, phase, 1 + DRAWS.randrange(1000) % most, workers)
    for (target, phase, most, workers), name in itertools.islice(
        zip(itertools.cycle(PLACES), itertools.cycle(SIGNALS), strict=False), case_count(whole=200, thin=4)
    )
]
SCRIPT = "import sys\nfrom tests.campaigns.test_kills import command\ncommand(*sys.argv[1:])"


def event(phase: str) -> None:
    folder, target, name, of_phase, count = os.environ["KILL"].split(os.pathsep)
    if phase != of_phase:
        return
    with Path(folder, phase).open("ab") as file:
        file.write(b".")
    if Path(folder, phase).stat().st_size < int(count):
        return
    with suppress(FileExistsError):
        Path(folder, "killed").touch(exist_ok=False)
        victims = {"parent": parent(), "worker": os.getpid(), "keeper": os.getppid()}
        os.kill(victims[target], signal.Signals[name])


def parent() -> int:
    """The process that drives the one that computes: this one itself in a run without workers."""
    line = (psutil.Process(), *psutil.Process().parents())
    return next(one.pid for one in line if "multiprocessing.forkserver" not in str(one.cmdline()))


@dataclass(frozen=True)
class Number(Square):
    """A number to square; its second run is the one that is timed."""

    def run(self, prepared: float) -> float:
        log = Path(os.environ["KILL"].partition(os.pathsep)[0], f"case{prepared:g}")
        with log.open("ab") as file:
            file.write(b".")
        event("solving" if log.stat().st_size == 1 else "timing")
        return super().run(prepared)


def measures(case: Number, result: float) -> Mapping[str, xr.Variable | float]:
    return {"square": result, "powers": xr.Variable(("power",), case.number ** np.arange(3.0))}


def command(out: str, workers: str) -> None:
    from studies.report import page
    from studies.report.plots import panels
    from studies.store import netcdf

    write = netcdf.replacing

    def replacing(path: Path) -> object:
        event("writing")
        return write(path)

    def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
        shown, (ax,) = panels(1)
        ax.plot(dataset["number"], dataset["square"])
        event("drawing")
        return (CaptionedFigure("squares", shown, "Squares."),)

    netcdf.replacing = replacing  # type: ignore[assignment]
    study = replace(study_of(Number, range(CASES), measures), name="victim")
    run(study, Path(out), options=RunOptions(workers=int(workers), repeats=1))
    page.draw_figures(study, Drawing(figure), Path(out))


@pytest.mark.whole
@pytest.mark.parametrize(("target", "name", "phase", "count", "workers"), KILLS)
def test_after_a_kill_the_same_command_ends_with_every_number(
    target: str, name: str, phase: str, count: int, workers: int, tmp_path: Path
) -> None:
    events = tmp_path / "events"
    events.mkdir()
    kill = os.pathsep.join([str(events), target, name, phase, str(count)])
    first, second = (
        # until all that it started have closed their output: nobody is left
        subprocess.run(
            [sys.executable, "-c", SCRIPT, str(tmp_path), str(workers)], timeout=HANGS, text=True,
            cwd=Path(__file__).parents[2], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            env=os.environ | {"KILL": kill},
        )
        for _ in range(2)
    )  # fmt: skip
    assert (events / "killed").exists()
    # the run itself goes on without a worker or its keeper
    assert (first.returncode == 0) == (target in ("worker", "keeper")), first.stdout
    # the script lets KeyboardInterrupt pass, as any script does
    assert name == "SIGINT" or "Traceback" not in first.stdout
    assert second.returncode == 0, second.stdout
    assert "Traceback" not in second.stdout
    dataset = xr.load_dataset(tmp_path / "victim.nc")
    assert (dataset["case_status"] == CaseStatus.OK).all()
    np.testing.assert_array_equal(dataset["square"], dataset["number"] ** 2)
    powers = dataset["number"].values[:, None] ** np.arange(3.0)
    np.testing.assert_array_equal(dataset["powers"], powers)
    assert np.isfinite(dataset["solve_time"]).all()
    assert not [*tmp_path.rglob(".*"), *tmp_path.glob("*.damaged")]
    assert (tmp_path / "victim" / "squares.png").is_file()
    # computed, timed, and perhaps run untimed before; once more where it was in hand or on its way
    assert max(path.stat().st_size for path in events.glob("case*")) <= 2 * 3

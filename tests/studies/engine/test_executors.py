"""Cases that raise, give nan, hang and die, wherever they are computed."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.engine.cluster import Cluster
from studies.engine.executors import ProcessPool
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.engine.stop import Stop
from studies.model.outcome import CaseStatus, Outcome, Work
from tests.studies.conftest import POSIX, quiet
from tests.studies.engine import trouble
from tests.studies.engine.trouble import DIES, HANGS, NAN, RAISES, Trouble

LIMIT = 5.0  # seconds; a case takes microseconds, however busy the machine
TROUBLES = {
    RAISES: CaseStatus.FAILED,
    NAN: CaseStatus.FAILED,
    HANGS: CaseStatus.TIMEOUT,
    DIES: CaseStatus.KILLED,
}


def examine(dataset: xr.Dataset) -> None:
    """Sixteen are right, four are labelled."""
    status = {
        int(n): CaseStatus(int(s))
        for n, s in zip(dataset["number"], dataset["case_status"], strict=True)
    }
    assert status == {n: TROUBLES.get(n, CaseStatus.OK) for n in range(20)}
    good = dataset.sel(number=[n for n in range(20) if n not in TROUBLES])
    np.testing.assert_array_equal(good["square"], good["number"] ** 2)
    assert not good["error"].values.any()
    said = {n: dataset.sel(number=n) for n in TROUBLES}
    place = f"run (trouble.py, line {trouble.RAISING_LINE})"
    assert str(said[RAISES]["error"].item()) == f"ArithmeticError in {place}: this one"
    assert (said[RAISES]["error_type"].item(), said[RAISES]["error_stage"].item()) == (
        "ArithmeticError", "solve",
    )  # fmt: skip
    assert "square is nan" in str(said[NAN]["error"].item())
    assert said[NAN]["error_stage"].item() == "measure"
    assert f"not done after {LIMIT:g} s" in str(said[HANGS]["error"].item())
    ending = "SIGKILL" if hasattr(signal, "SIGKILL") else "exit code"
    assert ending in str(said[DIES]["error"].item())


def test_processes_label_four_troubles_among_twenty(tmp_path: Path) -> None:
    settings = RunOptions(workers=2, time_limit=LIMIT, repeats=1)
    examine(run(trouble.study(), tmp_path, options=settings, log=quiet))


@pytest.mark.whole
def test_a_crew_goes_from_study_to_study_and_outlives_their_troubles(tmp_path: Path) -> None:
    """Its processes stay, take the measures of each study, and end with it."""
    found: dict[int, Outcome] = {}
    with ProcessPool(1) as pool:
        pool.run([Trouble(2.0)], Work(trouble.measures), found.__setitem__, Stop())
        assert float(found[0].variables["square"]) == 4
        processes = []
        for _ in range(2):
            pool.run([Trouble(1.0)], Work(trouble.process), found.__setitem__, Stop())
            processes.append(int(found[0].variables["process"]))
        assert processes[0] == processes[1] != os.getpid()
        settings = RunOptions(time_limit=LIMIT, repeats=1)
        examine(run(trouble.study(), tmp_path, options=settings, log=quiet, executor=pool))
        pool.run([Trouble(1.0)], Work(trouble.process), found.__setitem__, Stop())
        processes.append(int(found[0].variables["process"]))
    for one in processes:
        assert not psutil.pid_exists(one)


@pytest.mark.whole
def test_a_crew_that_was_stopped_starts_anew() -> None:
    found: dict[int, Outcome] = {}

    def stop(number: int, outcome: Outcome) -> None:
        raise KeyboardInterrupt

    with ProcessPool(2) as pool:
        with pytest.raises(KeyboardInterrupt):
            pool.run([Trouble(1.0), Trouble(HANGS)], Work(trouble.measures), stop, Stop())
        pool.run([Trouble(2.0)], Work(trouble.measures), found.__setitem__, Stop())
    assert float(found[0].variables["square"]) == 4


def test_what_workers_had_finished_when_a_run_was_stopped_is_not_lost(tmp_path: Path) -> None:
    """The first outcome stops the run, and is taken only when all but the two that hang are computed."""
    log = tmp_path / "log"
    # each long enough to be sent alone, so that a worker has given back one before it begins the next
    cases = [Trouble(n + 0.5, log=str(log), seconds=0.03, hangs_from=8.0) for n in range(10)]
    found: dict[int, Outcome] = {}

    def finished(number: int, outcome: Outcome) -> None:
        found[number] = outcome
        if len(found) == 1:
            while len(log.read_text(encoding="utf-8").splitlines()) < len(cases):
                time.sleep(0)  # others first
            raise KeyboardInterrupt

    with ProcessPool(2) as pool, pytest.raises(KeyboardInterrupt):
        pool.run(cases, Work(trouble.measures), finished, Stop())
    assert sorted(found) == list(range(8))
    assert {outcome.case_status for outcome in found.values()} == {CaseStatus.OK}


SCRIPT = """
import sys
from pathlib import Path
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.engine.stop import Stop
from tests.studies.engine import trouble
run(trouble.study(), Path(sys.argv[1]), options=RunOptions(workers=0, time_limit=5.0, repeats=1))
"""


@pytest.mark.whole
@POSIX
def test_a_case_that_takes_its_process_down_is_given_its_own_the_next_time(tmp_path: Path) -> None:
    command = [sys.executable, "-c", SCRIPT, str(tmp_path)]
    root = Path(__file__).parents[3]
    first = subprocess.run(command, cwd=root, capture_output=True, text=True)
    assert first.returncode == -signal.SIGKILL
    second = subprocess.run(command, cwd=root, capture_output=True, text=True)
    assert second.returncode == 0, second.stderr
    assert "needs a process of its own" in second.stdout
    dataset = xr.load_dataset(tmp_path / "trouble.nc")
    examine(dataset)
    assert "needs a process of its own" in str(dataset["error"].sel(number=DIES).item())


def address_of(scheduler: subprocess.Popen[str]) -> str:
    assert scheduler.stderr is not None
    for line in scheduler.stderr:
        if found := re.search(r"Scheduler at:\s+(tcp://\S+)", line):
            return found[1]
    raise AssertionError("no address")


Running = tuple[str, list[subprocess.Popen[bytes]]]


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Running]:
    """A scheduler and two workers, processes all three."""
    pytest.importorskip("distributed")
    dask = [str(Path(sys.executable).with_name("dask"))]
    root = Path(__file__).parents[3]
    environment = os.environ | {"PYTHONPATH": str(root)}
    scheduler = subprocess.Popen(
        [*dask, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-jupyter"],
        stderr=subprocess.PIPE, text=True, cwd=root, env=environment,
    )  # fmt: skip
    workers = []
    try:
        address = address_of(scheduler)
        workers = [
            subprocess.Popen(
                [*dask, "worker", address, "--no-nanny", "--nthreads", "1", "--no-dashboard",
                 "--local-directory", str(tmp_path / f"worker-{number}")],
                stderr=subprocess.DEVNULL, cwd=root, env=environment,
            )
            for number in range(2)
        ]  # fmt: skip
        yield address, workers
    finally:
        for process in [*workers, scheduler]:
            process.kill()
            process.wait()
        if scheduler.stderr is not None:
            scheduler.stderr.close()


@POSIX
def test_a_cluster_labels_four_troubles_and_outlives_a_worker(
    cluster: Running, tmp_path: Path
) -> None:
    address, workers = cluster
    settings = RunOptions(scheduler=address, time_limit=LIMIT, repeats=1)
    examine(run(trouble.study(), tmp_path, options=settings, log=quiet))

    log = tmp_path / "log"
    slow = trouble.study([n + 0.5 for n in range(24)], log=str(log), seconds=0.1)
    watcher = subprocess.Popen(
        [sys.executable, "-c", WATCH, str(log), str(workers[0].pid)],
    )
    dataset = run(slow, tmp_path / "second", options=settings, log=quiet)
    assert watcher.wait() == 0
    assert workers[0].wait() == -signal.SIGKILL
    assert (dataset["case_status"] == CaseStatus.OK).all()
    np.testing.assert_array_equal(dataset["square"], dataset["number"] ** 2)


WATCH = """
import os, signal, sys, time
while not (os.path.exists(sys.argv[1]) and len(open(sys.argv[1]).readlines()) >= 6):
    time.sleep(0.02)
os.kill(int(sys.argv[2]), signal.SIGKILL)
"""


def test_a_scheduler_that_is_not_there_is_said() -> None:
    pytest.importorskip("distributed")
    nowhere = Cluster("tcp://127.0.0.1:1", patience=0.2)
    with pytest.raises(InvalidInput, match=r"^Scheduler 'tcp://127.0.0.1:1' cannot be reached"):
        nowhere.run([], Work(trouble.measures), lambda number, outcome: None, Stop())


def test_the_first_failure_stops_a_run_that_is_to_stop(tmp_path: Path) -> None:
    settings = RunOptions(workers=0, after_failure="stop", repeats=1)
    dataset = run(trouble.study(), tmp_path, options=settings, log=quiet)
    status = dataset["case_status"].values.tolist()
    assert status == [CaseStatus.OK] * RAISES + [CaseStatus.FAILED] + [CaseStatus.SKIPPED] * (
        19 - RAISES
    )

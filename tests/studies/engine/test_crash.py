import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.engine.compute import ended
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.outcome import CaseStatus
from studies.store.journal import Journal
from studies.store.provenance import machine
from tests.studies.conftest import quiet
from tests.studies.engine import trouble
from tests.studies.engine.trouble import lines

resource = pytest.importorskip("resource", reason="this system has no limits of POSIX")
ROOT = Path(__file__).parents[3]
ALONE = RunOptions(workers=0, repeats=0)
SCRIPT = """
import sys
from pathlib import Path
from studies.engine.options import RunOptions
from studies.engine.run import run
from tests.studies.engine import trouble
out, workers, hangs_from = sys.argv[1:]
study = trouble.study([n + 0.5 for n in range(30)], hangs_from=float(hangs_from))
run(study, Path(out), options=RunOptions(workers=int(workers), repeats=0))
"""
Process = subprocess.Popen[str]
Start = Callable[[int, int], Process]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start a run of thirty cases with so many ``workers``, which hang from one on; none outlives the test."""
    started: list[Process] = []

    def begin(workers: int, hangs_from: int) -> Process:
        arguments = [sys.executable, "-c", SCRIPT, str(tmp_path), str(workers), str(hangs_from)]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        started.append(subprocess.Popen(arguments, cwd=ROOT, text=True, start_new_session=True, **pipes))
        return started[0]

    yield begin
    for process in started:
        process.kill()
        process.communicate()


def journalled(folder: Path) -> int:
    return sum('"status":' in line for line in lines(folder / "cases.jsonl"))


def wait_for(count: int, folder: Path, running: Process) -> None:
    """Until a run has stored so many cases; it must not end before."""
    while journalled(folder) < count:
        with suppress(subprocess.TimeoutExpired):
            running.wait(timeout=0.01)
            raise AssertionError(running.communicate())


@pytest.mark.cases(1)
@pytest.mark.parametrize("workers", [0, 2])
def test_a_kill_loses_nothing_but_what_is_being_computed(workers: int, start: Start, tmp_path: Path) -> None:
    first = start(workers, 12)
    wait_for(12, tmp_path, first)
    first.kill()
    first.communicate()
    assert set(xr.load_dataset(tmp_path / "trouble.nc")["case_status"].values) <= {CaseStatus.NOT_RUN, CaseStatus.OK}
    log = tmp_path / "log"
    study = trouble.study([n + 0.5 for n in range(30)], str(log))
    dataset = run(study, tmp_path, options=ALONE, log=quiet)
    assert sorted(map(float, lines(log))) == [n + 0.5 for n in range(12, 30)]
    assert (dataset["case_status"] == CaseStatus.OK).all()
    np.testing.assert_array_equal(dataset["square"], dataset["number"] ** 2)


def test_failures_are_kept_until_those_of_their_kind_are_to_be_tried_again(tmp_path: Path) -> None:
    log = tmp_path / "log"
    study = trouble.study([1, trouble.RAISES], str(log))
    stored = run(study, tmp_path, options=ALONE, log=quiet)
    key = stored["case_key"].values[1], stored.attrs["program"]
    for retry, status, tried in (
        ((), CaseStatus.FAILED, []),
        (("failed",), CaseStatus.FAILED, ["3.0"]),
        (("timeout",), CaseStatus.TIMEOUT, ["3.0"]),
        (("timeout",), CaseStatus.KILLED, []),
    ):
        log.unlink(missing_ok=True)
        with Journal(tmp_path / "cases.jsonl", machine()) as journal:
            journal.add(key, "trouble", {"number": 3.0}, ended(status, "E", "why", 1.0))
        run(study, tmp_path, options=replace(ALONE, retry=retry), log=quiet)
        assert lines(log) == tried, (retry, status)


def test_a_full_disk_is_said_and_what_was_stored_stays(tmp_path: Path) -> None:
    study = trouble.study([0, 1, 2])
    before = run(study, tmp_path, options=ALONE, log=quiet)
    whole = (tmp_path / "cases.jsonl").read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    deaf = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole) + 100, limits[1]))
        with pytest.raises(InvalidInput, match=r"^Journal .* cannot be written .*what was stored is kept"):
            run(trouble.study(range(20, 60)), tmp_path, options=ALONE, log=quiet)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, deaf)
    assert (tmp_path / "cases.jsonl").read_bytes()[: len(whole)] == whole
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "trouble.nc"), before)
    run(study, tmp_path, options=ALONE, log=quiet)


@pytest.mark.whole
def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(start: Start, tmp_path: Path) -> None:
    running = start(2, 8)
    wait_for(8, tmp_path, running)
    # a terminal sends it to all processes of the run
    os.killpg(running.pid, signal.SIGINT)
    out, err = running.communicate()
    assert running.returncode == -signal.SIGINT
    # the script's own traceback, and none of another process
    assert (err.count("Traceback"), err.splitlines()[-1]) == (1, "KeyboardInterrupt")
    assert "8 of 30 cases are stored; run the same command to go on" in out
    status = xr.load_dataset(tmp_path / "trouble.nc")["case_status"].values.tolist()
    assert status == [CaseStatus.OK] * 8 + [CaseStatus.NOT_RUN] * 22

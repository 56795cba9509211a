import math
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import psutil
import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.engine.compute import ended
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.engine.slot import METHOD
from studies.model.outcome import CaseStatus
from studies.store.journal import Journal
from studies.store.provenance import machine
from tests.studies.conftest import quiet
from tests.studies.engine import trouble

resource = pytest.importorskip("resource", reason="this system has no limits of POSIX")
ROOT = Path(__file__).parents[3]
ALONE = RunOptions(workers=0, repeats=0)
SCRIPT = """
import sys
from pathlib import Path
from studies.engine.compute import ended
from studies.engine.options import RunOptions
from studies.engine.run import run
from tests.studies.engine import trouble
out, log, workers, numbers, hangs_from = sys.argv[1:]
study = trouble.study([n + 0.5 for n in range(int(numbers))], log, hangs_from=float(hangs_from))
run(study, Path(out), options=RunOptions(workers=int(workers), repeats=0))
"""


Process = subprocess.Popen[str]
Start = Callable[[Path, int, int, float], Process]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start a run with ``log`` and ``workers`` of so many cases, of which some hang; none outlives the test."""
    with ExitStack() as started:

        def begin(log: Path, workers: int, numbers: int, hangs_from: float) -> Process:
            arguments = [str(part) for part in (tmp_path, log, workers, numbers, hangs_from)]
            process = started.enter_context(
                subprocess.Popen(
                    [sys.executable, "-c", SCRIPT, *arguments],
                    cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                    start_new_session=True,
                )
            )  # fmt: skip
            started.callback(process.kill)
            return process

        yield begin


def lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines() if path.exists() else []


def journalled(folder: Path) -> int:
    return sum('"status":' in line for line in lines(folder / "cases.jsonl"))


def wait_until(reached: Callable[[], bool], running: Process) -> None:
    """Until a run has left on the disk what it takes; it must not end before."""
    while not reached():
        with suppress(subprocess.TimeoutExpired):
            running.wait(timeout=0.01)
            raise AssertionError(running.communicate())


@pytest.mark.cases(1)
@pytest.mark.parametrize("workers", [0, 2])
def test_a_kill_loses_nothing_but_what_is_being_computed(workers: int, start: Start, tmp_path: Path) -> None:
    first = start(tmp_path / "log", workers, 30, 12)
    wait_until(lambda: journalled(tmp_path) == 12, first)
    first.kill()
    first.communicate()
    assert set(xr.load_dataset(tmp_path / "trouble.nc")["case_status"].values) <= {
        CaseStatus.NOT_RUN,
        CaseStatus.OK,
    }
    log = tmp_path / "log of the second"
    study = trouble.study([n + 0.5 for n in range(30)], str(log))
    dataset = run(study, tmp_path, options=ALONE, log=quiet)
    assert sorted(map(float, lines(log))) == [n + 0.5 for n in range(12, 30)]
    assert (dataset["case_status"] == CaseStatus.OK).all()
    np.testing.assert_array_equal(dataset["square"], dataset["number"] ** 2)


def test_growing_reruns_nothing_and_keeps_every_bit(tmp_path: Path) -> None:
    log = tmp_path / "log"
    few = [0.1, 0.3, 1 / 7]
    before = run(trouble.study(few, str(log)), tmp_path, options=ALONE, log=quiet)
    count = len(lines(log))
    more = [0.1, 0.3, 1 / 7, 1e10, 5.0]
    after = run(trouble.study(more, str(log)), tmp_path, options=ALONE, log=quiet)
    assert set(lines(log)[count:]) == {"10000000000.0", "5.0"}
    xr.testing.assert_identical(before.drop_attrs(), after.isel(number=slice(3)).drop_attrs().reset_coords(drop=True))


def test_failures_are_kept_until_those_of_their_kind_are_to_be_tried_again(tmp_path: Path) -> None:
    log = tmp_path / "log"
    study = trouble.study([1, trouble.RAISES], str(log))
    stored = run(study, tmp_path, options=ALONE, log=quiet)
    key = stored["case_key"].values[1], stored.attrs["program"]
    for retry, status, tried in (
        ((), CaseStatus.FAILED, []),
        (("timeout", "killed"), CaseStatus.FAILED, []),
        (("failed",), CaseStatus.FAILED, ["3.0"]),
        (("killed",), CaseStatus.TIMEOUT, []),
        (("timeout",), CaseStatus.TIMEOUT, ["3.0"]),
        (("failed",), CaseStatus.KILLED, ["3.0"]),
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


def test_a_journal_that_cannot_be_opened_is_said(tmp_path: Path) -> None:
    (tmp_path / "cases.jsonl").mkdir()
    with pytest.raises(InvalidInput, match=r"^Journal .* cannot be read \(Is a directory\)"):
        run(trouble.study([1]), tmp_path, options=ALONE, log=quiet)


def interrupted(running: Process) -> str:
    """What a run says that a terminal interrupts, which sends the signal to all of its processes."""
    os.killpg(running.pid, signal.SIGINT)
    out, err = running.communicate()
    assert running.returncode == -signal.SIGINT
    # the script's own traceback, and none of another process
    assert (err.count("Traceback"), err.splitlines()[-1]) == (1, "KeyboardInterrupt")
    return out


@pytest.mark.whole
def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(start: Start, tmp_path: Path) -> None:
    running = start(tmp_path / "log", 2, 30, 8)
    wait_until(lambda: journalled(tmp_path) == 8, running)
    out = interrupted(running)
    assert "8 of 30 cases are stored; run the same command to go on" in out
    status = xr.load_dataset(tmp_path / "trouble.nc")["case_status"].values.tolist()
    assert status == [CaseStatus.OK] * 8 + [CaseStatus.NOT_RUN] * 22


@pytest.mark.skipif(METHOD != "forkserver", reason="processes are not forked")
def test_an_interrupt_while_processes_start_is_shown_by_none(start: Start, tmp_path: Path) -> None:
    running = start(tmp_path / "log", 2, 30, math.inf)
    wait_until(lambda: any(map(imports, psutil.Process(running.pid).children())), running)
    assert "0 of 30 cases are stored" in interrupted(running)


def imports(process: psutil.Process) -> bool:
    """Whether this is the process that worker processes are forked from, half way through its imports."""
    try:
        is_server = "forkserver" in str(process.cmdline())
        return is_server and any("_multiarray_umath" in part.path for part in process.memory_maps())
    except psutil.ZombieProcess:
        return False

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.outcome import CaseStatus
from tests.studies.conftest import POSIX, quiet
from tests.studies.engine import trouble
from tests.studies.engine.trouble import DIES, HANGS, NAN, RAISES, Trouble, Unsendable, compute

LIMIT = 1.5  # seconds; a case takes microseconds, however busy the machine
ROOT = Path(__file__).parents[3]
TROUBLES = {
    RAISES: CaseStatus.FAILED,
    NAN: CaseStatus.FAILED,
    HANGS: CaseStatus.TIMEOUT,
    DIES: CaseStatus.KILLED,
}
Workers = list[subprocess.Popen[bytes]]


def examine(dataset: xr.Dataset) -> None:
    status = {int(n): CaseStatus(int(s)) for n, s in zip(dataset["number"], dataset["case_status"], strict=True)}
    assert status == {n: TROUBLES.get(n, CaseStatus.OK) for n in range(20)}
    good = dataset.sel(number=[n for n in range(20) if n not in TROUBLES])
    np.testing.assert_array_equal(good["square"], good["number"] ** 2)
    assert not good["error"].values.any()
    said = {n: dataset.sel(number=n) for n in TROUBLES}
    place = f"run (trouble.py, line {trouble.RAISING_LINE})"
    assert str(said[RAISES]["error"].item()) == f"ArithmeticError in {place}: this one"
    assert "square is nan" in str(said[NAN]["error"].item())
    assert f"not done after {LIMIT:g} s" in str(said[HANGS]["error"].item())
    ending = "SIGKILL" if hasattr(signal, "SIGKILL") else "exit code"
    assert ending in str(said[DIES]["error"].item())


def address_of(scheduler: subprocess.Popen[str]) -> str:
    for line in scheduler.stderr:
        if found := re.search(r"Scheduler at:\s+(tcp://\S+)", line):
            return found[1]
    raise AssertionError("no address")


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Workers]]:
    dask = [str(Path(sys.executable).with_name("dask"))]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    running = subprocess.Popen(
        [*dask, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-jupyter"],
        stderr=subprocess.PIPE, text=True, cwd=ROOT, env=environment,
    )  # fmt: skip
    workers: Workers = []
    try:
        address = address_of(running)
        workers += [
            subprocess.Popen(
                [*dask, "worker", address, "--no-nanny", "--nthreads", "1", "--no-dashboard",
                 "--local-directory", str(tmp_path_factory.mktemp("worker"))],
                stderr=subprocess.DEVNULL, cwd=ROOT, env=environment,
            )
            for _ in range(2)
        ]  # fmt: skip
        yield address, workers
    finally:
        for process in [*workers, running]:
            process.kill()
            process.wait()
        if running.stderr is not None:
            running.stderr.close()


@pytest.fixture(params=["local", pytest.param("remote", marks=POSIX)])
def address(request: pytest.FixtureRequest) -> str | None:
    """The address of a scheduler, or none for dask in this process."""
    if request.param == "local":
        return None
    address: str = request.getfixturevalue("scheduler")[0]
    return address


@pytest.mark.cases(1)
def test_four_troubles_among_twenty_are_labelled(address: str | None, tmp_path: Path) -> None:
    settings = RunOptions(workers=2, scheduler=address, time_limit=LIMIT, repeats=1)
    examine(run(trouble.study(), tmp_path, options=settings, log=quiet))


@pytest.mark.cases(1)
@pytest.mark.parametrize("where", ["written", "read"])
def test_a_case_that_cannot_be_sent_fails_alone(address: str | None, where: str) -> None:
    # the first ones go alone; by the fortieth, what a case takes is known, and it goes with others
    cases = [Trouble(n + 0.5) for n in range(80)]
    cases[60] = Unsendable(60.5, where=where)
    outcomes = compute(cases, workers=1, address=address)
    bad = outcomes.pop(60)
    assert {outcome.case_status for outcome in outcomes} == {CaseStatus.OK}
    assert bad.case_status == CaseStatus.FAILED
    assert "it holds an open file" in bad.error


WATCH = """
import os, signal, sys, time
while not (os.path.exists(sys.argv[1]) and len(open(sys.argv[1]).readlines()) >= 6):
    time.sleep(0.02)
os.kill(int(sys.argv[2]), signal.SIGKILL)
"""


@pytest.mark.whole
@POSIX
def test_a_run_outlives_a_dask_worker(scheduler: tuple[str, Workers], tmp_path: Path) -> None:
    address, workers = scheduler
    log = tmp_path / "log"
    slow = trouble.study([n + 0.5 for n in range(24)], log=str(log), seconds=0.1)
    watcher = subprocess.Popen([sys.executable, "-c", WATCH, str(log), str(workers[0].pid)])
    settings = RunOptions(scheduler=address, repeats=0)
    dataset = run(slow, tmp_path, options=settings, log=quiet)
    assert watcher.wait() == 0
    assert workers[0].wait() == -signal.SIGKILL
    assert (dataset["case_status"] == CaseStatus.OK).all()
    np.testing.assert_array_equal(dataset["square"], dataset["number"] ** 2)


def test_a_scheduler_that_is_not_there_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("studies.engine.cluster.PATIENCE", 0.2)
    refusal = r"^Scheduler 'tcp://127.0.0.1:1' cannot be reached"
    with pytest.raises(InvalidInput, match=refusal):
        compute([Trouble(1.0)], address="tcp://127.0.0.1:1")

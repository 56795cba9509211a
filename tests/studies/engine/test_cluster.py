import logging
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cloudpickle
import numpy as np
import psutil
import pytest
from distributed import KilledWorker, LocalCluster

from contactstudy import InvalidInput
from studies.engine import cluster
from studies.engine.cluster import perform_on_workers
from studies.engine.compute import Task
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.engine.slot import Slot
from studies.model.outcome import CaseStatus, Outcome
from studies.store.stop import Stop
from tests.studies.conftest import POSIX, quiet
from tests.studies.engine import trouble
from tests.studies.engine.trouble import DIES, HANGS, NAN, RAISES, Trouble, Unsendable, compute, measures, settings_of

LIMIT = 4.0  # seconds; a case takes microseconds, and the first of a process up to one on a busy machine
ROOT = Path(__file__).parents[3]
Workers = list[subprocess.Popen[bytes]]


def started(*words: str, **streams: Any) -> subprocess.Popen[Any]:
    command = [str(Path(sys.executable).with_name("dask")), *words, "--no-dashboard"]
    return subprocess.Popen(command, cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)}, **streams)


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Workers]]:
    words = ["scheduler", "--host", "127.0.0.1", "--port", "0", "--no-jupyter"]
    running = started(*words, stderr=subprocess.PIPE, text=True)
    workers: Workers = []
    try:
        lines = iter(running.stderr.readline, "")
        address = next(found[1] for line in lines if (found := re.search(r"Scheduler at:\s+(tcp://\S+)", line)))
        for _ in range(2):
            words = ["worker", address, "--no-nanny", "--nthreads", "1", "--local-directory"]
            workers.append(started(*words, str(tmp_path_factory.mktemp("worker")), stderr=subprocess.DEVNULL))
        yield address, workers
    finally:
        for process in [*workers, running]:
            process.kill()
            process.wait()
        running.stderr.close()


@pytest.fixture(params=["local", pytest.param("remote", marks=POSIX)])
def address(request: pytest.FixtureRequest) -> str | None:
    """The address of a scheduler, or none for dask in this process."""
    return None if request.param == "local" else request.getfixturevalue("scheduler")[0]  # type: ignore[no-any-return]


@pytest.mark.cases(1)
def test_four_troubles_among_twenty_are_labelled(address: str | None, tmp_path: Path) -> None:
    settings = RunOptions(workers=2, scheduler=address, time_limit=LIMIT, repeats=1)
    dataset = run(trouble.study(), tmp_path, options=settings, log=quiet)
    ended = {int(n): CaseStatus(int(s)) for n, s in zip(dataset["number"], dataset["case_status"], strict=True)}
    troubles = {
        RAISES: (CaseStatus.FAILED, "ArithmeticError in run (trouble.py, line "),
        NAN: (CaseStatus.FAILED, "square is nan"),
        HANGS: (CaseStatus.TIMEOUT, f"not done after {LIMIT:g} s"),
        DIES: (CaseStatus.KILLED, "SIGKILL" if hasattr(signal, "SIGKILL") else "exit code"),
    }
    assert ended == {n: troubles[n][0] if n in troubles else CaseStatus.OK for n in range(20)}
    for number, (_, said) in troubles.items():
        assert said in str(dataset["error"].sel(number=number).item())
    good = dataset.where(dataset["case_status"] == CaseStatus.OK, drop=True)
    np.testing.assert_array_equal(good["square"], good["number"] ** 2)


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
    dataset = run(slow, tmp_path, options=RunOptions(scheduler=address, repeats=0), log=quiet)
    assert (watcher.wait(), workers[0].wait()) == (0, -signal.SIGKILL)
    assert (dataset["case_status"] == CaseStatus.OK).all()
    np.testing.assert_array_equal(dataset["square"], dataset["number"] ** 2)


def test_of_a_batch_that_killed_its_workers_the_case_that_did_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    performed = Slot.perform

    def killed_by_one(slot: Slot, tasks: bytes, *more: Any) -> list[Outcome]:
        if any(task.case.number == 60.5 for task in cloudpickle.loads(tasks)):
            raise KilledWorker("batch", SimpleNamespace(address="tcp://there:2"), 3)
        return performed(slot, tasks, *more)

    monkeypatch.setattr(Slot, "perform", killed_by_one)
    outcomes = compute([Trouble(n + 0.5) for n in range(80)], workers=1)
    killed = outcomes.pop(60)
    assert {one.case_status for one in outcomes} == {CaseStatus.OK}
    assert killed.case_status is CaseStatus.KILLED
    assert "workers died while they held it, the last tcp://there:2" in killed.error


def test_a_scheduler_that_is_absent_lost_or_without_workers_and_a_worker_that_cannot_compute_are_said(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 0.2)
    with pytest.raises(InvalidInput, match=r"^Scheduler 'tcp://127.0.0.1:1' cannot be reached"):
        compute([Trouble(1.0)], address="tcp://127.0.0.1:1")
    said: list[str] = []
    with LocalCluster(n_workers=0, processes=False, protocol="tcp", dashboard_address="127.0.0.1:0") as here:

        def log(line: str) -> None:
            said.append(line)
            here.close()

        address = here.scheduler_address
        with pytest.raises(InvalidInput, match=rf"^Scheduler '{address}' is lost: start it again"):
            compute([Trouble(1.0)], address=address, log=log)
    assert said == [f"waiting for workers of {address}: start some, or stop the run and go on later"]
    assert not [one for one in caplog.records if one.levelno > logging.INFO]

    def fails(*_: object) -> None:
        raise ImportError("studies")

    monkeypatch.setattr(Slot, "perform", fails)
    with pytest.raises(InvalidInput, match="install the same version of contactstudy there"):
        compute([Trouble(1.0)])


def test_dask_here_listens_to_this_machine_alone_and_only_while_cases_are_computed() -> None:
    def listening() -> set[str]:
        connections = psutil.Process().net_connections("inet")
        return {one.laddr.ip for one in connections if one.status == psutil.CONN_LISTEN}

    tasks = [Task("00000001", Trouble(1.0))]
    with Stop() as stop:
        heard = [listening() for _ in perform_on_workers(tasks, settings_of(measures), None, stop)]
    assert listening() == set()
    assert heard == [{"127.0.0.1"}]

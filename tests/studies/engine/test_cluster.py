import logging
from types import SimpleNamespace
from typing import Any

import cloudpickle
import psutil
import pytest
from distributed import KilledWorker, LocalCluster

from contactstudy import InvalidInput
from studies.engine import cluster
from studies.engine.cluster import perform_on_workers
from studies.engine.compute import Task
from studies.engine.slot import Slot
from studies.model.outcome import CaseStatus, Outcome
from studies.store.stop import Stop
from tests.studies.engine.trouble import Trouble, compute, measures, settings_of

HERE = "127.0.0.1:0"


def test_a_scheduler_without_workers_and_then_lost_is_said(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 0.1)
    said: list[str] = []
    with LocalCluster(n_workers=0, processes=False, protocol="tcp", dashboard_address=HERE) as here:

        def log(line: str) -> None:
            said.append(line)
            here.close()

        address = here.scheduler_address
        with pytest.raises(InvalidInput, match=rf"^Scheduler '{address}' is lost: start it again"):
            compute([Trouble(1.0)], address=address, log=log)
    assert said == [f"waiting for workers of {address}: start some, or stop the run and go on later"]
    assert not [one for one in caplog.records if one.levelno > logging.INFO]


def test_of_a_batch_that_killed_its_workers_the_case_that_did_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
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


def test_a_dask_worker_that_cannot_compute_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object) -> None:
        raise ImportError("studies")

    monkeypatch.setattr(Slot, "perform", fails)
    with pytest.raises(InvalidInput, match="install the same version of contactstudy there"):
        compute([Trouble(1.0)])


def listening() -> set[str]:
    connections = psutil.Process().net_connections("inet")
    return {one.laddr.ip for one in connections if one.status == psutil.CONN_LISTEN}


def test_dask_here_listens_to_this_machine_alone_and_only_while_cases_are_computed() -> None:
    tasks, heard = [Task("00000001", Trouble(1.0))], []
    with Stop() as stop:
        for _ in perform_on_workers(tasks, settings_of(measures), None, stop):
            heard.append(listening())
    assert listening() == set()
    assert heard == [{"127.0.0.1"}]

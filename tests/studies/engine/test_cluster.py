import logging
from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import cloudpickle
import pytest
from distributed import KilledWorker, LocalCluster

from contactstudy import InvalidInput
from studies.engine.workers.process import SupervisedProcess
from studies.model.outcome import CaseStatus, Outcome
from tests.studies.engine.trouble import Trouble, compute

HERE = "127.0.0.1:0"


def test_a_scheduler_without_workers_and_then_lost_is_said(
    caplog: pytest.LogCaptureFixture,
) -> None:
    said: list[str] = []
    with LocalCluster(n_workers=0, processes=False, protocol="tcp", dashboard_address=HERE) as here:

        def log(line: str) -> None:
            said.append(line)
            here.close()

        address = here.scheduler_address
        with pytest.raises(InvalidInput, match=rf"^Scheduler '{address}' is lost: start it again"):
            compute([Trouble(1.0)], address=address, reconnect_timeout=0.1, log=log)
    assert said == [
        f"waiting for workers of {address}: start some, or stop the run and go on later"
    ]
    assert not [one for one in caplog.records if one.levelno > logging.INFO]


def test_of_a_batch_that_killed_its_workers_the_case_that_did_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    computed = SupervisedProcess.run

    def killed_by_one(worker: SupervisedProcess, batch: bytes, *more: Any) -> Iterable[Outcome]:
        if any(case.number == 60.5 for case in cloudpickle.loads(batch)):
            raise KilledWorker("batch", SimpleNamespace(address="tcp://there:2"), 3)
        return computed(worker, batch, *more)

    monkeypatch.setattr(SupervisedProcess, "run", killed_by_one)
    outcomes = compute([Trouble(n + 0.5) for n in range(80)], workers=1)
    killed = outcomes.pop(60)
    assert {one.case_status for one in outcomes} == {CaseStatus.OK}
    assert killed.case_status is CaseStatus.KILLED
    assert "workers died while they held it, the last tcp://there:2" in killed.error


def test_a_dask_worker_that_cannot_compute_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object) -> None:
        raise ImportError("studies")

    monkeypatch.setattr(SupervisedProcess, "run", fails)
    with pytest.raises(InvalidInput, match="install the same version of contactstudy there"):
        compute([Trouble(1.0)])

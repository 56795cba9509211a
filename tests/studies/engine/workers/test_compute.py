import signal
from dataclasses import dataclass
from time import perf_counter

import numpy as np
import pytest

from contactstudy.domain.reuse import ArrayCache, cached_array
from studies.engine.workers import compute
from studies.engine.workers.compute import time_once, timed
from studies.model.outcome import CaseStatus, RunSettings
from tests.studies.conftest import POSIX
from tests.studies.engine.trouble import Square


@dataclass(frozen=True)
class Endless(Square):
    def run(self, prepared: float) -> float:
        while True:
            pass


WORK = RunSettings(lambda case, result: {"square": result})


@POSIX
def test_an_alarm_ends_a_case_that_hangs_and_is_off_afterwards() -> None:
    work, began = RunSettings(WORK.measures, time_limit=0.05), perf_counter()
    outcome = compute.compute(Endless(1.0), work)
    assert outcome.case_status is CaseStatus.TIMEOUT
    assert 0.05 <= outcome.seconds < perf_counter() - began
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    late = timed(Endless(1.0), 0.05)
    assert (late.sample, late.failure.stage) == (None, "timing")
    # the limit of a timed run follows from the case
    assert "--time-limit" in outcome.error
    assert "--time-limit" not in late.error
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


@dataclass(frozen=True)
class Sharing(Square):
    def prepare(self) -> float:
        return float(cached_array("number", lambda: np.array(self.number)))


def test_cases_share_arrays_and_timed_runs_make_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compute, "SHARED_ARRAYS", ArrayCache(100))
    squares = [compute.compute(Sharing(number), WORK).variables["square"] for number in (2.0, 3.0)]
    assert [float(square) for square in squares] == [4.0, 4.0]
    prepared = []
    monkeypatch.setattr(Sharing, "run", lambda _, number: prepared.append(number))
    time_once(Sharing(5.0))
    assert prepared == [5.0]

"""Cases computed in this process, one after the other."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr
from threadpoolctl import threadpool_info, threadpool_limits

from studies.engine.executors import InProcess
from studies.engine.stop import Stop
from studies.model.outcome import Outcome, Work


@dataclass(frozen=True)
class Threads:
    """The largest number of threads of any library for linear algebra."""

    def prepare(self) -> None:
        np.ones((2, 2)) @ np.ones((2, 2))

    def run(self, prepared: None) -> int:
        return max(library["num_threads"] for library in threadpool_info())

    def record(self, result: int) -> Mapping[str, xr.Variable]:
        return {}


def test_a_case_has_one_thread_whatever_the_process_had() -> None:
    outcomes: dict[str, Outcome] = {}
    work = Work(lambda case, result: {"threads": xr.Variable((), result)})
    with threadpool_limits(2), Stop() as stop:
        assert Threads().run(None) == 2
        InProcess().run({"a": Threads()}, work, outcomes.__setitem__, stop)
        assert Threads().run(None) == 2
    assert int(outcomes["a"].variables["threads"]) == 1

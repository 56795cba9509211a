"""What became of a case, as numbers a Dataset can hold."""

import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from time import perf_counter

import xarray as xr
from threadpoolctl import threadpool_limits

from contactstudy import Status
from studies.case import Case
from studies.study import Measures


class Fate(IntEnum):
    """Whether a case gave its numbers."""

    NOT_RUN = 0
    OK = 1
    FAILED = 2


SOLVER_STATUS = {status: code for code, status in enumerate(Status)}


@dataclass(frozen=True, eq=False)
class Outcome:
    """The variables of one case, or the sentence that says why there are none."""

    fate: Fate
    variables: Mapping[str, xr.Variable] = field(default_factory=dict)
    error: str = ""


def compute(case: Case, measures: Measures) -> Outcome:
    """Set up, solve and measure ``case``; a failure is an outcome, so that the others go on."""
    try:
        with threadpool_limits(1):
            solution = case.solve(case.problem())
            measured = dict(measures(case, solution))
    except Exception as error:  # noqa: BLE001 (whatever a study's own code raises is data)
        place = traceback.extract_tb(error.__traceback__)[-1]
        return Outcome(Fate.FAILED, error=f"{type(error).__name__} in {place.name}: {error}")
    flags = {
        "long_name": "outcome of the solver",
        "flag_values": list(SOLVER_STATUS.values()),
        "flag_meanings": " ".join(status.name.lower() for status in SOLVER_STATUS),
    }
    measured["outcome"] = xr.Variable((), SOLVER_STATUS[solution.status], flags)
    for name, long_name in (
        ("iterations", "solver iterations"),
        ("convolutions", "transform pairs of the full grid"),
        ("residual", "residual of the solver"),
    ):
        attributes = {"units": "1", "long_name": long_name}
        measured[name] = xr.Variable((), getattr(solution, name), attributes)
    return Outcome(Fate.OK, measured)


def clock(case: Case) -> tuple[float, float]:
    """Seconds of wall time to set up and to solve ``case``, on one thread."""
    with threadpool_limits(1):
        start = perf_counter()
        problem = case.problem()
        ready = perf_counter()
        case.solve(problem)
        return ready - start, perf_counter() - ready

"""What became of a computation, as numbers a Dataset can hold."""

import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from time import perf_counter

import xarray as xr
from threadpoolctl import threadpool_limits

from contactstudy import InvalidInput
from studies.case import Computation
from studies.study import Measures


class Fate(IntEnum):
    """Whether a computation gave its numbers."""

    NOT_RUN = 0
    OK = 1
    FAILED = 2


# what the store says of every case itself
TAKEN = frozenset({"status", "error", "setup_time", "solve_time"})


@dataclass(frozen=True, eq=False)
class Outcome:
    """The variables of one computation, or the sentence that says why there are none."""

    fate: Fate
    variables: Mapping[str, xr.Variable] = field(default_factory=dict)
    error: str = ""


def compute(case: Computation, measures: Measures) -> Outcome:
    """Compute and measure ``case``; a failure is an outcome, so that the others go on."""
    try:
        with threadpool_limits(1):
            result = case.run(case.prepare())
            measured = dict(measures(case, result)) | dict(case.record(result))
            if taken := TAKEN & set(measured):
                raise InvalidInput(
                    f"measures gives {sorted(taken)}: these names are taken, choose others."
                )
            return Outcome(Fate.OK, {name: _variable(name, v) for name, v in measured.items()})
    except Exception as error:  # noqa: BLE001 (whatever a study's own code raises is data)
        place = traceback.extract_tb(error.__traceback__)[-1]
        return Outcome(Fate.FAILED, error=f"{type(error).__name__} in {place.name}: {error}")


def _variable(name: str, value: xr.Variable | float) -> xr.Variable:
    """A bare number gets its name for a label."""
    if isinstance(value, xr.Variable):
        return value
    return xr.Variable((), value, {"long_name": name.replace("_", " ")})


def clock(case: Computation) -> tuple[float, float]:
    """Seconds of wall time to set up and to run ``case``, on one thread."""
    with threadpool_limits(1):
        start = perf_counter()
        prepared = case.prepare()
        ready = perf_counter()
        case.run(prepared)
        return ready - start, perf_counter() - ready

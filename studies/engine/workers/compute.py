"""Computation and timing of one case, where any error is an outcome of the case."""

from time import perf_counter, process_time

import numpy as np
import xarray as xr

from contactstudy.domain.reuse import ArrayCache, caching
from studies.engine import time_limit
from studies.engine.time_limit import TimeLimitError, alarm, timed_out, too_late
from studies.model import measured
from studies.model.case import Computation
from studies.model.measured import check_size, measured_variables
from studies.model.outcome import (
    RESERVED_NAMES,
    CaseStatus,
    Failure,
    HasFields,
    Outcome,
    Sample,
    Work,
)
from studies.model.plain_text import one_line, place_of

# Arrays that cases of this process share, such as the coefficients of equal grids: up to so many bytes. Timed runs
# compute their own.
SHARED_ARRAYS = ArrayCache(2**26)
REFERENCE_FIELD = np.outer(np.cos(np.arange(128.0)), np.sin(np.arange(128.0)))


class StopRun(BaseException):
    """Raised to stop the run; any other error during a case is a failure of the case."""


def compute(case: Computation, work: Work) -> Outcome:
    """Return the outcome of a case, computed and measured; errors of the case are outcomes, too."""
    stage, start, cpu = "setup", perf_counter(), process_time()
    try:
        with alarm(work.time_limit), caching(SHARED_ARRAYS):
            prepared = case.prepare()
            stage = "solve"
            result = case.run(prepared)
            stage = "measure"
            reserved = RESERVED_NAMES | work.axes
            variables = measured_variables(work.measures(case, result), reserved)
            recorded = measured_variables(case.record(result), reserved, "record")
            variables = (
                measured_variables(variables | recorded, reserved) if recorded else variables
            )
            check_size(variables)
            fields = (
                measured_variables(case.fields(result), (), "fields")
                if work.keeps_fields and isinstance(case, HasFields)
                else {}
            )
        seconds, cpu_seconds = perf_counter() - start, process_time() - cpu
        return Outcome(CaseStatus.OK, variables, None, seconds, fields, cpu_seconds)
    except TimeLimitError:
        return timed_out(work.time_limit, stage, perf_counter() - start)
    except StopRun:
        raise
    except BaseException as error:  # noqa: BLE001 (whatever a study's own code raises is data)
        return failed(error, stage, perf_counter() - start)


def timed(case: Computation, limit: float | None) -> Sample | Failure:
    """Return the times of one run of a case, or the failure that prevents them."""
    try:
        with alarm(limit):
            return time_once(case)
    except TimeLimitError:
        return too_late(limit, "timing")
    except StopRun:
        raise
    except BaseException as error:  # noqa: BLE001 (any error of a study's own code)
        return failure_of(error, "timing")


def time_once(case: Computation) -> Sample:
    """Return the wall and CPU time of one run of a case."""
    before = _reference_time()
    wall, cpu = perf_counter(), process_time()
    prepared = case.prepare()
    ready, ready_cpu = perf_counter(), process_time()
    case.run(prepared)
    finished, finished_cpu = perf_counter(), process_time()
    pace = max(before, _reference_time())
    threads = getattr(case, "threads", 1)
    return Sample(
        ready - wall, finished - ready, ready_cpu - cpu, finished_cpu - ready_cpu, threads, pace
    )


def _reference_time() -> float:
    """Return the seconds of a transform of 128 x 128 cells, the least of three."""
    least = np.inf
    for _ in range(3):
        start = perf_counter()
        np.fft.irfft2(np.fft.rfft2(REFERENCE_FIELD))
        least = min(least, perf_counter() - start)
    return float(least)


def failed(error: BaseException, stage: str, seconds: float) -> Outcome:
    """Return the outcome of a case that raised ``error``."""
    return Outcome(CaseStatus.FAILED, {}, failure_of(error, stage), seconds)


def failure_of(error: BaseException, stage: str) -> Failure:
    """Return the failure for an error that a case raised, with its place in the study's code."""
    name = one_line(type(error).__name__, 100)
    place = place_of(error, __file__, measured.__file__, time_limit.__file__)
    return Failure(name, f"{name}{place}: {one_line(error)}", stage)


def warm_up() -> None:
    """Make xarray look for optional packages, which takes 0.3 s at its first variable, before a case is timed."""
    xr.Variable((), 0.0)

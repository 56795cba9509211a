"""One case, computed and measured, or run once against the clock; whatever goes wrong is its outcome."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter, process_time
from types import FrameType
from typing import NoReturn

import numpy as np
import xarray as xr

from studies.model import measured
from studies.model.case import Computation
from studies.model.measured import measured_variables
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

WAVE = np.outer(np.cos(np.arange(128.0)), np.sin(np.arange(128.0)))
LONGEST_ALARM = 1e8  # seconds, three years: the system's timer takes no more
CAN_INTERRUPT = hasattr(signal, "setitimer")


class TimeLimitError(BaseException):
    """Raised amid a case; not an Exception, lest a study's own code catch it."""


class StopRun(BaseException):
    """The run is to stop: of all that is raised amid a case, the one that is not the case's own."""


def compute(case: Computation, work: Work) -> Outcome:
    """Compute and measure ``case``; a failure is an outcome, so that the others go on."""
    stage, start, cpu = "setup", perf_counter(), process_time()
    try:
        with _alarm(work.time_limit):
            prepared = case.prepare()
            stage = "solve"
            result = case.run(prepared)
            stage = "measure"
            taken = RESERVED_NAMES | work.axes
            variables = measured_variables(work.measures(case, result), taken)
            recorded = measured_variables(case.record(result), taken, "record")
            variables = measured_variables(variables | recorded, taken) if recorded else variables
            wanted = work.keeps_fields and isinstance(case, HasFields)
            fields = (
                measured_variables(case.fields(result), (), "fields")
                if wanted and isinstance(case, HasFields)
                else {}
            )
        seconds, worked = perf_counter() - start, process_time() - cpu
        return Outcome(CaseStatus.OK, variables, None, seconds, fields, worked)
    except TimeLimitError:
        return timed_out(work.time_limit, stage, perf_counter() - start)
    except StopRun:
        raise
    except BaseException as error:  # noqa: BLE001 (whatever a study's own code raises is data)
        return failed(error, stage, perf_counter() - start)


def timed(case: Computation, limit: float | None) -> Sample | Failure:
    """One run of ``case`` against the wall clock and the processor's, or why there is none."""
    try:
        with _alarm(limit):
            return time_once(case)
    except TimeLimitError:
        return _late(limit, "timing")
    except StopRun:
        raise
    except BaseException as error:  # noqa: BLE001 (it was computed before, so this is chance)
        failure = failed(error, "timing", 0.0).failure
        assert failure is not None
        return failure


def time_once(case: Computation) -> Sample:
    """One run of ``case``, against the wall clock and the processor's."""
    before = _reference_time()
    wall, cpu = perf_counter(), process_time()
    prepared = case.prepare()
    ready, ready_cpu = perf_counter(), process_time()
    case.run(prepared)
    done, done_cpu = perf_counter(), process_time()
    pace = max(before, _reference_time())
    threads = getattr(case, "threads", 1)
    return Sample(ready - wall, done - ready, ready_cpu - cpu, done_cpu - ready_cpu, threads, pace)


def _reference_time() -> float:
    """Seconds of a transform of 128 x 128 cells, the least of three."""
    least = np.inf
    for _ in range(3):
        start = perf_counter()
        np.fft.irfft2(np.fft.rfft2(WAVE))
        least = min(least, perf_counter() - start)
    return float(least)


def failed(error: BaseException, stage: str, seconds: float) -> Outcome:
    """The outcome of a case that raised ``error``."""
    name = one_line(type(error).__name__, 100)
    sentence = f"{name}{place_of(error, __file__, measured.__file__)}: {one_line(error)}"
    return Outcome(CaseStatus.FAILED, {}, Failure(name, sentence, stage), seconds)


def timed_out(limit: float | None, stage: str, seconds: float) -> Outcome:
    """The outcome of a case that took longer than ``limit`` [s]."""
    return Outcome(CaseStatus.TIMEOUT, {}, _late(limit, stage), seconds)


def _late(limit: float | None, stage: str) -> Failure:
    sentence = f"TimeLimitError: not done after {limit:g} s; give more with --time-limit"
    return Failure("TimeLimitError", sentence, stage)


@contextmanager
def _alarm(seconds: float | None) -> Iterator[None]:
    """An alarm that interrupts Python code; what never comes back from compiled code, it cannot.

    Windows has no alarm: there a supervisor ends the process of a case that is late.
    """
    if (
        seconds is None
        or not CAN_INTERRUPT
        or threading.current_thread() is not threading.main_thread()
    ):
        yield
        return

    def ring(_: int, __: FrameType | None) -> NoReturn:
        raise TimeLimitError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, min(seconds, LONGEST_ALARM))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def warm_up() -> None:
    """Make xarray look for optional packages, which takes 0.3 s at its first variable: not part of any case."""
    xr.Variable((), 0.0)

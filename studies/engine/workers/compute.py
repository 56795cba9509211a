"""Computation and timing of one case within its time limit, where any error is an outcome of the case."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from time import monotonic, perf_counter, process_time
from types import FrameType
from typing import NoReturn

import numpy as np
import xarray as xr

from contactstudy.domain.reuse import ArrayCache, caching
from studies.model import measured
from studies.model.case import Computation
from studies.model.measured import check_size, measured_variables
from studies.model.outcome import (
    RESERVED_NAMES,
    CaseStatus,
    Failure,
    HasFields,
    Outcome,
    RunSettings,
    TimedRun,
)
from studies.model.plain_text import one_line, place_of
from studies.store.stop import StopRun

# Arrays that cases of this process share, such as the coefficients of equal grids: up to so many bytes. Timed runs
# compute their own.
SHARED_ARRAYS = ArrayCache(2**26)
LONGEST_ALARM = 1e8  # seconds, three years: the system's timer takes no more
CAN_INTERRUPT = hasattr(signal, "setitimer")
REFERENCE_FIELD = np.outer(np.cos(np.arange(128.0)), np.sin(np.arange(128.0)))


def compute(case: Computation, settings: RunSettings) -> Outcome:
    """Return the outcome of a case, computed and measured; errors of the case are outcomes, too."""
    return _outcome_of(
        lambda stage: _measured(case, settings, stage), Stage("setup"), settings.time_limit
    )


def timed(case: Computation, limit: float | None) -> Outcome:
    """Return the outcome of a timed run of a case, which has a sample or the failure that prevents it."""
    return _outcome_of(
        lambda stage: Outcome(CaseStatus.OK, sample=time_once(case)), Stage("timing"), limit
    )


@dataclass
class Stage:
    """Name of the stage that a case has reached."""

    name: str


def _outcome_of(task: Callable[[Stage], Outcome], stage: Stage, limit: float | None) -> Outcome:
    """Return the outcome of a task of a case, or its failure within the limit [s]."""
    start = perf_counter()
    try:
        with alarm(limit):
            outcome = task(stage)
        return replace(outcome, seconds=perf_counter() - start)
    except TimeLimitError:
        return timed_out(limit, stage.name, perf_counter() - start)
    except StopRun:
        raise
    except BaseException as error:  # noqa: BLE001 (whatever a study's own code raises is data)
        return failed(error, stage.name, perf_counter() - start)


def _measured(case: Computation, settings: RunSettings, stage: Stage) -> Outcome:
    """Return the outcome of a case, computed and measured."""
    with caching(SHARED_ARRAYS):
        prepared = case.prepare()
        stage.name = "solve"
        result = case.run(prepared)
        stage.name = "measure"
        reserved, fields = RESERVED_NAMES | settings.axes, {}
        variables = measured_variables(settings.measures(case, result), reserved)
        if recorded := measured_variables(case.record(result), reserved, "record"):
            variables = measured_variables(variables | recorded, reserved)
        check_size(variables)
        if settings.keeps_fields and isinstance(case, HasFields):
            fields = measured_variables(case.fields(result), (), "fields")
    return Outcome(CaseStatus.OK, variables, fields=fields)


def time_once(case: Computation) -> TimedRun:
    """Return the wall and CPU time of one run of a case."""
    before = _reference_time()
    wall, cpu = perf_counter(), process_time()
    prepared = case.prepare()
    ready, ready_cpu = perf_counter(), process_time()
    case.run(prepared)
    finished, finished_cpu = perf_counter(), process_time()
    times = ready - wall, finished - ready, ready_cpu - cpu, finished_cpu - ready_cpu
    return TimedRun(*times, max(before, _reference_time()))


def _reference_time() -> float:
    """Return the wall time [s] of a fixed piece of work, a transform of 128 x 128 cells: the least of three."""
    least = np.inf
    for _ in range(3):
        start = perf_counter()
        np.fft.irfft2(np.fft.rfft2(REFERENCE_FIELD))
        least = min(least, perf_counter() - start)
    return float(least)


def timed_out(limit: float | None, stage: str, seconds: float) -> Outcome:
    """Return the outcome of a case that took longer than ``limit`` [s]."""
    # a timed run has a limit of its own
    remedy = "" if stage == "timing" else "; give more with --time-limit and --retry timeout"
    sentence = f"TimeLimitError: not done after {limit:g} s{remedy}"
    return Outcome(CaseStatus.TIMEOUT, {}, Failure("TimeLimitError", sentence, stage), seconds)


def failed(error: BaseException, stage: str, seconds: float = 0.0) -> Outcome:
    """Return the outcome of a case that raised `error`, with its place in the study's code."""
    name = one_line(type(error).__name__, 100)
    place = place_of(error, __file__, measured.__file__)
    failure = Failure(name, f"{name}{place}: {one_line(error)}", stage)
    return Outcome(CaseStatus.FAILED, {}, failure, seconds)


class TimeLimitError(BaseException):
    """Raised in a case that takes too long; not an Exception, so that code of a study does not catch it."""


@contextmanager
def alarm(limit: float | None) -> Iterator[None]:
    """Raise :class:`TimeLimitError` in the block after `limit` [s], in Python code of the main thread.

    Compiled code that never returns is not interrupted, and Windows has no alarm: there the supervisor ends the
    process at its :func:`deadline`.
    """
    if (
        limit is None
        or not CAN_INTERRUPT
        or threading.current_thread() is not threading.main_thread()
    ):
        yield
        return

    def ring(_: int, __: FrameType | None) -> NoReturn:
        raise TimeLimitError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, min(limit, LONGEST_ALARM))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def deadline(limit: float | None) -> float | None:
    """Return the time (of ``monotonic``) at which a supervisor ends a process that its alarm has not reached.

    A tenth of the limit and half a second more are for the alarm's own way back on a busy machine.
    """
    return None if limit is None else monotonic() + 1.1 * limit + 0.5


def limit_of_timed_run(expected: float, limit: float | None) -> float:
    """Return the time [s] after which a timed run of a case that took ``expected`` [s] is given up.

    It is far beyond what a busy machine adds, so that only a case that hangs is given up.
    """
    longest = 5 + 10 * expected
    return longest if limit is None else min(longest, limit)


def warm_up() -> None:
    """Make xarray look for optional packages, which takes 0.3 s at its first variable, before a case is timed."""
    xr.Variable((), 0.0)

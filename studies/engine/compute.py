"""Computation and timing of one case, where any error is an outcome of the case."""

import contextvars
import os
import random
from dataclasses import dataclass, replace
from time import perf_counter, process_time
from typing import Any

import numpy as np
import xarray as xr

from contactstudy.domain.device import ArrayCache, caching
from studies.model import outcome as outcomes
from studies.model.case import Computation
from studies.model.outcome import (
    RESERVED_NAMES,
    CaseStatus,
    Outcome,
    RunSettings,
    TimedRun,
    check_size,
    measured_variables,
)
from studies.model.plain_text import one_line, place_of
from studies.store.stop import StopRun

# Arrays that cases of this process share, such as the coefficients of equal grids: up to so many bytes. Timed runs
# compute their own.
SHARED_ARRAYS = ArrayCache(2**26)
# The first timed run of a kind of case that takes less [s] is preceded by an untimed one, so that imports and the first
# allocation of memory are not timed; in a longer case they are negligible.
MAX_WARM_UP = 0.3
# Kinds of cases that have run in this process.
WARM: set[type] = set()


@dataclass(frozen=True, eq=False)
class Task:
    """A case to compute; or to time once, where it is expected to take so many seconds."""

    key: str
    case: Computation
    expected: float | None = None

    @property
    def is_timed(self) -> bool:
        """True if the task is a timed run."""
        return self.expected is not None


def perform(task: Task, settings: RunSettings) -> Outcome:
    """Return the outcome of a task: a case computed and measured, or timed; its errors are outcomes, too.

    It does not depend on the tasks before it, unless these change their process: generators of random numbers start
    from the key of the case, and what is set for a context (such as numpy's error state) ends with it.
    """
    start, process = perf_counter(), os.getpid()
    seed = int(task.key[:8], 16)
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002 (for cases that use numpy's own generator)
    try:
        outcome = contextvars.copy_context().run(_timed if task.is_timed else _computed, task, settings)
        outcome = replace(outcome, seconds=perf_counter() - start)
    except StopRun:
        if os.getpid() == process:
            raise
    except BaseException as error:  # noqa: BLE001 (whatever a study's own code raises is data)
        outcome = failed(error, perf_counter() - start)
    if os.getpid() != process:
        # a case has forked, and this is its child, which must not go on with the run
        os._exit(0)
    return outcome


def _computed(task: Task, settings: RunSettings) -> Outcome:
    """Return the outcome of a case, computed and measured."""
    case: Any = task.case
    with caching(SHARED_ARRAYS):
        result = case.run(case.prepare())
        reserved, fields = RESERVED_NAMES | settings.axes, {}
        variables = measured_variables(settings.measures(case, result), reserved)
        if recorded := measured_variables(case.record(result), reserved, "record"):
            variables = measured_variables(variables | recorded, reserved)
        check_size(variables)
        if settings.keeps_fields and hasattr(case, "fields"):
            fields = measured_variables(case.fields(result), (), "fields")
    return Outcome(CaseStatus.OK, variables, fields=fields)


def _timed(task: Task, _: RunSettings) -> Outcome:
    """Return the outcome of a timed run of a case, which has its wall and CPU times."""
    case, expected = task.case, task.expected or 0.0
    if type(case) not in WARM and expected < MAX_WARM_UP:
        WARM.add(type(case))
        case.run(case.prepare())
    wall, cpu = perf_counter(), process_time()
    prepared = case.prepare()
    ready, ready_cpu = perf_counter(), process_time()
    case.run(prepared)
    finished, finished_cpu = perf_counter(), process_time()
    sample = TimedRun(ready - wall, finished - ready, ready_cpu - cpu, finished_cpu - ready_cpu)
    return Outcome(CaseStatus.OK, sample=sample)


def failed(error: BaseException, seconds: float = 0.0) -> Outcome:
    """Return the outcome of a case that raised `error`, with its place in the study's code."""
    name = one_line(type(error).__name__, 100)
    place = place_of(error, __file__, outcomes.__file__)
    return Outcome(CaseStatus.FAILED, {}, f"{name}{place}: {one_line(error)}", seconds)


def ended(status: CaseStatus, kind: str, sentence: str, seconds: float) -> Outcome:
    """Return the outcome of a case whose process ended during it."""
    return Outcome(status, {}, f"{kind}: {sentence}", seconds)


def warm_up() -> None:
    """Make xarray look for optional packages, which takes 0.3 s at its first variable, before a case is timed."""
    xr.Variable((), 0.0)

"""What became of a computation, as numbers a Dataset can hold."""

import signal
import threading
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from enum import IntEnum
from time import perf_counter, process_time
from types import FrameType
from typing import Any, NoReturn, Protocol, runtime_checkable

import numpy as np
import xarray as xr

from contactstudy import InvalidInput
from studies.model.case import Computation
from studies.model.study import Measures


class CaseStatus(IntEnum):
    """Whether a computation gave its numbers."""

    NOT_RUN = 0
    OK = 1
    FAILED = 2
    TIMEOUT = 3
    KILLED = 4
    SKIPPED = 5


# what the store says of every case itself; and what xarray's ``sel`` takes for its own, not for an axis
RESERVED_NAMES = frozenset(
    {"case_status", "case_key", "error", "error_type", "error_stage", "contended", "repeat"}
    | {"tolerance", "method", "drop"}
    | {
        f"{part}_time{end}"
        for part in ("setup", "solve")
        for end in ("", "_median", "_cpu", "_all")
    }
)


@dataclass(frozen=True)
class Failure:
    """The error's type and sentence, and whether it came with the setup, the solve or the measure."""

    kind: str
    sentence: str
    stage: str


@dataclass(frozen=True, eq=False)
class Outcome:
    """The variables of one computation, or the failure for which there are none.

    ``fields`` are those of the contact, where they were asked for; ``seconds`` and ``cpu`` what it all
    took, of wall and of CPU time [s].
    """

    case_status: CaseStatus
    variables: Mapping[str, xr.Variable] = field(default_factory=dict)
    failure: Failure | None = None
    seconds: float = 0.0
    fields: Mapping[str, xr.Variable] = field(default_factory=dict)
    cpu: float = 0.0

    @property
    def error(self) -> str:
        """The failure in a sentence, or nothing."""
        return self.failure.sentence if self.failure else ""


def summary_messages(found: Sequence[Outcome]) -> Iterator[str]:
    """What is to be said of all these: how many failed, and how many solves did not end as they should."""
    failed = [outcome.error for outcome in found if outcome.failure]
    if failed:
        yield f"{len(failed)} of {len(found)} cases failed, the first with {failed[0]}"
    ends = [one.variables["solver_status"] for one in found if "solver_status" in one.variables]
    if not_converged := sum(int(end) != 0 for end in ends):
        yield f"{not_converged} of {len(ends)} solves did not simply converge; see 'solver_status'"


@runtime_checkable
class HasFields(Protocol):
    """A computation whose result has fields to keep."""

    def fields(self, result: Any) -> Mapping[str, xr.Variable]:
        """The fields, with their coordinates."""
        ...


@dataclass(frozen=True, eq=False)
class Work:
    """What is done with every case: ``measures``, whether ``fields`` are kept, the ``time_limit`` [s]."""

    measures: Measures
    keeps_fields: bool = False
    time_limit: float | None = None


class NotANumberError(ArithmeticError):
    """A measure that is nan."""


class TimeLimitError(BaseException):
    """Raised amid a case; not an Exception, lest a study's own code catch it."""


def compute(case: Computation, work: Work) -> Outcome:
    """Compute and measure ``case``; a failure is an outcome, so that the others go on."""
    stage, start, cpu = "setup", perf_counter(), process_time()
    try:
        with _limit(work.time_limit):
            prepared = case.prepare()
            stage = "solve"
            result = case.run(prepared)
            stage = "measure"
            variables = _variables(work.measures(case, result), case.record(result))
            wanted = work.keeps_fields and isinstance(case, HasFields)
            fields = case.fields(result) if wanted and isinstance(case, HasFields) else {}
        taken, worked = perf_counter() - start, process_time() - cpu
        return Outcome(CaseStatus.OK, variables, None, taken, fields, worked)
    except TimeLimitError:
        return timed_out(work.time_limit, stage, perf_counter() - start)
    except (Exception, SystemExit) as error:  # noqa: BLE001 (whatever a study's own code raises is data)
        place = traceback.extract_tb(error.__traceback__)[-1]
        sentence = f"{type(error).__name__} in {place.name}: {error}"
        failure = Failure(type(error).__name__, sentence, stage)
        return Outcome(CaseStatus.FAILED, {}, failure, perf_counter() - start)


def timed_out(limit: float | None, stage: str, seconds: float) -> Outcome:
    """The outcome of a case that took longer than ``limit`` [s]."""
    sentence = f"TimeLimitError: not done after {limit:g} s; give more with --time-limit"
    return Outcome(CaseStatus.TIMEOUT, {}, Failure("TimeLimitError", sentence, stage), seconds)


@contextmanager
def _limit(seconds: float | None) -> Iterator[None]:
    """An alarm that interrupts Python code; what never comes back from compiled code, it cannot."""
    if seconds is None or threading.current_thread() is not threading.main_thread():
        yield
        return

    def ring(_: int, __: FrameType | None) -> NoReturn:
        raise TimeLimitError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _variables(*parts: Mapping[str, xr.Variable | float]) -> Mapping[str, xr.Variable]:
    measured = {name: value for part in parts for name, value in part.items()}
    if taken := RESERVED_NAMES & set(measured):
        raise InvalidInput(f"measures gives {sorted(taken)}: these names are taken, choose others.")
    found = {name: _variable(name, value) for name, value in measured.items()}
    for name, variable in found.items():
        if variable.dtype.kind in "fc" and np.isnan(variable.values).any():
            raise NotANumberError(f"{name} is nan")
    return found


def _variable(name: str, value: xr.Variable | float) -> xr.Variable:
    """A bare number gets its name for a label; an object must be text."""
    if not isinstance(value, xr.Variable):
        value = xr.Variable((), value, {"long_name": name.replace("_", " ")})
    if value.dtype.kind == "O":
        values = np.asarray(value.values)
        if not all(isinstance(one, str) for one in values.flat):
            raise InvalidInput(
                f"measures gives {name!r} as {values.flat[0]!r}: give numbers or text."
            )
        return xr.Variable(value.dims, values.astype(str), value.attrs)
    return value


def warm_up() -> None:
    """Have xarray look for dask, which it does at its first variable and takes 0.3 s: no case's own time."""
    xr.Variable((), 0.0)


Finished = Callable[[int, Outcome], None]

"""Outcomes of computations, and samples of their times, as variables that a Dataset can hold."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Protocol, runtime_checkable

import numpy as np
import xarray as xr

from contactstudy.io.dataset import flags
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


class Stored(Protocol):
    """A case that is stored, or a computation that has ended."""

    @property
    def case_status(self) -> CaseStatus:
        """What became of it."""
        ...

    def variable(self, name: str) -> xr.Variable | None:
        """What was measured under this name, if there is something."""
        ...

    @property
    def error(self) -> str:
        """The failure in a sentence, or nothing."""
        ...


def summary_messages(found: Iterable[Stored]) -> Iterator[str]:
    """How many cases failed, and how many solves ended otherwise than by converging."""
    cases = failed = solves = 0
    ended: Counter[str] = Counter()
    first = ""
    for one in found:
        cases += 1
        if one.case_status in (CaseStatus.FAILED, CaseStatus.TIMEOUT, CaseStatus.KILLED):
            failed += 1
            first = first or one.error
        elif (status := one.variable("solver_status")) is not None and status.ndim == 0:
            solves += 1
            if number := int(status.values.item()):
                ended[str(status.attrs["flag_meanings"]).split()[number].upper()] += 1
    if failed:
        yield f"{failed} of {cases} cases failed, the first with {first}"
    for name, count in ended.items():
        yield f"{count} of {solves} solves ended with {name}; see 'solver_status'"


@runtime_checkable
class HasFields(Protocol):
    """A computation whose result has fields to keep."""

    def fields(self, result: Any) -> Mapping[str, xr.Variable]:
        """The fields, with their coordinates."""
        ...


@dataclass(frozen=True, eq=False)
class Work:
    """What is done with every case: ``measures``, whether ``fields`` are kept, the ``time_limit`` [s].

    ``axes``: the names of the study's axes, which no measured variable may have.
    """

    measures: Measures
    keeps_fields: bool = False
    time_limit: float | None = None
    axes: frozenset[str] = frozenset()


Finished = Callable[[str, Outcome], None]


# A neighbour on the core takes CPU time away; one on the memory bus, or a slower clock, makes repeats
# differ, or a fixed piece of work take longer. Times are to hold within 10 %.
LEAST_SHARE = 0.95
SPREAD = 1.1


@dataclass(frozen=True)
class Sample:
    """One timed run of a case [s]: wall and CPU time of set-up and solve, and the threads of the case.

    ``pace``: what a fixed piece of work took beside it, the longer of before and after.
    """

    setup: float
    solve: float
    setup_cpu: float
    solve_cpu: float
    threads: int
    pace: float = 0.0


def is_contended(samples: Sequence[Sample], pace: float = np.inf) -> bool:
    """Whether the least time may be too long by a tenth.

    CPU time lacks, no repeat confirms it, or the processor was then slower than at its best, when
    the fixed piece of work took ``pace`` [s].
    """
    wall = np.array([sample.setup + sample.solve for sample in samples])
    cpu = np.array([sample.setup_cpu + sample.solve_cpu for sample in samples])
    least = int(wall.argmin())
    lacks = cpu[least] < LEAST_SHARE * wall[least]
    confirmed = len(wall) > 1 and np.sort(wall)[1] <= SPREAD * wall[least]
    return bool(lacks or not confirmed or samples[least].pace > SPREAD * pace)


CONTENDED = ("no", "yes", "not_timed")
PARTS = {
    "setup": "to set up coefficients and transforms",
    "solve": "to solve, or to apply an operator once",
}


def timing_variables(
    names: tuple[str, ...], index: np.ndarray, samples: Sequence[Sequence[Sample]]
) -> Mapping[str, xr.Variable]:
    """Least, median and CPU time of each case, every sample along ``repeat``, and whether it can be trusted.

    ``samples`` of distinct cases; ``index`` says which of them is at each point.
    """
    data = {}
    repeats = max((len(one) for one in samples), default=0)

    def seconds(attribute: str) -> np.ndarray:
        rows = [[getattr(s, attribute) for s in one] for one in samples]
        filled = [row + [np.nan] * (repeats - len(row)) for row in rows]
        return np.array(filled, dtype=float).reshape(len(samples), repeats)

    def variable(values: np.ndarray, what: str, *more: str) -> xr.Variable:
        return xr.Variable(names + more, values[index], {"units": "s", "long_name": what})

    for part, what in PARTS.items():
        wall, cpu = seconds(part), seconds(f"{part}_cpu")
        least, middle, least_cpu = np.full((3, len(samples)), np.nan)
        for row, one in enumerate(samples):
            if one:
                chosen = wall[row, : len(one)]
                least[row], middle[row] = chosen.min(), np.median(chosen)
                least_cpu[row] = cpu[row, chosen.argmin()]
        name = f"{part}_time"
        data[name] = variable(least, f"wall time {what}, one case at a time, least of the repeats")
        data[f"{name}_median"] = variable(middle, f"wall time {what}, median of the repeats")
        data[f"{name}_cpu"] = variable(
            least_cpu, f"CPU time {what}, in the repeat of least wall time"
        )
        if repeats:
            data[f"{name}_all"] = variable(wall, f"wall time {what}, every repeat", "repeat")
    pace = min((sample.pace for one in samples for sample in one), default=np.inf)
    marks = [
        int(is_contended(one, pace)) if one else CONTENDED.index("not_timed") for one in samples
    ]
    what = "whether something else may have slowed the timing down by a tenth"
    data["contended"] = flags(names, np.array(marks, dtype=np.int8)[index], CONTENDED, what)
    return data

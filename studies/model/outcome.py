"""What became of a computation, as numbers a Dataset can hold."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Protocol, runtime_checkable

import xarray as xr

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


Finished = Callable[[int, Outcome], None]

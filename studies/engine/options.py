"""Options of a run."""

from dataclasses import KW_ONLY
from typing import Annotated, Literal

from contactstudy import InvalidInput
from contactstudy.domain.validation import ABOVE_ZERO, at_least, validated
from studies.model.axis import MAX_VALUES
from studies.model.outcome import CaseStatus

# Statuses whose cases are computed again, by the name of the retry.
RETRIES = {
    "failed": {CaseStatus.FAILED, CaseStatus.TIMEOUT, CaseStatus.KILLED},
    "timeout": {CaseStatus.TIMEOUT},
    "killed": {CaseStatus.KILLED},
    "times": set[CaseStatus](),
}


@validated
class RunOptions:
    """Options of a run.

    Parameters
    ----------
    workers
        Processes that compute; 0 computes in this process.
    scheduler
        Address of a dask scheduler to compute through, in place of the workers.
    time_limit
        Longest time of a case in a worker process [s].
    repeats
        Timed runs of each case.
    retry
        What is computed again although it is stored: cases that "failed" (in any way), of which "timeout" and "killed"
        are two kinds, and all "times".
    fields
        "kept" to store the fields of every case, such as pressure and gap, or "none".
    max_points
        Largest number of points; None for no limit.

    Raises
    ------
    InvalidInput
        For a value that is none of these.
    """

    _: KW_ONLY
    workers: Annotated[int, at_least(0)] = 2
    scheduler: str | None = None
    time_limit: Annotated[float, ABOVE_ZERO] | None = None
    repeats: Annotated[int, at_least(0)] = 2
    retry: tuple[Literal["failed", "timeout", "killed", "times"], ...] = ()
    fields: Literal["none", "kept"] = "none"
    max_points: Annotated[int, at_least(1)] | None = MAX_VALUES

    def check_together(self) -> None:
        """Raise InvalidInput for a time limit without a process that can be ended."""
        if self.time_limit and not (self.workers or self.scheduler):
            raise InvalidInput(
                f"RunOptions.time_limit is {self.time_limit:g} and workers is 0: a case in this process cannot be ended "
                "alone; give workers=1 or more."
            )

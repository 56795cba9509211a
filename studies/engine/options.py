"""Options of a run."""

from dataclasses import dataclass

from contactstudy import InvalidInput
from contactstudy.domain.checks import whole_number
from studies.model.axis import MAX_POINTS, one_of
from studies.model.outcome import CaseStatus

# What ``--retry`` may name.
RETRIES = {
    "failed": frozenset({CaseStatus.FAILED, CaseStatus.TIMEOUT, CaseStatus.KILLED}),
    "timeout": frozenset({CaseStatus.TIMEOUT}),
    "killed": frozenset({CaseStatus.KILLED}),
}


@dataclass(frozen=True, kw_only=True)
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
    old_times
        "kept", or "dropped" to time every case again.
    retry
        Statuses whose cases are recomputed although they are stored.
    after_failure
        "continue", or "stop".
    fields
        "kept" to store the fields of every case, such as pressure and gap, or "none".
    max_points
        Largest number of points; None for no limit.

    Raises
    ------
    InvalidInput
        For a value that is none of these.
    """

    workers: int = 2
    scheduler: str | None = None
    time_limit: float | None = None
    repeats: int = 2
    old_times: str = "kept"
    retry: frozenset[CaseStatus] = frozenset()
    after_failure: str = "continue"
    fields: str = "none"
    max_points: int | None = MAX_POINTS

    def __post_init__(self) -> None:
        for name, choices in (
            ("old_times", ("kept", "dropped")),
            ("after_failure", ("continue", "stop")),
            ("fields", ("none", "kept")),
        ):
            one_of(name, getattr(self, name), choices)
        for name in ("workers", "repeats"):
            whole_number(name, getattr(self, name), 0, "must be a whole number, at least 0")
        if not all(isinstance(status, CaseStatus) for status in self.retry):
            raise InvalidInput(
                f"retry is {self.retry!r}: give a set of statuses, such as {{CaseStatus.FAILED}}."
            )
        if self.time_limit is not None and not self.time_limit > 0:
            raise InvalidInput(f"time_limit is {self.time_limit!r}: give seconds above 0.")
        if self.time_limit and not (self.workers or self.scheduler):
            raise InvalidInput(
                f"time_limit is {self.time_limit!r} and workers is 0: a case in this process cannot be ended alone; "
                "give workers=1 or more."
            )

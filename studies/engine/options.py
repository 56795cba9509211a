"""Options of a run of a study."""

import signal
from dataclasses import dataclass

from contactstudy import InvalidInput
from studies.model.axis import MOST_POINTS, one_of
from studies.model.outcome import CaseStatus

# What ``--retry`` may name.
RETRIES = {
    "failed": frozenset({CaseStatus.FAILED, CaseStatus.TIMEOUT, CaseStatus.KILLED}),
    "timeout": frozenset({CaseStatus.TIMEOUT}),
    "killed": frozenset({CaseStatus.KILLED}),
}


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of a run of a study.

    ``scheduler``: address of a dask scheduler, in place of ``workers`` processes (0: this one alone).
    ``time_limit`` [s] of a case. ``repeats``: timed runs of each case; ``old_times``: "kept" or "dropped".
    ``retry``: what is computed again though it is stored. ``after_failure``: "go on" or "stop".
    ``fields``: "none" or "kept", pressure and gap of every case. ``table``: whether the file holds all that is
    "stored" of the study, or only what was "requested". ``most_points``: more are refused; None for no bound.
    """

    workers: int = 2
    scheduler: str | None = None
    time_limit: float | None = None
    repeats: int = 2
    old_times: str = "kept"
    retry: frozenset[CaseStatus] = frozenset()
    after_failure: str = "go on"
    fields: str = "none"
    table: str = "stored"
    most_points: int | None = MOST_POINTS

    def __post_init__(self) -> None:
        for name, choices in (
            ("old_times", ("kept", "dropped")),
            ("after_failure", ("go on", "stop")),
            ("fields", ("none", "kept")),
            ("table", ("stored", "requested")),
        ):
            one_of(name, getattr(self, name), choices)
        if self.time_limit is not None and not self.time_limit > 0:
            raise InvalidInput(f"time_limit is {self.time_limit!r}: give seconds above 0.")
        if self.time_limit and not (self.workers or self.scheduler or hasattr(signal, "setitimer")):
            raise InvalidInput(
                f"time_limit is {self.time_limit!r} and workers is 0: this system cannot interrupt a case in its "
                "own process; give workers=1 or more."
            )

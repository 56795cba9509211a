"""Inventory of a study: which cases are stored, which are missing and why, and what these will cost."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from contactstudy import InvalidInput
from studies.engine.forecast import Forecast, forecast
from studies.engine.options import RunOptions
from studies.model.outcome import CaseStatus
from studies.model.study import Study
from studies.store.journal import Journal
from studies.store.provenance import machine
from studies.store.records import Record
from studies.store.request import Request
from studies.store.result_file import load_fields

SUFFIX = ".journal.jsonl"
Log = Callable[[str], object]


@dataclass(frozen=True, eq=False)
class Inventory:
    """Cases of a request, and those stored in the journal.

    Attributes
    ----------
    study, request
        The study and its cases.
    journal
        Stored results.
    options
        Options of the run.
    fields
        Folder of stored fields.
    """

    study: Study
    request: Request
    journal: Journal
    options: RunOptions
    fields: Path

    @property
    def repeats(self) -> int:
        """Number of timed runs of each case."""
        return self.options.repeats if self.study.times == "taken" else 0

    def record(self, name: str) -> Record | None:
        """Return the stored record of a case in the present context and with the present defaults; None without one."""
        record = self.journal.contents.records.get(name)
        identity = self.request.identities[name]
        return record if record is not None and record.is_of(identity) else None

    def records(self) -> Iterator[Record]:
        """Yield the stored record of each case that has one."""
        for name in self.request.cases:
            if (record := self.record(name)) is not None:
                yield record

    def missing(self, log: Log) -> list[str]:
        """Return the cases to compute, and report why stored ones cannot be used."""
        contents, missing = self.journal.contents, []
        changes: Counter[str] = Counter()
        for name, identity in self.request.identities.items():
            record = self.record(name)
            if record is not None and self._serves(record, log):
                continue
            if record is None and (contents.records or contents.other_records):
                changes[contents.reason_to_recompute(identity)] += 1
            missing.append(name)
        changes.pop("", None)  # new cases
        for change, count in changes.items():
            log(f"{count} stored cases are recomputed, since {change}")
        return missing

    def adopt(self, missing: Sequence[str]) -> int:
        """Store the missing cases that other studies in the folder hold, with their times, and return their number."""
        adopted = 0
        for path in sorted(self.journal.path.parent.glob(f"*{SUFFIX}")):
            if path == self.journal.path or self.options.fields == "kept":
                continue
            with suppress(InvalidInput):  # a damaged journal is no other study's concern
                contents = Journal(path, self.request.context, machine()).contents
                for name in missing:
                    record, identity = contents.records.get(name), self.request.identities[name]
                    if record is None or self.record(name) is not None:
                        continue
                    if record.case_status is CaseStatus.OK and record.is_of(identity):
                        loaded = contents.programs[record.stamp].loaded
                        self.journal.add(identity, replace(record.outcome, loaded=loaded))
                        for sample in contents.samples_of(name):
                            self.journal.time(name, sample)
                        adopted += 1
        return adopted

    def _serves(self, record: Record, log: Log) -> bool:
        """Return whether the stored record of a case is enough for the options."""
        wants_fields = self.options.fields == "kept" and record.case_status is CaseStatus.OK
        return record.case_status not in self.options.retry and (
            not wants_fields or load_fields(self.fields, record.key, record.stamp, log) is not None
        )

    def times_missing(self) -> dict[str, int]:
        """Return the number of missing timed runs of each good case, without cases that cannot be timed."""
        contents, retimed = self.journal.contents, self.options.old_times == "dropped"
        counts = {}
        for name in self.request.cases:
            record = self.record(name)
            if record is None or record.case_status is not CaseStatus.OK:
                continue
            stored = 0 if retimed else len(contents.samples_of(name))
            if stored < self.repeats and (retimed or not contents.reason_without_times(name)):
                counts[name] = self.repeats - stored
        return counts

    def state(self) -> str:
        """Return a sentence on how many cases are stored, and how many timed runs are missing."""
        stored = sum(1 for _ in self.records())
        missing = sum(self.times_missing().values())
        times = f", {missing} timed runs are missing" if missing else ""
        return f"{stored} of {len(self.request.cases)} cases are stored{times}"

    def forecast(self, missing: Sequence[str], scale: float) -> Forecast:
        """Return `scale` times the expected cost of the `missing` cases and timed runs."""
        runs = sum(self.times_missing().values()) + self.repeats * len(missing)
        return forecast([self.request.cases[name] for name in missing], runs, scale)

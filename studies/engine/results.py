"""Results of a study in a folder: which cases are stored, which are missing and why, and the netCDF file of them.

Fields of a case have a file of their own while cases are computed, and are groups of the netCDF in the end.
"""

import hashlib
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic

import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.files import read_verified, reason, set_aside, write_with_checksum
from studies.engine.options import RunOptions
from studies.model.outcome import CaseStatus, Outcome
from studies.model.plain_text import Log, one_line
from studies.model.study import Study
from studies.store.journal import Journal
from studies.store.netcdf import read, write
from studies.store.provenance import machine
from studies.store.records import Record, decoded_variable, encoded_variable
from studies.store.request import Request
from studies.store.table import PointTable, assemble, stored_table

SUFFIX = ".journal.jsonl"
MIN_WRITE_INTERVAL = 60.0  # least seconds between two writes while cases are computed
WRITE_INTERVAL_FACTOR = 20  # least ratio of the time between two writes to the time of one


@dataclass(eq=False)
class Results:
    """Results of a study in a folder.

    The netCDF file beside the `journal` has the points of the `table`, with the `provenance` of the run that writes
    it; `skipped` are the keys of the cases that a stopped run left out. It is not written again before `next_write`
    (of ``monotonic``).
    """

    study: Study
    request: Request
    journal: Journal
    options: RunOptions
    log: Log
    provenance: Mapping[str, str] = field(default_factory=dict)
    skipped: set[str] = field(default_factory=set)
    next_write: float = 0.0

    @classmethod
    def of(
        cls, study: Study, request: Request, folder: Path, options: RunOptions, log: Log
    ) -> "Results":
        """Return the results of a study in a folder; stored values of axes replace those equal up to rounding."""
        journal = Journal(folder / f"{study.name}{SUFFIX}", request.context, machine())
        axes = tuple(axis.with_stored(journal.axes.get(axis.name, ())) for axis in study.axes)
        for axis in axes:
            if axis.merged:
                log(
                    f"{axis.merged} values of {axis.name} differ from others by rounding alone, and are replaced by them"
                )
        if axes != study.axes:
            study = replace(study, axes=axes)
            request = Request.of(study)
        return cls(study, request, journal, options, log)

    def __post_init__(self) -> None:
        self.table = PointTable(self.study.axes, self.request.keys)

    @property
    def path(self) -> Path:
        """Path of the netCDF file."""
        return self.journal.path.parent / f"{self.study.name}.nc"

    @property
    def fields_folder(self) -> Path:
        """Path of the folder of fields that go into the file."""
        return self.journal.path.parent / f"{self.study.name}.fields"

    @property
    def repeats(self) -> int:
        """Number of timed runs of each case."""
        return self.options.repeats if self.study.times == "taken" else 0

    def record(self, name: str) -> Record | None:
        """Return the stored record of a case by this program with the defaults that it has now; None without one."""
        record, identity = self.journal.records.get(name), self.request.identities.get(name)
        is_right = record is not None and (identity is None or record.is_of(identity))
        return record if is_right else None

    def missing(self) -> list[str]:
        """Return the cases to compute, and report why stored ones cannot be used."""
        for note in (*self.journal.notes, *self.study.notes):
            self.log(note)
        missing = []
        changes: Counter[str] = Counter()
        for name, identity in self.request.identities.items():
            record = self.record(name)
            if record is not None and self._is_sufficient(record):
                continue
            if record is None and (self.journal.records or self.journal.other_records):
                changes[self.journal.reason_to_recompute(identity)] += 1
            missing.append(name)
        changes.pop("", None)  # new cases
        for change, count in changes.items():
            self.log(f"{count} stored cases are recomputed, since {change}")
        return missing

    def _is_sufficient(self, record: Record) -> bool:
        """Return whether the stored record of a case is enough for the options."""
        if record.case_status in self.options.retry:
            return False
        if self.options.fields != "kept" or record.case_status is not CaseStatus.OK:
            return True
        return load_fields(self.fields_folder, record.key, record.stamp, self.log) is not None

    def copy_from_other_studies(self, missing: Sequence[str]) -> list[str]:
        """Store the missing cases that other studies in the folder hold, with their times; return the others."""
        copied: set[str] = set()
        for path in sorted(self.journal.path.parent.glob(f"*{SUFFIX}")):
            if path == self.journal.path or self.options.fields == "kept":
                continue
            with suppress(InvalidInput):  # a damaged journal is no other study's concern
                other_journal = Journal(path, self.request.context, machine())
                for name in (other_journal.records.keys() & set(missing)) - copied:
                    record, identity = other_journal.records[name], self.request.identities[name]
                    if record.case_status is CaseStatus.OK and record.is_of(identity):
                        loaded = other_journal.programs[record.stamp].loaded
                        self.journal.add(identity, replace(record.outcome, loaded=loaded))
                        for sample in other_journal.samples_of(name):
                            self.journal.add_timed_run(name, sample)
                        copied.add(name)
        if copied:
            self.log(f"{len(copied)} cases are taken over from other studies in the folder")
        return [name for name in missing if name not in copied]

    def missing_timed_runs(self) -> dict[str, int]:
        """Return the number of missing timed runs of each successful case, without cases that cannot be timed."""
        retimed, counts = self.options.old_times == "dropped", {}
        for name in self.request.cases if self.repeats else ():
            record = self.record(name)
            if record is None or record.case_status is not CaseStatus.OK:
                continue
            stored = 0 if retimed else len(self.journal.samples_of(name))
            if stored < self.repeats and (retimed or not self.journal.reason_without_times(name)):
                counts[name] = self.repeats - stored
        return counts

    def extend_table(self) -> None:
        """Take all stored points of the study into the file, where the options do not say otherwise."""
        if self.options.table == "stored":
            self.table = stored_table(self.study, self.request, self.journal)

    def stored(self) -> xr.Dataset | None:
        """Return the Dataset in the file; None unless it has all that the journal has of its points."""
        with suppress(InvalidInput):
            dataset = read(self.path)
            if dataset.attrs.get("content_hash") == self._content_hash():
                return dataset
        return None

    def _content_hash(self) -> str:
        """Return a hash of all that the file shows: its points and attributes, records, and timed runs."""
        about = [self.study.title, self.study.notes, self.table.axes, sorted(self.skipped)]
        content = hashlib.blake2b(repr(about).encode(), digest_size=6)
        content.update(self.journal.times.digest())
        for name in self.table.keys:
            record = self.journal.records.get(name)
            content.update(name.encode() if record is None else record.raw)
        return content.hexdigest()

    def write(self, *, fields: str = "none") -> None:
        """Write the file, with a group for every case that has fields if these are "kept"."""
        start = monotonic()
        dataset = assemble(self.table, self._outcome, self.journal.samples_of, self._attributes())
        write(dataset, self.path, self._groups() if fields == "kept" else ())
        end = monotonic()
        self.next_write = end + max(MIN_WRITE_INTERVAL, WRITE_INTERVAL_FACTOR * (end - start))

    def _outcome(self, name: str) -> Outcome | None:
        """Return the outcome of a case; None if there is none."""
        if (record := self.record(name)) is not None:
            return record.outcome
        return Outcome(CaseStatus.SKIPPED) if name in self.skipped else None

    def _attributes(self) -> dict[str, str]:
        """Return the attributes of the file."""
        history = self.journal.history
        notes = {"notes": "\n".join(self.study.notes)} if self.study.notes else {}
        return {
            **notes,
            **self.study.attributes,
            **self.provenance,
            "study": self.study.name,
            "title": one_line(self.study.title),
            "first_case": one_line(next(iter(self.request.cases.values()))),
            "history": "\n".join(history),
            "date_created": history[0].split()[0],
            "date_modified": datetime.now(UTC).isoformat(timespec="seconds"),
            "case_versions": self._versions(),
            "content_hash": self._content_hash(),
            "timing": "wall time, least of the repeats, one case at a time, on one thread where no axis says more",
        }

    def _versions(self) -> str:
        """Return the versions of all distributions that the cases were computed with, and the study's part."""
        versions = dict(self.request.context.part)
        for stamp in {record.stamp for record in self.journal.records.values()}:
            loaded = self.journal.programs[stamp].loaded
            versions |= {name: loaded[name] for name in loaded if not name.startswith("module")}
        named = ((name.removeprefix("distribution "), versions[name]) for name in sorted(versions))
        return ", ".join(f"{name} {version}" for name, version in named)

    def _groups(self) -> Iterator[tuple[str, xr.Dataset]]:
        """Yield the fields of every case that has some, read one at a time."""
        for name in dict.fromkeys(self.table.keys):
            record = self.journal.records.get(name)
            if record is not None:
                fields = load_fields(self.fields_folder, name, record.stamp)
                if fields is not None:
                    yield f"fields/case_{name}", fields


def save_fields(folder: Path, key: str, stamp: str, variables: Mapping[str, xr.Variable]) -> None:
    """Write the fields of the case `key`, computed by the program `stamp`, to a file that is then on the disk."""
    fields = {name: encoded_variable(variable) for name, variable in variables.items()}
    content = {"program": stamp, "fields": fields}
    try:
        write_with_checksum(folder / f"{key}.json", json.dumps(content).encode())
    except OSError as error:
        raise InvalidInput(
            f"Fields in {str(folder)!r} cannot be written ({reason(error, folder / key)}): what was stored is "
            "kept; make room or give another folder with --out, and run the same command again."
        ) from None


def load_fields(
    folder: Path, key: str, stamp: str, log: Log = lambda text: None
) -> xr.Dataset | None:
    """Return the fields of a case that a program computed; None where there are none.

    A damaged file is set aside, which is reported to `log`. A variable named like its dimension is its coordinate.
    """
    path = folder / f"{key}.json"
    if not path.is_file():
        return None
    content = read_verified(path)
    if content is None:
        log(
            f"{path} is damaged: it is set aside as {set_aside(path).name}, and its case is recomputed"
        )
        return None
    stored = json.loads(content)
    if stored.get("program") != stamp:
        return None
    return xr.Dataset({name: decoded_variable(v) for name, v in stored["fields"].items()})

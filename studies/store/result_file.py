"""The netCDF file of a study, written from its journal, and the fields that go into it.

Fields of a case have a file of their own while cases are computed, and are groups of the netCDF in the end.
"""

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic

import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.files import read_verified, reason, set_aside, write_with_checksum
from contactstudy.domain.identity import key
from studies.model.outcome import CaseStatus, Outcome
from studies.model.plain_text import one_line
from studies.model.study import Study
from studies.store.journal import Journal
from studies.store.journal_lines import decoded_variable, encoded_variable
from studies.store.netcdf import read, write
from studies.store.request import Request
from studies.store.table import PointTable, assemble


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
    folder: Path, key: str, stamp: str, log: Callable[[str], object] = lambda text: None
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


MIN_WRITE_INTERVAL = 60.0  # least seconds between two writes while cases are computed
WRITE_INTERVAL_FACTOR = 20  # least ratio of the time between two writes to the time of one


@dataclass(eq=False)
class ResultFile:
    """The netCDF file of a study, beside its journal.

    Attributes
    ----------
    study, request, journal
        The study, its cases, and their results.
    table
        Points of the file.
    provenance
        Attributes of the run that writes.
    skipped
        Keys of the cases that a stopped run left out.
    next_write
        Time (of ``monotonic``) before which the file is not written again.
    """

    study: Study
    request: Request
    journal: Journal
    table: PointTable
    provenance: Mapping[str, str] = field(default_factory=dict)
    skipped: set[str] = field(default_factory=set)
    next_write: float = 0.0

    @property
    def path(self) -> Path:
        """Path of the netCDF file."""
        return self.journal.path.parent / f"{self.study.name}.nc"

    @property
    def fields_folder(self) -> Path:
        """Path of the folder of fields that go into the file."""
        return self.journal.path.parent / f"{self.study.name}.fields"

    def stored(self) -> xr.Dataset | None:
        """Return the Dataset in the file; None unless it has all that the journal has of its points."""
        try:
            dataset = read(self.path)
        except InvalidInput:
            return None
        return dataset if dataset.attrs.get("content_hash") == self._content_hash() else None

    def _content_hash(self) -> str:
        """Return a hash of all that the file shows: its points and attributes, records, and numbers of timed runs."""
        contents, content = self.journal.contents, hashlib.blake2b(digest_size=6)
        shown = [self.study.title, self.study.notes, [str(axis) for axis in self.table.axes]]
        content.update(str([*shown, contents.epoch, sorted(self.skipped)]).encode())
        for name in self.table.keys:
            record = contents.records.get(name)
            content.update(name.encode() if record is None else record.raw)
        for (name, _), samples in contents.samples.items():
            content.update(f"{name} {len(samples)}".encode())
        return content.hexdigest()

    def write(self, *, fields: str = "none") -> None:
        """Write the file, with a group for every case that has fields if these are "kept"."""
        start = monotonic()
        contents = self.journal.contents
        now = datetime.now(UTC).isoformat(timespec="seconds")
        attributes = self._attributes() | {"date_modified": now}
        dataset = assemble(
            self.table.axes, self.table.keys, self._outcome, contents.samples_of, attributes
        )
        write(dataset, self.path, self._groups() if fields == "kept" else ())
        end = monotonic()
        self.next_write = end + max(MIN_WRITE_INTERVAL, WRITE_INTERVAL_FACTOR * (end - start))

    def _outcome(self, name: str) -> Outcome | None:
        """Return the outcome of a case; None if there is none."""
        identity = self.request.identities.get(name)
        record = self.journal.contents.records.get(name)
        if record is not None and (identity is None or record.is_of(identity)):
            return record.outcome
        return Outcome(CaseStatus.SKIPPED) if name in self.skipped else None

    def _attributes(self) -> dict[str, object]:
        """Return the attributes of the file."""
        first = next(iter(self.request.cases.values()))
        history = self.journal.contents.history
        notes = {"notes": "\n".join(self.study.notes)} if self.study.notes else {}
        attributes: dict[str, object] = {
            "study": self.study.name,
            "title": one_line(self.study.title),
            "first_case": _shown(first),
            "history": "\n".join(history),
            "date_created": history[0].split()[0],
            "case_versions": self._versions(),
            "parameter_hash": key(list(self.table.keys)),
            "content_hash": self._content_hash(),
            "timing": "wall time, least of the repeats, one case at a time, on one thread where no axis says more",
        }
        return notes | dict(self.study.attributes) | dict(self.provenance) | attributes

    def _versions(self) -> str:
        """Return the versions of all distributions that the cases were computed with, and the study's part."""
        versions = dict(self.request.context.part)
        contents = self.journal.contents
        for stamp in {record.stamp for record in contents.records.values()}:
            loaded = contents.programs[stamp].loaded
            versions |= {
                name: value for name, value in loaded.items() if not name.startswith("module")
            }
        return ", ".join(
            f"{name.removeprefix('distribution ')} {versions[name]}" for name in sorted(versions)
        )

    def _groups(self) -> Iterator[tuple[str, xr.Dataset]]:
        """Yield the fields of every case that has some, read one at a time."""
        for name in dict.fromkeys(self.table.keys):
            record = self.journal.contents.records.get(name)
            if record is not None:
                fields = load_fields(self.fields_folder, name, record.stamp)
                if fields is not None:
                    yield f"fields/case_{name}", fields


def _shown(case: object) -> str:
    """Return the representation of a case in one line."""
    try:
        return one_line(repr(case))
    except Exception:  # noqa: BLE001 (a study's own class may do anything)
        return one_line(type(case).__name__)

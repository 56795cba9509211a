"""Fields of a study's cases: a file each while they are computed, groups of the study's netCDF in the end."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic

import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.files import reason, replacing
from studies.model.outcome import CaseStatus, Outcome
from studies.model.plain_text import one_line
from studies.model.study import Study
from studies.store.identity import key
from studies.store.journal import Journal
from studies.store.journal_lines import VariableTypes, decoded, encoded
from studies.store.netcdf import read, write
from studies.store.request import Request
from studies.store.table import PointTable, assemble


def save_fields(folder: Path, key: str, variables: Mapping[str, xr.Variable]) -> None:
    """``variables`` of the case ``key``, on disk when this returns."""
    kinds, values = VariableTypes().encode(variables)
    try:
        with replacing(folder / f"{key}.json") as partial, partial.open("xb") as file:
            file.write(encoded({"kinds": kinds, "values": values}))
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise InvalidInput(
            f"Fields in {str(folder)!r} cannot be written ({reason(error, folder / key)}): what was stored is "
            "kept; make room or give another folder with --out, and run the same command again."
        ) from None


def has_fields(folder: Path, key: str) -> bool:
    """Whether the case ``key`` has its fields here."""
    return (folder / f"{key}.json").is_file()


def load_fields(folder: Path, key: str) -> xr.Dataset | None:
    """The fields of the case ``key``; a variable named like its dimension is its coordinate.

    None for a damaged file, which is renamed, so that the case is computed for its fields again.
    """
    path = folder / f"{key}.json"
    held = decoded(path.read_bytes())
    if held is None:
        path.replace(path.with_suffix(".damaged"))
        return None
    kinds = VariableTypes()
    for name, kind in held["kinds"].items():
        kinds.add(name, kind)
    variables = kinds.decode(held["values"])
    coords = {name: v for name, v in variables.items() if v.dims == (name,)}
    data = {name: v for name, v in variables.items() if name not in coords}
    return xr.Dataset(data, coords)


OFTEN = 60.0  # seconds between two writes while cases are computed
SHARE = 20  # a write takes at most one part in so many of the time


@dataclass(eq=False)
class ResultFile:
    """``<folder>/<study>.nc``, and ``fields_folder``, the folder of fields that go into it at the end.

    ``provenance`` is the provenance of the run that writes; ``skipped`` the cases that a stopped run leaves out.
    """

    study: Study
    request: Request
    folder: Path
    journal: Journal
    table: PointTable
    provenance: Mapping[str, str] = field(default_factory=dict)
    skipped: set[str] = field(default_factory=set)
    next_write: float = 0.0

    @property
    def path(self) -> Path:
        """The file."""
        return self.folder / f"{self.study.name}.nc"

    @property
    def fields_folder(self) -> Path:
        """The folder."""
        return self.folder / f"{self.study.name}.fields"

    def write(self, *, fields: str = "none") -> None:
        """All there is, with a group for every case that has fields if these are "kept"."""
        start = monotonic()
        contents = self.journal.contents
        now = datetime.now(UTC).isoformat(timespec="seconds")
        attributes = self._attributes() | dict(contents.score) | {"date_modified": now}
        dataset = assemble(
            self.table.axes, self.table.keys, self._outcome, contents.samples, attributes
        )
        write(dataset, self.path, self._groups() if fields == "kept" else ())
        end = monotonic()
        self.next_write = end + max(OFTEN, SHARE * (end - start))

    def read(self) -> xr.Dataset:
        """What was written."""
        return read(self.path)

    def _outcome(self, name: str) -> Outcome | None:
        identity = self.request.identities.get(name)
        record = self.journal.contents.records.get(name)
        if record is not None and (identity is None or record.is_of(identity)):
            return record.outcome
        return Outcome(CaseStatus.SKIPPED) if name in self.skipped else None

    def _attributes(self) -> dict[str, object]:
        first = next(iter(self.request.cases.values()))
        history = self.journal.contents.history
        said = {"notes": "\n".join(self.study.notes)} if self.study.notes else {}
        own: dict[str, object] = {
            "study": self.study.name,
            "title": one_line(self.study.title),
            "first_case": _shown(first),
            "history": "\n".join(history),
            "date_created": history[0].split()[0],
            "case_versions": ", ".join(f"{k} {v}" for k, v in self.request.context.items()),
            "parameter_hash": key(list(self.table.keys)),
            "timing": "wall time, least of the repeats, one case at a time, on one thread where no axis says more",
        }
        return said | dict(self.study.attributes) | dict(self.provenance) | own

    def _groups(self) -> Iterator[tuple[str, xr.Dataset]]:
        """Of every case with fields, read when it is written."""
        for name in dict.fromkeys(self.table.keys):
            if name and has_fields(self.fields_folder, name):
                held = load_fields(self.fields_folder, name)
                if held is not None:
                    yield f"fields/case_{name}", held


def _shown(case: object) -> str:
    try:
        return one_line(repr(case))
    except Exception:  # noqa: BLE001 (a study's own class may do anything)
        return one_line(type(case).__name__)

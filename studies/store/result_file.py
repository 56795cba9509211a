"""The netCDF file of a study: written anew, from the outcomes and the journal, as often as is wanted."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic

import xarray as xr

from studies.model.outcome import Outcome
from studies.model.study import Study
from studies.store import fields as stored_fields
from studies.store.identity import key
from studies.store.journal import Journal
from studies.store.netcdf import assemble, read, write
from studies.store.request import Request


@dataclass(eq=False)
class ResultFile:
    """``<folder>/<study>.nc``, and ``fields_folder``, the folder of fields that go into it at the end.

    ``provenance`` is the provenance of the run that writes, ``written`` the clock's time of the last write [s].
    """

    study: Study
    request: Request
    folder: Path
    journal: Journal
    provenance: Mapping[str, str] = field(default_factory=dict)
    written: float = 0.0

    @property
    def path(self) -> Path:
        """The file."""
        return self.folder / f"{self.study.name}.nc"

    @property
    def fields_folder(self) -> Path:
        """The folder."""
        return self.folder / f"{self.study.name}.fields"

    def write(self, outcomes: Mapping[str, Outcome], *, fields: str = "none") -> None:
        """All there is, with a group for every case that has fields if these are "kept"."""
        contents = self.journal.contents
        now = datetime.now(UTC).isoformat(timespec="seconds")
        attributes = self._attributes() | dict(contents.score) | {"date_modified": now}
        points, keys = self.study.points, self.request.keys
        dataset = assemble(points, keys, outcomes, contents.samples, attributes)
        write(dataset, self.path, self._groups() if fields == "kept" else ())
        self.written = monotonic()

    def read(self) -> xr.Dataset:
        """What was written."""
        return read(self.path)

    def _attributes(self) -> dict[str, object]:
        first = next(iter(self.request.cases.values()))
        history = self.journal.contents.history
        return {"title": self.study.title, "first_case": repr(first)} | dict(self.provenance) | {
            "history": "\n".join(history),
            "date_created": history[0].split()[0],
            "case_versions": ", ".join(f"{k} {v}" for k, v in self.request.context.items()),
            "parameter_hash": key(list(self.request.keys)),
            "timing": "wall time, least of the repeats, one case at a time, one thread",
            "timing_threads": 1,
        }  # fmt: skip

    def _groups(self) -> Iterator[tuple[str, xr.Dataset]]:
        """Of every case with fields, read when it is written."""
        for name in self.request.cases:
            if stored_fields.exist(self.fields_folder, name):
                yield f"fields/case_{name}", stored_fields.load(self.fields_folder, name)

"""What a study found, line by line as it was found: nothing that stands in it is ever changed."""

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any, Self

import xarray as xr

from contactstudy import InvalidInput
from studies.model.outcome import CaseStatus, Failure, Outcome
from studies.model.timing_samples import Sample
from studies.store.encoding import VariableTypes
from studies.store.identity import Tree, differences

NO_RUN: Mapping[str, Any] = {"context": {}, "machine": "", "provenance": {"history": ""}}

# A case that took longer is on disk at once, shorter ones together: a write to disk takes 0.3 ms.
SYNC_INTERVAL = 0.05


@dataclass(frozen=True, eq=False)
class CaseIdentity:
    """A case by its ``key``, as a ``tree``, with the first ``point`` that asks for it."""

    key: str
    tree: Tree
    point: Mapping[str, str]


@dataclass(frozen=True, eq=False)
class Record:
    """What is stored of a case; ``size`` is that of its line [bytes]."""

    identity: CaseIdentity
    outcome: Outcome
    context: Mapping[str, str]
    size: int


@dataclass(eq=False)
class Contents:
    """What a journal says: records of the present ``context``, others, and timings by machine."""

    records: dict[str, Record] = field(default_factory=dict)
    others: dict[str, Record] = field(default_factory=dict)
    samples: dict[str, list[Sample]] = field(default_factory=dict)
    begun: str | None = None
    history: list[str] = field(default_factory=list)
    score: Mapping[str, float] = field(default_factory=dict)
    _at: dict[tuple[tuple[str, str], ...], Record] = field(default_factory=dict)

    def keep(self, record: Record, *, is_present: bool) -> None:
        """Add a record, in place of one of the same case."""
        (self.records if is_present else self.others)[record.identity.key] = record
        self._at[tuple(sorted(record.identity.point.items()))] = record

    def changed(self, identity: CaseIdentity) -> list[str]:
        """How the case last stored for ``identity``, or at its point, differs from it, if there is one."""
        before = self.records.get(identity.key) or self.others.get(identity.key)
        before = before or self._at.get(tuple(sorted(identity.point.items())))
        return [] if before is None else differences(before.identity.tree, identity.tree)


class Journal:
    """The journal at ``path``, read, and open to be written on; a torn last line is cut off.

    Lines are ``run`` (who writes from here on), ``kind`` (see :class:`~studies.store.encoding.Kinds`), ``begin``,
    ``case``, ``time``, ``retime`` and ``score``. Records of another ``context``, and times of another
    ``machine``, are kept apart; without a context all count, and nothing can be written. Only one process
    at a time may have it open.
    """

    def __init__(self, path: Path, context: Mapping[str, str] | None, machine: str) -> None:
        self.path = path
        self.contents = Contents()
        self._context, self._machine = context, machine
        self._types = VariableTypes()
        self._synced = monotonic()
        self._end = self._read()
        self._file: Any = None

    def __enter__(self) -> Self:
        try:
            self._file = self.path.open("r+b" if self.path.exists() else "w+b", buffering=0)
            self._file.truncate(self._end)
            self._file.seek(self._end)
        except OSError as error:
            raise self._refused(error) from None
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None or not issubclass(kind, InvalidInput):
            self.sync()
        self._file.close()

    def start(self, provenance: Mapping[str, str]) -> None:
        """A run begins, in the present context."""
        run = {
            "context": dict(self._present),
            "machine": self._machine,
            "provenance": dict(provenance),
        }
        self._write({"run": run})
        self.contents.history.append(provenance["history"])
        self.sync()

    @property
    def _present(self) -> Mapping[str, str]:
        assert self._context is not None, (
            "a journal that is read whatever its context is not written"
        )
        return self._context

    def score(self, found: Mapping[str, float]) -> None:
        """Write down how far off the forecast was."""
        self._write({"score": dict(found)})
        self.contents.score = found

    def begin(self, key: str) -> None:
        """This process itself begins a case: should it die, the next will know in which."""
        self._write({"begin": key})

    def add(self, identity: CaseIdentity, outcome: Outcome) -> bool:
        """Write down a case; returns whether all cases so far are on disk."""
        new, variables = self._types.encode(outcome.variables)
        for kind in new:
            self._write({"kind": kind})
        line: dict[str, Any] = {
            "case": identity.key,
            "status": outcome.case_status.name.lower(),
            "point": dict(identity.point),
            "tree": identity.tree,
            "seconds": outcome.seconds,
            "cpu": outcome.cpu,
            "values": variables,
        }
        if outcome.failure is not None:
            line["failure"] = asdict(outcome.failure)
        self.contents.keep(
            Record(identity, outcome, self._present, self._write(line)), is_present=True
        )
        if outcome.seconds > SYNC_INTERVAL / 2 or monotonic() - self._synced > SYNC_INTERVAL:
            self.sync()
            return True
        return False

    def time(self, key: str, sample: Sample) -> None:
        """Write down a timed run."""
        self._write({"time": key, "sample": asdict(sample)})
        self.contents.samples.setdefault(key, []).append(sample)
        if monotonic() - self._synced > SYNC_INTERVAL:
            self.sync()

    def forget_times(self) -> None:
        """Let the samples of all runs before this count no more."""
        self._write({"retime": True})
        self.contents.samples.clear()

    def sync(self) -> None:
        """Have everything on disk."""
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            raise self._refused(error) from None
        self._synced = monotonic()

    def _write(self, line: Mapping[str, Any]) -> int:
        encoded = json.dumps(line, separators=(",", ":")).encode() + b"\n"
        try:
            if self._file.write(encoded) < len(encoded):
                raise OSError(28, "No space left on device")
        except OSError as error:
            self._file.truncate(self._end)
            raise self._refused(error) from None
        self._end += len(encoded)
        return len(encoded)

    def _refused(self, error: OSError) -> InvalidInput:
        return InvalidInput(
            f"Journal {str(self.path)!r} cannot be written ({error.strerror}): what was stored is kept; "
            "make room or give another folder with --out, and run the same command again."
        )

    def _read(self) -> int:
        """Read what there is; returns where the last whole line ends."""
        end, run = 0, NO_RUN
        try:
            with self.path.open("rb") as file:
                for raw in file:
                    if not raw.endswith(b"\n"):
                        break
                    try:
                        line = json.loads(raw)
                    except ValueError:  # torn amid the file by a crash of the system
                        line = {}
                    end += len(raw)
                    run = line.get("run", run)
                    self._take(line, run, len(raw))
        except FileNotFoundError:
            pass
        except OSError as error:
            raise InvalidInput(
                f"Journal {str(self.path)!r} cannot be read ({error.strerror}): give another folder with --out."
            ) from None
        return end

    def _take(self, line: Mapping[str, Any], run: Mapping[str, Any], size: int) -> None:
        contents = self.contents
        is_present = self._context is None or run["context"] == self._context
        if "run" in line:
            contents.history.append(run["provenance"]["history"])
        elif "score" in line:
            contents.score = line["score"]
        elif "kind" in line:
            self._types.add(line["kind"])
        elif "begin" in line:
            contents.begun = line["begin"]
        elif "case" in line:
            key = line["case"]
            contents.begun = None if contents.begun == key else contents.begun
            record = Record(
                CaseIdentity(key, line["tree"], line["point"]),
                self._outcome(line),
                run["context"],
                size,
            )
            contents.keep(record, is_present=is_present)
        elif "time" in line and is_present and run["machine"] == self._machine:
            contents.samples.setdefault(line["time"], []).append(Sample(**line["sample"]))
        elif "retime" in line:
            contents.samples.clear()

    def _outcome(self, line: Mapping[str, Any]) -> Outcome:
        failure = Failure(**line["failure"]) if "failure" in line else None
        case_status = CaseStatus[line["status"].upper()]
        variables: Mapping[str, xr.Variable] = self._types.decode(line["values"])
        return Outcome(case_status, variables, failure, line["seconds"], {}, line["cpu"])

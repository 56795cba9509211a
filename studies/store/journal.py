"""What a study found, line by line as it was found: nothing that stands in it is ever changed."""

import os
import weakref
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import cached_property
from itertools import chain, count
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any, Self

import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.files import open_descriptor, read_at, reason, replacing
from studies.model.outcome import CaseStatus, Failure, Outcome, Sample
from studies.store.identity import Tree, differences, text
from studies.store.journal_lines import (
    FIRST_FORMAT,
    START,
    VariableTypes,
    decoded,
    encoded,
    short_hash,
)

# A case that took longer is on disk at once, shorter ones together: a write to disk takes 0.3 ms.
TOGETHER = 0.05
FORMAT = 2


@dataclass(frozen=True, eq=False)
class CaseIdentity:
    """A case by its ``key``, as a ``tree``, with the first ``point`` that asks for it."""

    key: str
    tree: Tree
    point: Mapping[str, str]

    @cached_property
    def tree_hash(self) -> int:
        """A hash of the whole tree, defaults included, in this process."""
        return hash(text(self.tree))


@dataclass(frozen=True, eq=False, slots=True)
class Record:
    """What is stored of a case, in ``size`` bytes at ``start`` of the journal; read from there when it is used."""

    key: str
    case_status: CaseStatus
    seconds: float
    cpu: float
    context: Mapping[str, str]
    tree_hash: int
    start: int
    size: int
    source: "_Source"

    @property
    def identity(self) -> CaseIdentity:
        """The case."""
        line = self.source.line(self)
        return CaseIdentity(self.key, line["tree"], line["point"])

    @property
    def outcome(self) -> Outcome:
        """Its outcome."""
        line = self.source.line(self)
        failure = Failure(**line["failure"]) if "failure" in line else None
        variables = self.source.kinds.decode(line["values"])
        return Outcome(self.case_status, variables, failure, self.seconds, {}, self.cpu)

    @property
    def error(self) -> str:
        """The failure in a sentence, or nothing."""
        return str(self.source.line(self).get("failure", {}).get("sentence", ""))

    def variable(self, name: str) -> xr.Variable | None:
        """What was measured under this name, if there is something."""
        values = self.source.line(self)["values"]
        return self.source.kinds.decode({name: values[name]})[name] if name in values else None

    def is_of(self, identity: CaseIdentity) -> bool:
        """Whether it is of this very case, the values that are at their defaults included."""
        return self.tree_hash == identity.tree_hash or not differences(
            self.identity.tree, identity.tree
        )


@dataclass(eq=False)
class _Source:
    """Where records are read from."""

    descriptor: int
    kinds: VariableTypes

    def line(self, record: Record) -> dict[str, Any]:
        parts, start, lacking = [], record.start, record.size
        while lacking and (part := read_at(self.descriptor, lacking, start)):
            parts.append(part)
            start, lacking = start + len(part), lacking - len(part)
        line = decoded(b"".join(parts))
        if line is None:
            raise InvalidInput(
                "The journal was changed by another program while it was read: run the same command again."
            )
        return line


@dataclass(eq=False)
class Contents:
    """What a journal says: records of the present ``context``, others, and timings of this machine.

    ``axes``: the values that each axis ever had in this context. ``untimed``: why cases have no times.
    """

    records: dict[str, Record] = field(default_factory=dict)
    others: dict[str, Record] = field(default_factory=dict)
    samples: dict[str, list[Sample]] = field(default_factory=dict)
    untimed: dict[str, str] = field(default_factory=dict)
    axes: dict[str, dict[Any, None]] = field(default_factory=dict)
    begun: str | None = None
    history: list[str] = field(default_factory=list)
    score: Mapping[str, float] = field(default_factory=dict)
    epoch: int = 0

    def changed(self, identity: CaseIdentity) -> list[str]:
        """How the case last stored for ``identity``, or at its point, differs from it, if there is one."""
        before = self.records.get(identity.key) or self.others.get(identity.key)
        tree = before.identity.tree if before else self._at().get(_place(identity.point))
        return [] if tree is None else differences(tree, identity.tree)

    def _at(self) -> Mapping[object, Tree]:
        """What was stored at each point; read at the first question."""
        if self._trees is None:
            identity = [
                record.identity for record in (*self.others.values(), *self.records.values())
            ]
            self._trees = {_place(one.point): one.tree for one in identity}
        return self._trees

    _trees: Mapping[object, Tree] | None = None


def _place(point: Mapping[str, str]) -> object:
    return tuple(sorted(point.items()))


class Journal:
    """The journal at ``path``, read, and in a ``with`` statement open to be written on.

    Every line starts with a checksum of the rest. A line that fails it goes to ``<path>.damaged`` when the
    journal is opened for writing, and what it held counts as not stored; a torn last line is cut off. Lines are ``run``
    (versions, machine, time), ``kind`` (see :class:`~studies.store.journal_lines.VariableTypes`), ``axis``, ``begin``,
    ``case``, ``time``, ``untimed``, ``retime`` and ``score``. Each names what it refers to, so that
    none depends on its place; ``run``, ``kind`` and ``axis``, which many lines need, are written twice.
    Records of another ``context``, and times of another ``machine``, are kept apart; without a context all
    count, and nothing can be written. Only one process at a time may write.
    """

    def __init__(self, path: Path, context: Mapping[str, str] | None, machine: str) -> None:
        self.path = path
        self.notes: list[str] = []
        self._context, self._machine = context, machine
        self._synced = monotonic()
        self._run = ""
        self._second_copies: list[bytes] = []
        self._close: Callable[[], object] = lambda: None
        self._read()

    def __enter__(self) -> Self:
        try:
            if self._is_first_format:
                self._set_first_format_aside()
            elif self._damaged:
                self._set_aside()
            self._keep_open(open_descriptor(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND))
            os.ftruncate(self._descriptor, self._end)
            if self._lacks_line_feed:
                self._write_bytes(b"\n")
        except OSError as error:
            raise self._refused(error) from None
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if kind is None or not issubclass(kind, InvalidInput):
                self._write_second_copies()
                self.sync()
        finally:
            self._close()

    def start(self, provenance: Mapping[str, str], axes: Mapping[str, Iterable[Any]]) -> None:
        """A run begins, in the present context, over these values of its axes."""
        run = {"format": FORMAT, "context": dict(self._present), "machine": self._machine}
        self._run = short_hash(run)
        self._write({"run": self._run} | run | {"provenance": dict(provenance)}, copies=2)
        self.contents.history.append(provenance["history"])
        for name, values in axes.items():
            known = self.contents.axes.setdefault(name, {})
            new = [value for value in values if value not in known]
            known.update(dict.fromkeys(new))
            if new:
                self._write({"axis": name, "values": new, "of": self._run}, copies=2)
        self.sync()

    @property
    def _present(self) -> Mapping[str, str]:
        assert self._context is not None, (
            "a journal that is read whatever its context is not written"
        )
        return self._context

    def score(self, found: Mapping[str, float]) -> None:
        """Write down how far off the forecast was."""
        self._write({"score": dict(found), "of": self._run})
        self.contents.score = found

    def begin(self, key: str) -> None:
        """This process itself begins a case: should it die, the next will know in which."""
        self._write({"begin": key})

    def add(self, identity: CaseIdentity, outcome: Outcome) -> bool:
        """Write down a case; returns whether all cases so far are on disk."""
        new, variables = self._kinds.encode(outcome.variables)
        for name, kind in new.items():
            self._write({"kind": name, "is": kind}, copies=2)
        line: dict[str, Any] = {
            "case": identity.key,
            "of": self._run,
            "status": outcome.case_status.name.lower(),
            "point": dict(identity.point),
            "tree": identity.tree,
            "seconds": outcome.seconds,
            "cpu": outcome.cpu,
            "values": variables,
        }
        if outcome.failure is not None:
            line["failure"] = asdict(outcome.failure)
        start = self._end
        size = self._write(line)
        self._write_second_copies()
        self.contents.records[identity.key] = self._record(line, self._present, start, size)
        if outcome.seconds > TOGETHER / 2 or monotonic() - self._synced > TOGETHER:
            self.sync()
            return True
        return False

    def time(self, key: str, sample: Sample) -> None:
        """Write down a timed run."""
        line = {"time": key, "of": self._run, "epoch": self.contents.epoch}
        self._write(line | {"sample": asdict(sample)})
        self.contents.samples.setdefault(key, []).append(sample)
        if monotonic() - self._synced > TOGETHER:
            self.sync()

    def cannot_time(self, key: str, reason: str) -> None:
        """Write down that a case has no times, and why: the next run does not try it again."""
        self._write(
            {"untimed": key, "of": self._run, "epoch": self.contents.epoch, "reason": reason}
        )
        self.contents.untimed[key] = reason

    def forget_times(self) -> None:
        """Let the samples of all runs before this count no more."""
        self.contents.epoch += 1
        self._write({"retime": self.contents.epoch})
        self.contents.samples.clear()
        self.contents.untimed.clear()

    def sync(self) -> None:
        """Have everything on disk, in the file that bears the journal's name.

        Raises :class:`~contactstudy.InvalidInput` where the disk is full, or the file has been removed.
        """
        try:
            os.fsync(self._descriptor)
        except OSError as error:
            raise self._refused(error) from None
        try:
            there, ours = self.path.lstat(), os.fstat(self._descriptor)
            is_same = (there.st_ino, there.st_dev) == (ours.st_ino, ours.st_dev)
        except OSError:
            is_same = False
        if not is_same:
            raise InvalidInput(
                f"Journal {str(self.path)!r} was removed or replaced while the run was writing it, and what it "
                "held is lost: run the same command again."
            )
        self._synced = monotonic()

    def _write(self, line: Mapping[str, Any], copies: int = 1) -> int:
        raw = encoded(line)
        self._write_bytes(raw)
        if copies > 1:
            self._second_copies.append(raw)
        return len(raw)

    def _write_second_copies(self) -> None:
        """Apart from the first, so that one hole in the file does not take both."""
        while self._second_copies:
            self._write_bytes(self._second_copies[0])
            del self._second_copies[0]

    def _write_bytes(self, raw: bytes) -> None:
        try:
            rest = memoryview(raw)
            while rest:
                rest = rest[os.write(self._descriptor, rest) :]
        except OSError as error:
            with suppress(OSError):
                os.ftruncate(self._descriptor, self._end)
            raise self._refused(error) from None
        self._end += len(raw)

    def _refused(self, error: OSError) -> InvalidInput:
        return InvalidInput(
            f"Journal {str(self.path)!r} cannot be written ({reason(error)}): what was stored is kept; "
            "make room or give another folder with --out, and run the same command again."
        )

    def _keep_open(self, descriptor: int) -> None:
        self._close()
        self._descriptor = self._source.descriptor = descriptor
        # records are read from it for as long as there are some
        self._close = weakref.finalize(self._source, os.close, descriptor)

    def _read(self) -> None:
        """Read what there is."""
        self._close()
        self.contents, self._kinds = Contents(), VariableTypes()
        self._source = _Source(-1, self._kinds)
        self._descriptor, self._end = -1, 0
        self._damaged: list[tuple[int, int]] = []
        self._is_first_format = self._lacks_line_feed = False
        try:
            self._keep_open(open_descriptor(self.path, os.O_RDONLY))
            with open(self._descriptor, "rb", closefd=False) as file:
                self._take_all(file)
        except FileNotFoundError:
            pass
        except OSError as error:
            raise InvalidInput(
                f"Journal {str(self.path)!r} cannot be read ({reason(error)}): give another folder with --out."
            ) from None

    def _take_all(self, file: Iterable[bytes]) -> None:
        at, first, has_line = 0, b"", False
        seen: set[bytes] = set()
        runs: dict[str, Any] = {}
        unsure: list[str] = []
        for raw in file:
            first = first or raw
            line = decoded(raw)
            if line is None and not raw.endswith(b"\n"):
                break  # torn
            if line is None:
                self._damaged.append((at, len(raw)))
            elif "run" not in line or raw not in seen:  # its second copy is not another run
                has_line = True
                seen |= {raw} if "run" in line else set()
                self._take(line, runs, at, len(raw), unsure)
            self._lacks_line_feed = not raw.endswith(b"\n")
            at += len(raw)
        self._end = at
        for key in unsure:  # their kinds may have come after them
            for held in (self.contents.records, self.contents.others):
                if key in held and not self._kinds.knows(self._source.line(held[key])["values"]):
                    del held[key]
        if has_line or not first:
            return
        if first.startswith(FIRST_FORMAT) and first.endswith(b"\n"):
            self._is_first_format = True
        elif not (first.startswith(START) or START.startswith(first)):
            raise InvalidInput(
                f"Journal {str(self.path)!r} is not a journal of this program: move the file away, or give "
                "another folder with --out."
            )

    def _take(
        self,
        line: Mapping[str, Any],
        runs: dict[str, Any],
        start: int,
        size: int,
        unsure: list[str],
    ) -> None:
        contents = self.contents
        if "run" in line:
            runs[line["run"]] = line
            contents.history.append(line["provenance"]["history"])
            return
        if "kind" in line:
            self._kinds.add(line["kind"], line["is"])
            return
        if "begin" in line:
            contents.begun = line["begin"]
            return
        if "retime" in line:
            self._turn_epoch(line["retime"])
            return
        run = runs.get(line.get("of", ""))
        if run is None:  # nobody can say which versions it is of
            self._damaged.append((start, size))
            return
        is_present = self._context is None or run["context"] == self._context
        is_here = is_present and run["machine"] == self._machine
        if "case" in line:
            key = line["case"]
            contents.begun = None if contents.begun == key else contents.begun
            record = self._record(line, run["context"], start, size)
            (contents.records if is_present else contents.others)[key] = record
            if not self._kinds.knows(line["values"]):
                unsure.append(key)
        elif "axis" in line and is_present:
            contents.axes.setdefault(line["axis"], {}).update(dict.fromkeys(line["values"]))
        elif "score" in line and is_present:
            contents.score = line["score"]
        elif "epoch" in line:
            self._turn_epoch(line["epoch"])
            if line["epoch"] == contents.epoch and is_here and "time" in line:
                contents.samples.setdefault(line["time"], []).append(Sample(**line["sample"]))
            elif line["epoch"] == contents.epoch and is_here:
                contents.untimed[line["untimed"]] = line["reason"]

    def _turn_epoch(self, epoch: int) -> None:
        if epoch > self.contents.epoch:
            self.contents.epoch = epoch
            self.contents.samples.clear()
            self.contents.untimed.clear()

    def _record(
        self, line: Mapping[str, Any], context: Mapping[str, str], start: int, size: int
    ) -> Record:
        return Record(
            line["case"],
            CaseStatus[line["status"].upper()],
            line["seconds"],
            line["cpu"],
            context,
            hash(text(line["tree"])),
            start,
            size,
            self._source,
        )

    def _set_aside(self) -> None:
        """Move damaged lines to a file of their own, and let the journal be what remains."""
        damaged = self.path.with_name(f"{self.path.name}.damaged")
        aside = open_descriptor(damaged, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        with (
            open(aside, "ab") as file,  # noqa: PTH123 (a descriptor)
            replacing(self.path) as partial,
            partial.open("xb") as mended,
        ):
            at = 0
            for start, size in (*sorted(self._damaged), (self._end, 0)):
                mended.write(read_at(self._descriptor, start - at, at))
                file.write(read_at(self._descriptor, size, start))
                at = start + size
            file.flush()
            os.fsync(file.fileno())
            self._close()  # Windows replaces no open file
        lines = len(self._damaged)
        self._read()
        self.notes.append(
            f"{lines} damaged lines of the journal are set aside in {damaged}; what they held is computed anew"
        )

    def _set_first_format_aside(self) -> None:
        names = (f"{self.path.name}.format1{end}" for end in chain([""], map(str, count(2))))
        old = next(path for path in map(self.path.with_name, names) if not path.exists())
        self._close()
        self.path.rename(old)
        self._read()
        self.notes.append(
            f"the journal is of an older format without checksums; it is set aside as {old}, and its cases are "
            "computed anew"
        )

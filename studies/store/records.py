"""Contents of a journal: cases by their keys, timed runs, values of axes; each line is checked before it counts."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.files import read_at
from contactstudy.domain.identity import Tree, differences, text
from studies.model.outcome import CaseStatus, Failure, Outcome, Sample
from studies.model.plain_text import is_storable, name_problem
from studies.store.fingerprint import agree
from studies.store.journal_lines import decoded, decoded_values, decoded_variable

FORMAT = 3
# errors that a line may raise which this version does not write
ODD = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError)


@dataclass(frozen=True, eq=False)
class CaseIdentity:
    """A case: its key, its parameters as a tree, and the first point that asks for it."""

    key: str
    tree: Tree
    point: Mapping[str, str]

    @cached_property
    def tree_hash(self) -> int:
        """Hash of the whole tree, defaults included, in this process."""
        return hash(text(self.tree))


@dataclass(frozen=True, eq=False, slots=True)
class Record:
    """A stored case: its status, and its place in the journal, from which its values are read on use.

    Attributes
    ----------
    key
        Key of the case.
    case_status
        Status of the case.
    seconds, cpu
        Wall and CPU time [s].
    context
        Versions and hashes of the code that computed it.
    tree_hash
        Hash of its parameters.
    start, size
        Place of its line in the journal [bytes].
    source
        The open journal.
    """

    key: str
    case_status: CaseStatus
    seconds: float
    cpu: float
    context: Mapping[str, str]
    tree_hash: int
    start: int
    size: int
    source: "RecordFile"

    @property
    def identity(self) -> CaseIdentity:
        """Key, parameters and first point of the case."""
        line = self.source.line(self)
        return CaseIdentity(self.key, line["tree"], line["point"])

    @property
    def outcome(self) -> Outcome:
        """Outcome of the case."""
        line = self.source.line(self)
        failure = Failure(**line["failure"]) if "failure" in line else None
        variables = {name: decoded_variable(entry) for name, entry in line["values"].items()}
        return Outcome(self.case_status, variables, failure, self.seconds, {}, self.cpu)

    @property
    def error(self) -> str:
        """Sentence on the failure; empty without one."""
        return str(self.source.line(self).get("failure", {}).get("sentence", ""))

    def variable(self, name: str) -> xr.Variable | None:
        """Return the measured variable with the name `name`; None if there is none."""
        values = self.source.line(self)["values"]
        return decoded_variable(values[name]) if name in values else None

    def is_of(self, identity: CaseIdentity) -> bool:
        """Return whether this record is of exactly this case, its defaults included."""
        return self.tree_hash == identity.tree_hash or not differences(
            self.identity.tree, identity.tree
        )


@dataclass(eq=False)
class RecordFile:
    """The open file that records are read from."""

    descriptor: int

    def line(self, record: Record) -> dict[str, Any]:
        """Return the line of a record from the file."""
        parts, start, remaining = [], record.start, record.size
        while remaining and (part := read_at(self.descriptor, remaining, start)):
            parts.append(part)
            start, remaining = start + len(part), remaining - len(part)
        line = decoded(b"".join(parts))
        if line is None:
            raise InvalidInput(
                "The journal was changed by another program while it was read: run the same command again."
            )
        return line


@dataclass(eq=False)
class Contents:
    """Contents of a journal.

    Attributes
    ----------
    context
        Versions and hashes of the present code; None takes records of every context as present.
    machine
        Name of the machine whose timed runs count.
    source
        The open journal.
    records
        Records of the present context by key.
    other_records
        Records of other contexts by key.
    samples
        Timed runs of each case on this machine.
    untimed
        Reasons why cases have no times.
    axes
        Values that each axis ever had in this context.
    begun
        Key of the case during which the last run ended; None if it ended otherwise.
    history
        Time and command of each run.
    score
        Accuracy of the last forecast.
    epoch
        Number of times that timed runs were made invalid.
    """

    context: Mapping[str, str] | None
    machine: str
    source: RecordFile
    records: dict[str, Record] = field(default_factory=dict)
    other_records: dict[str, Record] = field(default_factory=dict)
    samples: dict[str, list[Sample]] = field(default_factory=dict)
    untimed: dict[str, str] = field(default_factory=dict)
    axes: dict[str, dict[Any, None]] = field(default_factory=dict)
    begun: str | None = None
    history: list[str] = field(default_factory=list)
    score: Mapping[str, float] = field(default_factory=dict)
    epoch: int = 0
    # the versions and machine of each run, and whether they are the present ones
    _runs: dict[str, tuple[Mapping[str, Any], bool]] = field(default_factory=dict)

    def take(self, line: Mapping[str, Any], start: int, size: int) -> None:
        """Take in a line of `size` bytes at `start`.

        Raises
        ------
        InvalidInput
            For a run of another format.
        Exception
            One of ``ODD`` for a line that this version does not write.
        """
        if "run" in line:
            self._take_run(line)
        elif "begin" in line:
            self.begun = _text(line["begin"])
        elif "retime" in line:
            self._turn_epoch(line["retime"])
        else:
            self._take_of_run(line, *self._runs[line["of"]], start, size)

    def _take_run(self, line: Mapping[str, Any]) -> None:
        """Take in the versions and the machine that later lines refer to."""
        if line["format"] != FORMAT:
            raise InvalidInput(
                f"it is of format {line['format']!r}, and this version reads format {FORMAT}"
            )
        for name, value in line["context"].items():
            _text(name), _text(value)
        _text(line["machine"])
        if line["run"] not in self._runs or line["provenance"]["history"] != self.history[-1]:
            self.history.append(_text(line["provenance"]["history"]))
        is_present = self.context is None or agree(line["context"], self.context)
        self._runs[line["run"]] = line, is_present

    def _take_of_run(
        self,
        line: Mapping[str, Any],
        run: Mapping[str, Any],
        is_present: bool,  # noqa: FBT001
        start: int,
        size: int,
    ) -> None:
        """Take in a line that refers to a run."""
        is_here = is_present and run["machine"] == self.machine
        if "case" in line:
            record = self.record(line, run["context"], start, size)
            self.begun = None if self.begun == record.key else self.begun
            (self.records if is_present else self.other_records)[record.key] = record
        elif "axis" in line:
            values = dict.fromkeys(line["values"])
            if not all(type(value) in (str, int, float) for value in values):
                raise TypeError(values)
            if is_present:
                self.axes.setdefault(_text(line["axis"]), {}).update(values)
        elif "score" in line:
            score = {_name(name): _number(value) for name, value in line["score"].items()}
            self.score = score if is_present else self.score
        elif "time" in line:
            sample = Sample(**{name: _number(value) for name, value in line["sample"].items()})  # type: ignore[arg-type]
            if self._turn_epoch(line["epoch"]) and is_here:
                self.samples.setdefault(_text(line["time"]), []).append(sample)
        else:
            key, reason = _text(line["untimed"]), _text(line["reason"])
            if self._turn_epoch(line["epoch"]) and is_here:
                self.untimed[key] = reason

    def record(
        self, line: Mapping[str, Any], context: Mapping[str, str], start: int, size: int
    ) -> Record:
        """Return the record of a case; raise one of ``ODD`` for a line that this version does not write."""
        if "failure" in line:
            failure = Failure(**line["failure"])
            for part in (failure.kind, failure.sentence, failure.stage):
                _text(part)
        for name, entry in line["values"].items():
            _name(name)
            values = decoded_values(entry)
            if values.dtype.kind == "f" and np.isnan(values).any():
                raise ValueError(name)
        for name, value in line["point"].items():
            _text(name), _text(value)
        return Record(
            _text(line["case"]),
            CaseStatus[line["status"].upper()],
            _number(line["seconds"]),
            _number(line["cpu"]),
            context,
            hash(text(line["tree"])),
            start,
            size,
            self.source,
        )

    def _turn_epoch(self, epoch: object) -> bool:
        """Forget timed runs of earlier epochs, and return whether `epoch` is the present one."""
        if type(epoch) is not int:
            raise TypeError(epoch)
        if epoch > self.epoch:
            self.epoch = epoch
            self.samples.clear()
            self.untimed.clear()
        return epoch == self.epoch

    def changed(self, identity: CaseIdentity) -> list[str]:
        """Return sentences on how the case stored for `identity`, or at its point, differs from it."""
        before = self.records.get(identity.key) or self.other_records.get(identity.key)
        tree = before.identity.tree if before else self._trees.get(_place(identity.point))
        return [] if tree is None else differences(tree, identity.tree)

    @cached_property
    def _trees(self) -> Mapping[object, Tree]:
        """Parameters stored at each point, when this is first asked."""
        records = (*self.other_records.values(), *self.records.values())
        identities = (record.identity for record in records)
        return {_place(identity.point): identity.tree for identity in identities}


def _place(point: Mapping[str, str]) -> object:
    """Return a point as a key that does not depend on the order of its axes."""
    return tuple(sorted(point.items()))


def _text(value: object) -> str:
    """Return `value`; raise TypeError unless it is text that can be stored."""
    if not isinstance(value, str) or not is_storable(value):
        raise TypeError(value)
    return value


def _name(value: object) -> str:
    """Return `value`; raise ValueError unless it is the name of a variable."""
    if name_problem(value) or str(value).startswith("_"):
        raise ValueError(value)
    return str(value)


def _number(value: object) -> float:
    """Return `value`; raise TypeError unless it is a finite number."""
    if type(value) not in (int, float) or not math.isfinite(value):  # type: ignore[arg-type]
        raise TypeError(value)
    return value  # type: ignore[return-value]

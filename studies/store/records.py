"""Contents of a journal: cases by their keys, timed runs, values of axes; each line is checked before it counts."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import xarray as xr

from contactstudy.domain.identity import Tree, differences
from studies.model.outcome import CaseStatus, Failure, Outcome, Sample
from studies.store.journal_lines import decoded_variable
from studies.store.loaded import Present, shown

FORMAT = 5
# errors that a line may raise which no version has written
MALFORMED_RECORD = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError)


@dataclass(frozen=True, eq=False)
class CaseIdentity:
    """A case: its key, its parameters as a tree, the state of its classes, and the first point that requests it.

    The key leaves out the fields at their defaults, `exact` does not.
    """

    key: str
    exact: str
    tree: Tree
    point: Mapping[str, str]
    state: str = ""


@dataclass(frozen=True, eq=False)
class Program:
    """Program that computed a case.

    Attributes
    ----------
    part
        Digests of the study's measures, of the part of its file that makes numbers, and of the files it depends on.
    state
        State of the classes of the case.
    loaded
        What its process had loaded.
    """

    part: Mapping[str, str]
    state: str
    loaded: Mapping[str, str]


@dataclass(frozen=True, eq=False)
class Context:
    """Part of a study, and what a process would load now: what a stored case is compared with."""

    part: Mapping[str, str]
    present: Present = field(default_factory=Present)

    def changes(self, program: Program) -> list[str]:
        """Return the names of all that another program computed a case with."""
        names = program.part.keys() | self.part.keys()
        differing = [
            name for name in sorted(names) if program.part.get(name) != self.part.get(name)
        ]
        return differing + self.present.changes(program.loaded)


@dataclass(eq=False, slots=True)
class Record:
    """A stored case: its status, and its line in the journal, from which its values are read on use.

    Attributes
    ----------
    key
        Key of the case.
    case_status
        Status of the case.
    seconds
        Wall time [s].
    stamp
        Digest of the program that computed it.
    state
        State of its classes.
    exact
        Hash of its parameters, defaults included.
    error
        Sentence on the failure; empty without one.
    status
        Encoded variable ``solver_status``; None without one.
    raw
        Its line, as bytes.
    """

    key: str
    case_status: CaseStatus
    seconds: float
    stamp: str
    state: str
    exact: str
    error: str
    status: Any
    raw: bytes

    @property
    def _line(self) -> dict[str, Any]:
        """The line of the case."""
        return json.loads(self.raw)  # type: ignore[no-any-return]

    @property
    def identity(self) -> CaseIdentity:
        """Key, parameters and first point of the case."""
        line = self._line
        return CaseIdentity(self.key, self.exact, line["tree"], line["point"], self.state)

    @property
    def outcome(self) -> Outcome:
        """Outcome of the case."""
        line = self._line
        failure = Failure(**line["failure"]) if "failure" in line else None
        variables = {name: decoded_variable(entry) for name, entry in line["values"].items()}
        return Outcome(self.case_status, variables, failure, self.seconds, {}, line["cpu"])

    def variable(self, name: str) -> xr.Variable | None:
        """Return the measured variable with the name `name`; None if there is none."""
        if name == "solver_status":
            return None if self.status is None else decoded_variable(self.status)
        values = self._line["values"]
        return decoded_variable(values[name]) if name in values else None

    def is_of(self, identity: CaseIdentity) -> bool:
        """Return whether this record is of exactly this case, its defaults and the state of its classes included."""
        return self.state == identity.state and (
            self.exact == identity.exact or not differences(self.identity.tree, identity.tree)
        )


@dataclass(eq=False)
class Contents:
    """Contents of a journal.

    Attributes
    ----------
    context
        Part of the study and what would be loaded now.
    machine
        Name of the machine whose timed runs count.
    records
        Records of the present program by key.
    other_records
        Records of other programs by key.
    programs
        Programs by their stamps.
    samples
        Timed runs on this machine, by the key of the case and the stamp of its program.
    untimed
        Reasons why cases have no times, likewise.
    axes
        Values that each axis ever had with this part of the study.
    begun
        Key of the case during which the last run ended; None if it ended otherwise.
    history
        Time and command of each run.
    epoch
        Number of times that timed runs were made invalid.
    is_foreign
        True for a journal of another format.
    """

    context: Context
    machine: str
    records: dict[str, Record] = field(default_factory=dict)
    other_records: dict[str, Record] = field(default_factory=dict)
    programs: dict[str, Program] = field(default_factory=dict)
    samples: dict[tuple[str, str], list[Sample]] = field(default_factory=dict)
    untimed: dict[tuple[str, str], str] = field(default_factory=dict)
    axes: dict[str, dict[Any, None]] = field(default_factory=dict)
    begun: str | None = None
    history: list[str] = field(default_factory=list)
    epoch: int = 0
    is_foreign: bool = False
    _runs: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    _present: dict[str, bool] = field(default_factory=dict)

    def take(self, line: Mapping[str, Any], raw: bytes) -> None:
        """Take in a line, also as bytes; raise a ``MALFORMED_RECORD`` for one of no version."""
        match line:
            case {"case": key}:
                record = self.record(line, raw)
                self.begun = None if self.begun == key else self.begun
                present = self._present[record.stamp]
                (self.records if present else self.other_records)[key] = record
            case {"time": key, "program": stamp, "machine": machine}:
                if machine != self.machine:
                    return
                if "reason" in line:
                    self.untimed[key, stamp] = line["reason"]
                else:
                    self.samples.setdefault((key, stamp), []).append(Sample(**line["sample"]))
            case {"format": version}:
                self.is_foreign |= version != FORMAT
                self.history.append(line["history"])
                self._runs[line["run"]] = line
            case {"begin": key}:
                self.begun = key
            case {"retime": _}:
                self.forget_times()
            case {"loaded": loaded}:
                self.add_program(line["program"], Program(line["part"], line["state"], loaded))
            case {"axis": name, "values": values}:
                if self._runs[line["run"]]["part"] == self.context.part:
                    self.axes.setdefault(name, {}).update(dict.fromkeys(values))
            case _:
                raise ValueError(line)

    def forget_times(self) -> None:
        """Forget all timed runs so far."""
        self.epoch += 1
        self.samples.clear()
        self.untimed.clear()

    def add_program(self, stamp: str, program: Program, *, computes: bool = False) -> None:
        """Add a program; one that computes in this run counts as present."""
        self.programs[stamp] = program
        self._present[stamp] = computes or not self.context.changes(program)

    def record(self, line: Mapping[str, Any], raw: bytes) -> Record:
        """Return the record of a case from its line, read and raw; raise a ``MALFORMED_RECORD`` for any other line."""
        failure = Failure(**line["failure"]) if "failure" in line else None
        return Record(
            line["case"],
            CaseStatus[line["status"].upper()],
            line["seconds"],
            line["program"],
            self.programs[line["program"]].state,
            line["exact"],
            failure.sentence if failure else "",
            line["values"].get("solver_status"),
            raw,
        )

    def samples_of(self, key: str) -> list[Sample]:
        """Return the timed runs of the present record of a case."""
        record = self.records.get(key)
        return [] if record is None else self.samples.get((key, record.stamp), [])

    def reason_without_times(self, key: str) -> str:
        """Return why the present record of a case has no times; empty where it may have some."""
        record = self.records.get(key)
        return "" if record is None else self.untimed.get((key, record.stamp), "")

    def reason_to_recompute(self, identity: CaseIdentity) -> str:
        """Return in one line why the stored record of a case, or at its point, cannot be used; empty without one."""
        before = self.records.get(identity.key) or self.other_records.get(identity.key)
        tree = before.identity.tree if before else self._trees.get(_place(identity.point))
        changes = [] if tree is None else differences(tree, identity.tree)
        if before is not None:
            names = self.context.changes(self.programs[before.stamp])
            if before.state != identity.state:
                names = ["the state of the case's classes", *names]
            changes += [f"{shown(names)} changed"] if names else []
        return ", ".join(changes)

    @cached_property
    def _trees(self) -> Mapping[object, Tree]:
        """Parameters stored at each point, when this is first asked."""
        records = (*self.other_records.values(), *self.records.values())
        identities = (record.identity for record in records)
        return {_place(identity.point): identity.tree for identity in identities}


def _place(point: Mapping[str, str]) -> object:
    """Return a point as a key that does not depend on the order of its axes."""
    return tuple(sorted(point.items()))

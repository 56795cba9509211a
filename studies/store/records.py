"""What a journal holds: cases with the programs that computed them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from contactstudy.domain.identity import Tree, differences
from studies.model.outcome import CaseStatus, Failure, Outcome
from studies.store.journal_lines import decoded_variable
from studies.store.loaded import Present


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
        names = sorted(program.part.keys() | self.part.keys())
        differing = [name for name in names if program.part.get(name) != self.part.get(name)]
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
    exact
        Hash of its parameters, defaults included.
    stamp
        Digest of the program that computed it.
    state
        State of its classes.
    raw
        Its line, as bytes.
    """

    key: str
    case_status: CaseStatus
    seconds: float
    exact: str
    stamp: str
    state: str
    raw: bytes

    @property
    def identity(self) -> CaseIdentity:
        """Key, parameters and first point of the case."""
        line = json.loads(self.raw)
        return CaseIdentity(self.key, self.exact, line["tree"], line["point"], self.state)

    @property
    def outcome(self) -> Outcome:
        """Outcome of the case."""
        line = json.loads(self.raw)
        variables = {name: decoded_variable(entry) for name, entry in line["values"].items()}
        return Outcome(self.case_status, variables, failure_of(line), self.seconds, {}, line["cpu"])

    def is_of(self, identity: CaseIdentity) -> bool:
        """Return whether this record is of exactly this case, its defaults and the state of its classes included."""
        return self.state == identity.state and (
            self.exact == identity.exact or not differences(self.identity.tree, identity.tree)
        )


def failure_of(line: Mapping[str, Any]) -> Failure | None:
    """Return the failure in the line of a case; None without one."""
    return Failure(**line["failure"]) if "failure" in line else None

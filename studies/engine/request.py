"""What a study requests: its cases and their keys, and the program that computes them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from contactstudy import InvalidInput
from contactstudy.domain.files import Memo, digest
from studies.model.case import Computation
from studies.model.outcome import RESERVED_NAMES
from studies.model.plain_text import shortened
from studies.model.study import Point, Study
from studies.store.journal import without_garbage_collection
from studies.store.program import Program


@dataclass(frozen=True, eq=False)
class Request:
    """Cases that a study requests: the key at every point, each case and its first point by its key; the program."""

    keys: Sequence[str]
    cases: Mapping[str, Computation]
    points: Mapping[str, Point]
    program: Program

    @classmethod
    @without_garbage_collection()
    def of(cls, study: Study) -> "Request":
        """Return the request of a study; each distinct case is made once.

        Raises
        ------
        InvalidInput
            For an axis with a reserved name, a computation that lacks a method, and one whose state cannot be seen.
        """
        if reserved := RESERVED_NAMES & {axis.name for axis in study.axes}:
            raise InvalidInput(
                f"Study {study.name!r} has the axes {sorted(reserved)}: these names are taken, choose others."
            )
        memo: Memo = {}
        keys, cases, points = list[str](), dict[str, Computation](), dict[str, Point]()
        for point, case in study.visits():
            if not all(hasattr(case, part) for part in ("prepare", "run", "record")):
                raise InvalidInput(
                    f"case_at of study {study.name!r} gives {shortened(case)} at {dict(point)}: return a "
                    "studies.model.case.Case, or a frozen dataclass with prepare, run and record."
                )
            key = digest(case, memo)
            keys.append(key)
            cases.setdefault(key, case)
            points.setdefault(key, point)
        return cls(keys, cases, points, Program.of(study, next(iter(cases.values())), memo))

    def first(self) -> dict[str, Any]:
        """Return the first point, the key of its case, and the program, for JSON."""
        key = self.keys[0]
        return {"point": dict(self.points[key]), "case": key, "program": self.program.key}

    def differs(self, study: Study, first: Mapping[str, Any]) -> bool:
        """Return whether the case at the `first` point of an earlier run, if it still is a point, is another now."""
        number = 0
        try:
            for axis in study.axes:
                number = number * len(axis.values) + axis.values.index(first["point"][axis.name])
        except (ValueError, KeyError):
            return False
        return bool(self.keys[number] != first.get("case", self.keys[number]))

"""What a study requests: its cases and their keys, and the program that computes them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from contactstudy import InvalidInput
from contactstudy.domain.identity import Memo, digest
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
        """Return the first point, and the program and the fields of the case there, for JSON."""
        key = self.keys[0]
        described = dict(_described("", self.cases[key]))
        point = dict(self.points[key])
        return {"point": point, "program": self.program.key, "fields": described}

    def changes(self, study: Study, first: Mapping[str, Any]) -> str:
        """Return in words which fields of the case at the `first` point of an earlier run have other values now."""
        point, size = first["point"], 0
        try:
            for axis in study.axes:
                size = size * len(axis.values) + axis.values.index(point[axis.name])
        except (ValueError, KeyError):  # it is not one of the points
            return ""
        before, now = first["fields"], dict(_described("", self.cases[self.keys[size]]))
        names = [name for name in {**now, **before} if now.get(name) != before.get(name)]
        if not names:
            return ""
        old, new = (of.get(names[0], "absent") for of in (before, now))
        more = f", and {len(names) - 1} more fields changed" if len(names) > 1 else ""
        return f"{names[0]} was {old} and is {new}{more}"


def _described(name: str, value: Any) -> Iterator[tuple[str, str]]:
    """Yield every field of a case with its value as text, by its path."""
    if is_dataclass(value) and not isinstance(value, type):
        yield name or "case", type(value).__name__
        for part in fields(value):
            if part.compare:
                path = f"{name}.{part.name}".lstrip(".")
                yield from _described(path, getattr(value, part.name))
    elif isinstance(value, tuple | list):
        for number, item in enumerate(value):
            yield from _described(f"{name}[{number}]", item)
    else:
        yield name, shortened(value) if isinstance(value, str | int | float) else digest(value)

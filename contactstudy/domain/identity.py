"""Canonical representation of a computation as plain data: equal for equal computations, different for others."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from enum import Enum
from functools import cache
from pathlib import PurePath
from typing import Any

import numpy as np

from contactstudy.domain.checks import InvalidInput

Tree = Any  # what JSON can hold

# Fields at their default are stored under this name and do not enter the key, so that a new parameter
# at its default does not change the identity of a computation.
DEFAULTS = "="


@dataclass(eq=False)
class IdentityRecord:
    """Record of the cases of one request: dataclasses that they share, and classes by their names."""

    records: dict[int, tuple[object, Tree]] = field(default_factory=dict)
    kinds: dict[str, type] = field(default_factory=dict)

    def name(self, kind: type) -> str:
        """Return the module and qualified name of a class, which identify it.

        Raises :class:`~contactstudy.InvalidInput` if another class has the same name.
        """
        name = f"{kind.__module__}.{kind.__qualname__}"
        if self.kinds.setdefault(name, kind) is not kind:
            raise InvalidInput(f"Two classes are called {name!r}: give each a name of its own.")
        return name


def canonical(value: object, memory: IdentityRecord | None = None) -> Tree:
    """Return ``value`` as a tree that is unique to it: exact numbers with their types, dataclasses by their fields.

    Numbers have all their digits and text is in quotes: 1, 1.0, True, "1" and numpy's 1 differ, as do 0.0 and -0.0.
    Fields that a dataclass does not compare are left out. Raises :class:`~contactstudy.InvalidInput` for an object that
    is identified only by its address.
    """
    memory = memory or IdentityRecord()
    if is_dataclass(value) and not isinstance(value, type):
        if id(value) not in memory.records:
            memory.records[id(value)] = value, _record(value, memory)
        return memory.records[id(value)][1]
    if value is None or type(value) is bool:
        return value
    if type(value) in (str, int, float, complex):
        return repr(value)
    match value:
        case Enum():
            return {"": memory.name(type(value)), "name": value.name}
        case np.ndarray() if not value.dtype.hasobject:
            digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
            return {"": "array", "dtype": value.dtype.str, "shape": list(value.shape), "is": digest}
        case np.generic() if not value.dtype.hasobject:
            return {"": f"numpy {value.dtype.str}", "is": repr(value.item())}
        case tuple() if type(value) is tuple:
            return [canonical(item, memory) for item in value]
        case tuple() | list():
            items = [canonical(item, memory) for item in value]
        case frozenset() | set():
            items = sorted((canonical(item, memory) for item in value), key=text)
        case Mapping():
            pairs = ([canonical(k, memory), canonical(v, memory)] for k, v in value.items())
            items = sorted(pairs, key=text)
        case bytes() | PurePath() | str() | int() | float() | complex():
            items = [repr(value)]
        case _:
            raise InvalidInput(
                f"A case holds {value!r}, which cannot be told from another of its kind: make its class a "
                "frozen dataclass."
            )
    return {"": memory.name(type(value)), "is": items}


def _record(value: Any, memory: IdentityRecord) -> Tree:
    """Return the tree of a dataclass, with the fields at their defaults under ``DEFAULTS``."""
    tree: dict[str, Tree] = {"": memory.name(type(value))}
    defaults: dict[str, Tree] = {}
    for part, default in _parts(type(value)):  # type: ignore[arg-type]
        content = canonical(getattr(value, part), memory)
        (defaults if content == default else tree)[part] = content
    return tree | {DEFAULTS: defaults} if defaults else tree


@cache
def _parts(kind: type) -> tuple[tuple[str, Tree], ...]:
    """Return the names of the fields that a dataclass compares, with the trees of their defaults."""
    parts = []
    for part in fields(kind):
        default: Tree = MISSING
        if part.default is not MISSING:
            default = canonical(part.default)
        elif part.default_factory is not MISSING:
            default = canonical(part.default_factory())
        if part.compare:
            parts.append((part.name, default))
    return tuple(parts)


def text(tree: Tree) -> str:
    """Return ``tree`` as JSON with sorted keys."""
    return json.dumps(tree, sort_keys=True, separators=(",", ":"))


def key(tree: Tree) -> str:
    """Return the key of a computation in the journal: a hash of ``tree`` without the fields at their defaults."""
    return hashlib.sha256(text(_bare(tree)).encode()).hexdigest()[:24]


def _bare(tree: Tree) -> Tree:
    """Return `tree` without the fields at their defaults."""
    if isinstance(tree, dict):
        return {name: _bare(item) for name, item in tree.items() if name != DEFAULTS}
    return [_bare(item) for item in tree] if isinstance(tree, list) else tree


def differences(stored: Tree, now: Tree, name: str = "case") -> list[str]:
    """Return a sentence for each difference of two trees; a field that only one has, at its default, does not count."""
    if not (isinstance(stored, dict) and isinstance(now, dict)):
        if isinstance(stored, list) and isinstance(now, list) and len(stored) == len(now):
            pairs = enumerate(zip(stored, now, strict=True))
            return [d for i, (a, b) in pairs for d in differences(a, b, f"{name}[{i}]")]
        return [] if stored == now else [f"{name} was {_short(stored)} and is {_short(now)}"]
    if stored.get("") != now.get(""):
        return [f"{name} was {_short(stored)} and is {_short(now)}"]
    before, after = _fields(stored), _fields(now)
    changes = []
    for part in before.keys() | after.keys():
        if part in before and part in after:
            changes += differences(before[part], after[part], f"{name}.{part}")
        elif part in stored or part in now:
            changes.append(f"{name}.{part} is {'gone' if part in before else 'new'}")
    return sorted(changes)


def _fields(tree: dict[str, Tree]) -> dict[str, Tree]:
    """Return the fields of a dataclass in a tree, including fields at their defaults."""
    parts = {name: item for name, item in tree.items() if name not in ("", DEFAULTS)}
    return parts | dict(tree.get(DEFAULTS, {}))


def _short(tree: Tree) -> str:
    """Return `tree` as a short text for a message."""
    if isinstance(tree, dict):
        return str(tree.get("", "a mapping"))
    shown = tree if isinstance(tree, str) else text(tree)
    return shown if len(shown) < 40 else "another"

"""A computation as plain data that does not depend on how its numbers were written."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from functools import cache
from pathlib import PurePath
from typing import Any

import numpy as np

from contactstudy import InvalidInput

Tree = Any  # what JSON can hold

# Fields that stand at their default are kept apart under this name, and are no part of the key: a
# parameter that is new, and at its default, leaves the computation what it was.
DEFAULTS = "="


Memory = dict[int, tuple[object, Tree]]


def canonical(value: object, memory: Memory | None = None) -> Tree:
    """``value`` as a tree of text: numbers to twelve digits, dataclasses by name and fields.

    ``memory`` holds the dataclasses met before, for the many cases that share a scene.
    Raises :class:`~contactstudy.InvalidInput` for what has no value of its own, such as an object
    known by its address.
    """
    if is_dataclass(value) and not isinstance(value, type):
        if memory is None:
            return _record(value, {})
        if id(value) not in memory:
            memory[id(value)] = value, _record(value, memory)
        return memory[id(value)][1]
    match value:
        case bool() | np.bool_():
            return bool(value)
        case None | str():
            return value
        case int() | float() | np.integer() | np.floating():
            return _number(value)
        case Enum():
            return f"{type(value).__name__}.{value.name}"
        case np.ndarray():
            digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
            return {"": "array", "dtype": value.dtype.str, "shape": list(value.shape), "is": digest}
        case tuple() | list():
            return [canonical(item, memory) for item in value]
        case frozenset() | set():
            return sorted((canonical(item) for item in value), key=text)
        case Mapping():
            return {str(name): canonical(item) for name, item in sorted(value.items(), key=repr)}
        case PurePath() | complex():
            return str(value)
    raise InvalidInput(
        f"A case holds {value!r}, which cannot be told from another of its kind: make its class a "
        "frozen dataclass."
    )


def _number(value: float | np.number[Any]) -> str:
    if isinstance(value, int | np.integer):
        return str(int(value))
    short = f"{float(value):.12g}"  # 0.3 and 3 * 0.1 alike
    return "0" if short == "-0" else short


def _record(value: Any, memory: Memory) -> Tree:
    tree: dict[str, Tree] = {"": type(value).__name__}
    defaults: dict[str, Tree] = {}
    for part, default in _parts(type(value)):  # type: ignore[arg-type]
        held = canonical(getattr(value, part), memory)
        (defaults if held == default else tree)[part] = held
    return tree | {DEFAULTS: defaults} if defaults else tree


@cache
def _parts(kind: type) -> tuple[tuple[str, Tree], ...]:
    """The fields of a dataclass that tell its values apart, with the trees of their defaults."""
    found = []
    for part in fields(kind):
        default: Tree = MISSING
        if part.default is not MISSING:
            default = canonical(part.default)
        elif part.default_factory is not MISSING:
            default = canonical(part.default_factory())
        if part.compare:
            found.append((part.name, default))
    return tuple(found)


def text(tree: Tree) -> str:
    """``tree`` as JSON, always the same for the same tree."""
    return json.dumps(tree, sort_keys=True, separators=(",", ":"))


def key(tree: Tree) -> str:
    """What the computation is called in the journal: a hash of ``tree`` without its defaults."""
    return hashlib.sha256(text(_bare(tree)).encode()).hexdigest()[:24]


def _bare(tree: Tree) -> Tree:
    if isinstance(tree, dict):
        return {name: _bare(item) for name, item in tree.items() if name != DEFAULTS}
    return [_bare(item) for item in tree] if isinstance(tree, list) else tree


def differences(stored: Tree, now: Tree, name: str = "case") -> list[str]:
    """Where two trees say different things; a field that only one has, at its default, is none."""
    if not (isinstance(stored, dict) and isinstance(now, dict)):
        if isinstance(stored, list) and isinstance(now, list) and len(stored) == len(now):
            pairs = enumerate(zip(stored, now, strict=True))
            return [d for i, (a, b) in pairs for d in differences(a, b, f"{name}[{i}]")]
        return [] if stored == now else [f"{name} was {_short(stored)} and is {_short(now)}"]
    if stored.get("") != now.get(""):
        return [f"{name} was {_short(stored)} and is {_short(now)}"]
    before, after = _fields(stored), _fields(now)
    found = []
    for part in before.keys() | after.keys():
        if part in before and part in after:
            found += differences(before[part], after[part], f"{name}.{part}")
        elif part in stored or part in now:
            found.append(f"{name}.{part} is {'gone' if part in before else 'new'}")
    return sorted(found)


def _fields(tree: dict[str, Tree]) -> dict[str, Tree]:
    own = {name: item for name, item in tree.items() if name not in ("", DEFAULTS)}
    return own | dict(tree.get(DEFAULTS, {}))


def _short(tree: Tree) -> str:
    if isinstance(tree, dict):
        return str(tree.get("", "a mapping"))
    return text(tree) if len(text(tree)) < 40 else "another"

"""Canonical representation of a computation as plain data: equal for equal computations, different for others."""

import hashlib
import json
from collections import Counter, OrderedDict
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from enum import Enum, Flag
from functools import cache, cached_property
from pathlib import PurePath
from types import MappingProxyType
from typing import Any

import numpy as np

from contactstudy.domain.checks import InvalidInput

Tree = Any  # what JSON can hold

# Fields at their default are stored under this name and do not enter the key, so that a new parameter
# at its default does not change the identity of a computation.
DEFAULTS = "="


@dataclass(eq=False)
class CanonicalMemo:
    """Memo of the cases of one request: the trees of dataclasses that they share, and classes by their names."""

    records: dict[int, tuple[object, Tree]] = field(default_factory=dict)
    kinds: dict[str, type] = field(default_factory=dict)

    def name(self, cls: type) -> str:
        """Return the module and qualified name of a class, which identify it.

        Raises :class:`~contactstudy.InvalidInput` if another class has the same name.
        """
        name = f"{cls.__module__}.{cls.__qualname__}"
        if self.kinds.setdefault(name, cls) is not cls:
            raise InvalidInput(f"Two classes are called {name!r}: give each a name of its own.")
        return name


def canonical(value: object, memo: CanonicalMemo | None = None) -> Tree:
    """Return ``value`` as a tree that is unique to it: exact numbers with their types, dataclasses by their fields.

    Numbers have all their digits and text is in quotes: 1, 1.0, True, "1" and numpy's 1 differ, as do 0.0 and -0.0.
    The attributes of a subclass of a number, a text or a container count, and so do the mask of an array, the names
    of its fields and the order of a mapping. Fields that a dataclass does not compare are left out.

    Raises
    ------
    InvalidInput
        For an object that is identified by its address alone, or that may have hidden state.
    """
    memo = memo or CanonicalMemo()
    if is_dataclass(value) and not isinstance(value, type):
        if id(value) not in memo.records:
            memo.records[id(value)] = value, _record(value, memo)
        return memo.records[id(value)][1]
    cls = type(value)
    if value is None or cls is bool:
        return value
    if cls in PLAIN:
        return repr(value)
    if cls is tuple:
        return [canonical(item, memo) for item in value]  # type: ignore[attr-defined]
    if isinstance(value, np.ndarray | np.generic):
        return _array(value)
    if isinstance(value, Enum):  # a flag of several bits may have no name
        name = repr(value._value_) if isinstance(value, Flag) else value.name
        return {"": memo.name(cls), "name": name}
    content = _content(value, memo)
    attributes = _attributes(value)
    if content is None or attributes is None:
        raise _unknown(value)
    tree = {"": memo.name(cls), "is": content}
    return tree | {"has": canonical(attributes, memo)} if attributes else tree


PLAIN = (str, int, float, complex)
# containers and numbers of Python that have no state beyond their value
TRANSPARENT = (
    *PLAIN,
    bytes,
    list,
    tuple,
    set,
    frozenset,
    dict,
    OrderedDict,
    Counter,
    MappingProxyType,
)


def _content(value: object, memo: CanonicalMemo) -> Tree:
    """Return the content of a number, a text, a path or a container, also of a subclass; None for any other object."""
    match value:
        case PurePath():
            return [repr(str(value))]
        case set() | frozenset():
            return sorted((canonical(item, memo) for item in value), key=text)
        case tuple():
            return [canonical(item, memo) for item in tuple.__iter__(value)]
        case list():
            return [canonical(item, memo) for item in list.__iter__(value)]
        case dict():
            pairs: Iterable[tuple[Any, Any]] = dict.items(value)
        case Mapping():
            pairs = value.items()
        case bytes() | str() | int() | float() | complex():
            base = next(cls for cls in (*PLAIN, bytes) if isinstance(value, cls))
            return [base.__repr__(value)]
        case _:
            return None
    return [[canonical(k, memo), canonical(v, memo)] for k, v in pairs]


def _attributes(value: object) -> dict[str, object] | None:
    """Return the attributes of an object in addition to its content; None where it may have hidden state."""
    classes = (cls for cls in type(value).__mro__ if cls not in (*TRANSPARENT, object))
    if isinstance(value, PurePath):
        return {} if type(value).__module__.partition(".")[0] == "pathlib" else None
    attributes: dict[str, object] = {}
    for cls in classes:
        # a class of compiled code may keep anything; abstract ones of the standard library nothing
        if not cls.__flags__ & HEAP_TYPE:
            return None
        for name in _slots(cls):
            if name not in ("__dict__", "__weakref__") and hasattr(value, name):
                attributes[name] = getattr(value, name)
    return attributes | getattr(value, "__dict__", {})


HEAP_TYPE = 1 << 9  # flag of a class that Python code has made


def _slots(cls: type) -> tuple[str, ...]:
    """Return the names of the slots of a class."""
    slots = vars(cls).get("__slots__", ())
    return (slots,) if isinstance(slots, str) else tuple(slots)


def _array(value: "np.ndarray | np.generic") -> Tree:
    """Return type, shape, order and a hash of the bytes of an array, also of its mask; the digits of a scalar."""
    cls, dtype = type(value), value.dtype
    is_known = cls in ARRAYS if isinstance(value, np.ndarray) else cls is dtype.type
    if dtype.hasobject or not is_known or _has_own_attributes(value):
        raise _unknown(value)
    is_plain = dtype.fields is None and dtype.metadata is None
    name = dtype.str if is_plain else f"{dtype!r} {dtype.metadata}"
    if isinstance(value, np.generic) and dtype.fields is None:
        return {"": f"numpy {name}", "is": repr(value.item())}
    tree: dict[str, Tree] = {"": "array", "dtype": name, "shape": list(value.shape)}
    if cls is not np.ndarray:
        tree["kind"] = cls.__name__
    if isinstance(value, np.ma.MaskedArray):
        tree |= {"mask": _array(np.ma.getmaskarray(value)), "fill": repr(value.fill_value)}
        tree["hard"] = value.hardmask
        value = value.data
    if not value.flags.c_contiguous:  # sums over other strides differ in their last bits
        tree["strides"] = list(value.strides)
    return tree | {"is": hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()}


def _has_own_attributes(value: object) -> bool:
    """Return whether an array of a subclass has further attributes."""
    attributes = getattr(value, "__dict__", {})
    return bool(attributes.get("_optinfo")) or any(
        name not in MEMMAP_ATTRIBUTES and name[0] != "_" for name in attributes
    )


MEMMAP_ATTRIBUTES = ("filename", "offset", "mode")  # attributes of a memory-mapped array
# arrays that their values identify, wherever these are stored
ARRAYS = (np.ndarray, np.ma.MaskedArray, np.memmap, np.matrix, np.recarray)


def _unknown(value: object) -> InvalidInput:
    """Return the error for an object that is not hashable by value."""
    return InvalidInput(
        f"A case holds {value!r}, which is not hashable by value: make its class a frozen dataclass."
    )


def _record(value: Any, memo: CanonicalMemo) -> Tree:
    """Return the tree of a dataclass, with the fields at their defaults under ``DEFAULTS``."""
    tree: dict[str, Tree] = {"": memo.name(type(value))}
    defaults: dict[str, Tree] = {}
    for part, default in _compared_fields(type(value)):  # type: ignore[arg-type]
        content = canonical(getattr(value, part), memo)
        (defaults if content == default else tree)[part] = content
    # the content of a subclass of a number or a list, and attributes that are no fields
    if (content := _content(value, memo)) is not None:
        tree["+is"] = content
    names = {part.name for part in fields(value)}
    for name, attribute in getattr(value, "__dict__", {}).items():
        if name not in names and not isinstance(getattr(type(value), name, None), cached_property):
            tree[f"+{name}"] = canonical(attribute, memo)
    return tree | {DEFAULTS: defaults} if defaults else tree


@cache
def _compared_fields(cls: type) -> tuple[tuple[str, Tree], ...]:
    """Return the names of the fields that a dataclass compares, with the trees of their defaults."""
    parts = []
    for part in fields(cls):
        default: Tree = MISSING
        if part.default is not MISSING:
            default = canonical(part.default)
        elif part.default_factory is not MISSING:
            default = canonical(part.default_factory())
        if part.compare:
            parts.append((part.name, default))
    return tuple(parts)


ENCODER = json.JSONEncoder(sort_keys=True, separators=(",", ":"))


def text(tree: Tree) -> str:
    """Return ``tree`` as JSON with sorted keys."""
    return ENCODER.encode(tree)


def key(tree: Tree) -> str:
    """Return the key of a computation in the journal: a hash of ``tree`` without the fields at their defaults."""
    return keys(tree)[0]


def keys(tree: Tree) -> tuple[str, str]:
    """Return the key of a computation, and a hash of its whole tree, fields at their defaults included."""
    canonical = text(tree)
    exact = hashlib.sha256(canonical.encode()).hexdigest()[:24]
    if f'"{DEFAULTS}":' not in canonical:
        return exact, exact
    return hashlib.sha256(text(_without_defaults(tree)).encode()).hexdigest()[:24], exact


def _without_defaults(tree: Tree) -> Tree:
    """Return `tree` without the fields at their defaults."""
    if isinstance(tree, dict):
        return {name: _without_defaults(item) for name, item in tree.items() if name != DEFAULTS}
    return [_without_defaults(item) for item in tree] if isinstance(tree, list) else tree


def differences(stored: Tree, now: Tree, name: str = "case") -> list[str]:
    """Return a sentence for each difference of two trees; a field that only one has, at its default, does not count."""
    if not (isinstance(stored, dict) and isinstance(now, dict)):
        if isinstance(stored, list) and isinstance(now, list) and len(stored) == len(now):
            pairs = enumerate(zip(stored, now, strict=True))
            return [d for i, (a, b) in pairs for d in differences(a, b, f"{name}[{i}]")]
        return (
            [] if stored == now else [f"{name} was {_shortened(stored)} and is {_shortened(now)}"]
        )
    if stored.get("") != now.get(""):
        return [f"{name} was {_shortened(stored)} and is {_shortened(now)}"]
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


def _shortened(tree: Tree) -> str:
    """Return `tree` as a short text for a message."""
    if isinstance(tree, dict):
        return str(tree.get("", "a mapping"))
    shown = tree if isinstance(tree, str) else text(tree)
    return shown if len(shown) < 40 else "another"

"""Digest of a value: equal for equal computations, different for others, on every machine and in every session."""

import hashlib
from dataclasses import fields, is_dataclass
from enum import Enum, Flag
from functools import cache, cached_property, partial
from pathlib import PurePath
from types import BuiltinFunctionType, CodeType, FunctionType, MappingProxyType, MethodType
from typing import Any

import numpy as np

from contactstudy.domain.validation import InvalidInput

# Digests of dataclasses by their id, with the object, so that the id stays its own; classes by their names.
Memo = dict[int | str, tuple[object, str]]
PLAIN = (str, int, float, complex, bytes)
DIGITS = 24


def digest(value: object, memo: Memo | None = None) -> str:
    """Return 24 hexadecimal digits that identify `value`: dataclasses, arrays, numbers, text, and containers of them.

    Numbers count with all their digits and with their types: 1, 1.0, True, "1" and numpy's 1 differ, as do 0.0 and
    -0.0. Fields that a dataclass does not compare are left out. A function counts by its name, its own code, its
    defaults and what it encloses, and so do the methods of a class made in a function. A memo also gets these functions
    and the classes of all values.

    Raises
    ------
    InvalidInput
        For any other object, which may have hidden state, and for two classes of one name.
    """
    return hashed(repr(_parts(value, {} if memo is None else memo)).encode())


def hashed(content: bytes) -> str:
    """Return 24 hexadecimal digits that identify the `content` of a file."""
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def _parts(value: Any, memo: Memo) -> Any:
    """Return a value as text, None, True, False, and tuples of these."""
    kind = type(value)
    if value is None or kind is bool:
        return value
    if kind in PLAIN:
        return repr(value)
    name = _name(kind, memo)
    if isinstance(value, Enum):  # a flag of several bits may have no name
        return name, repr(value.value) if isinstance(value, Flag) else value.name
    if isinstance(value, np.ndarray | np.generic):
        if not value.dtype.hasobject and (kind in (np.ndarray, value.dtype.type)):
            # sums over other strides differ in their last bits
            strides = () if value.flags.c_contiguous else value.strides
            content = hashed(np.ascontiguousarray(value).tobytes())
            return name, repr(value.dtype), value.shape, strides, content
    elif is_dataclass(value) and not isinstance(value, type):
        if id(value) not in memo:
            memo[id(value)] = value, hashed(repr((name, _of_dataclass(value, memo))).encode())
        return memo[id(value)][1]
    elif kind in (tuple, list):
        return name, tuple(_parts(item, memo) for item in value)
    elif kind in (dict, MappingProxyType):
        return name, tuple((_parts(k, memo), _parts(v, memo)) for k, v in value.items())
    elif kind in (set, frozenset):
        return name, tuple(sorted(digest(item, memo) for item in value))
    elif isinstance(value, PurePath):
        return name, str(value)
    elif isinstance(value, type | BuiltinFunctionType | np.ufunc):
        return name, f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', value)}"
    elif kind is partial:
        return name, _parts((value.func, value.args, value.keywords), memo)
    elif kind is MethodType:
        return name, _parts((value.__func__, value.__self__), memo)
    elif kind is FunctionType:
        known = f"{value.__module__}.{value.__qualname__}"
        memo[f"def {known}"] = value, ""
        enclosed = tuple(cell.cell_contents for cell in value.__closure__ or ())
        held = value.__defaults__, value.__kwdefaults__, enclosed
        return name, known, _code(value.__code__), _parts(held, memo)
    raise InvalidInput(
        f"A case or its measures hold {value!r:.100}, whose state cannot be seen: make its class a frozen dataclass."
    )


def _name(kind: type, memo: Memo) -> str:
    """Return module and name of a class; raise InvalidInput if another class has the same."""
    name = f"{kind.__module__}.{kind.__qualname__}"
    if memo.setdefault(name, (kind, ""))[0] is not kind:
        raise InvalidInput(f"Two classes are called {name!r}: give each a name of its own.")
    return name


def _of_dataclass(value: Any, memo: Memo) -> Any:
    """Return the compared fields of a dataclass, and its further attributes, by their names."""
    kind: Any = type(value)
    compared, known = _fields(kind)
    further = getattr(value, "__dict__", {}).keys() - known
    parts = [(name, _parts(getattr(value, name), memo)) for name in (*compared, *sorted(further))]
    if "<locals>" in kind.__qualname__:
        methods = (member for member in vars(kind).values() if isinstance(member, FunctionType))
        # not those that dataclasses makes
        parts += [("", _parts(of, memo)) for of in methods if of.__code__.co_filename != "<string>"]
    return parts


def _code(code: CodeType) -> tuple[object, ...]:
    """Return what of the code of a function does not depend on its place in a file."""
    constants = (
        _code(of) if isinstance(of, CodeType) else sorted(map(repr, of)) if isinstance(of, frozenset) else repr(of)
        for of in code.co_consts
    )
    return code.co_code, code.co_names, tuple(constants)


@cache
def _fields(kind: Any) -> tuple[list[str], set[str]]:
    """Return the names of the fields that a dataclass compares; those of all its fields and cached properties."""
    if issubclass(kind, (*PLAIN, list, tuple, dict, set, frozenset, np.ndarray)):
        raise InvalidInput(
            f"{kind.__qualname__} is a dataclass and a container or number as well: give its content a field."
        )
    every = fields(kind)
    members = [member for of in kind.__mro__ for member in vars(of).items()]
    cached = {name for name, member in members if isinstance(member, cached_property)}
    return [part.name for part in every if part.compare], {part.name for part in every} | cached

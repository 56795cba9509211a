"""Changes a module of the project where it is loaded, so that a fork tries a change without importing anything anew."""

import functools
import gc
import re
import sys
from collections.abc import Iterator
from importlib import import_module
from types import CodeType, FunctionType
from typing import Any

from tests.mutation.mutations import Mutation

PROJECT = ("contactstudy", "studies", "tests")


def _pairs(before: CodeType, after: CodeType) -> Iterator[tuple[CodeType, CodeType]]:
    yield before, after
    for old, new in zip(before.co_consts, after.co_consts, strict=False):
        if isinstance(old, CodeType) and isinstance(new, CodeType):
            yield from _pairs(old, new)


def _compiled(mutation: Mutation, text: str) -> list[tuple[CodeType, CodeType]]:
    """Code before and after, of the module first, of what is defined in it where that differs."""
    codes = (compile(one, mutation.path, "exec") for one in (text, mutation.applied(text)))
    return [pair for pair in _pairs(*codes) if pair[0] != pair[1]]


def changed_function(mutation: Mutation, text: str) -> str:
    """Path and qualified name of the innermost function that is changed, as of :func:`name_of`."""
    return f"{mutation.path}:{_compiled(mutation, text)[-1][0].co_qualname}"


def put_in_place(mutation: Mutation, text: str) -> bool:
    """Change the code of functions, values of modules and classes, and defaults; False where nothing changes by that."""
    name = mutation.path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    module = import_module(name)
    (before, after), *inner = _compiled(mutation, text)
    done = False
    for one in gc.get_objects():
        if isinstance(one, FunctionType) and one.__module__ == name:
            for old, new in inner:
                if one.__code__ == old:
                    one.__code__, done = new, True
        elif isinstance(one, functools._lru_cache_wrapper) and one.__module__.startswith(PROJECT):
            one.cache_clear()
    old_values, new_values = ({**vars(module)} for _ in range(2))
    exec(before, old_values)
    exec(after, new_values)
    shown = {place: _shown(value) for place, value in _values(old_values, name)}
    for place, value in _values(new_values, name):
        if shown.get(place) != _shown(value):
            _set(module, place, value)
            done = True
    return done


def _shown(value: object) -> str:
    return re.sub(r" at 0x[0-9a-f]+", "", repr(value))


def _values(space: dict[str, Any], module: str) -> Iterator[tuple[tuple[str, ...], object]]:
    """Constants, attributes of classes and defaults of functions and methods, by their place in a module."""
    for name, value in space.items():
        if isinstance(value, type | FunctionType):
            if value.__module__ != module:
                continue
            for key, inner in vars(value).items() if isinstance(value, type) else ():
                if isinstance(inner, FunctionType):
                    yield (name, key, "__defaults__"), inner.__defaults__
                elif not key.startswith("__"):
                    yield (name, key), inner
            if isinstance(value, FunctionType):
                yield (name, "__defaults__"), value.__defaults__
        elif not name.startswith("__"):
            yield (name,), value


def _set(module: Any, place: tuple[str, ...], value: object) -> None:
    """Set a value of a module, and under the same name where it was imported."""
    *owners, last = place
    if owners:
        setattr(functools.reduce(lambda owner, key: vars(owner)[key], owners, module), last, value)
        return
    before = vars(module)[last]
    for other in list(sys.modules.values()):
        if other.__name__.startswith(PROJECT) and vars(other).get(last) is before:
            setattr(other, last, value)

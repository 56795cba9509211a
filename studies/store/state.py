"""State of functions and classes: what they compute with besides the files they come from.

Two functions of one file differ by their defaults, by what they close over, and by what the environment has made of the
constants that they name.
"""

import pickle
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cached_property, partial
from types import CodeType, FunctionType, MethodType, ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.identity import Tree, canonical, text
from studies.store.loaded import THIS_PROGRAM, digest, entry_of, resolved

REMEDY = "make it a function of a file, a partial of one, or a frozen dataclass with __call__"


@dataclass(eq=False)
class States:
    """States of functions and classes, each taken once.

    Attributes
    ----------
    modules
        Names of the modules from which functions and classes came.
    """

    modules: set[str] = field(default_factory=set)
    _taken: dict[tuple[int, str], tuple[object, Tree]] = field(default_factory=dict)
    _users: dict[str, bool] = field(default_factory=lambda: {"__main__": True, "builtins": False})

    def held(self, value: Any, holder: str = "measures") -> Tree:
        """Return the state of a function, and of all that it holds.

        Raises
        ------
        InvalidInput
            For an object whose state cannot be seen.
        """
        if isinstance(value, tuple | list | dict | set | frozenset):
            items = value.items() if isinstance(value, dict) else value
            parts = [self.held(item, holder) for item in items]
            ordered = sorted(parts, key=text) if isinstance(value, set | frozenset) else parts
            return [type(value).__name__, ordered]
        state = self._callable(value, self.held)
        if state is not None:
            return state
        if is_dataclass(value) and not isinstance(value, type):
            if not type(value).__dataclass_params__.frozen:  # type: ignore[attr-defined]
                raise _refused(value, holder)
            parts = [
                [part.name, self.held(getattr(value, part.name), holder)]
                for part in fields(value) if part.compare
            ]  # fmt: skip
            return [self.of_class(type(value)), parts]
        try:
            return canonical(value)
        except InvalidInput:
            raise _refused(value, holder) from None

    def _seen(self, value: Any, _: str = "") -> Tree:
        """Return the state of a value that a module or a class has; None for an object that cannot be written."""
        state = self._callable(value, self._seen)
        if state is not None or isinstance(value, ModuleType):
            return state
        with suppress(InvalidInput, RecursionError):
            return canonical(value)
        if isinstance(value, tuple | list):
            return [self._seen(item) for item in value]
        if type(value) is dict:
            return [[k, self._seen(v)] for k, v in value.items() if isinstance(k, str)]
        kind = type(value)
        if kind is SimpleNamespace or (
            hasattr(value, "__dict__") and self._is_users(kind.__module__)
        ):
            return self._once(
                value, "seen", lambda: [self.of_class(kind), self._seen(dict(vars(value)))]
            )
        with suppress(Exception):  # an object of a library, which may not be written
            return [f"{kind.__module__}.{kind.__qualname__}", digest(pickle.dumps(value))]
        return None

    def _callable(self, value: Any, of: Callable[..., Tree]) -> Tree | None:
        """Return the state of a function or class, with what it holds as `of` sees it; None for another value."""
        if isinstance(value, type):
            return self.of_class(value)
        if isinstance(value, partial):
            return ["partial", of(value.func), of(list(value.args)), of(dict(value.keywords))]
        if isinstance(value, MethodType):
            return ["method", of(value.__func__), of(value.__self__)]
        if isinstance(value, FunctionType):
            return self._once(value, of.__name__, lambda: self._function(value, of))
        if isinstance(value, staticmethod | classmethod):
            return of(value.__func__)
        if isinstance(value, property):
            return [of(part) for part in (value.fget, value.fset) if part is not None]
        if isinstance(value, cached_property):
            return of(value.func)
        if isinstance(value, np.ufunc):
            return repr(value)
        if callable(value) and hasattr(value, "__wrapped__"):  # a cache around a function
            return of(value.__wrapped__)
        name = getattr(value, "__qualname__", None)
        owner = getattr(value, "__self__", None)
        if callable(value) and name and (owner is None or isinstance(owner, ModuleType | type)):
            return f"{getattr(value, '__module__', '')}.{name}"  # of compiled code
        return None

    def _once(self, value: object, kind: str, state: Callable[[], Tree]) -> Tree:
        """Return the state of an object that may name itself."""
        identity = id(value), kind
        if identity not in self._taken:
            self._taken[identity] = value, len(self._taken)
            self._taken[identity] = value, state()
        return self._taken[identity][1]

    def _function(self, function: FunctionType, of: Callable[..., Tree]) -> Tree:
        """Return the code of a function, what it holds, and the values that it names."""
        self.modules.add(function.__module__)
        parts: list[Tree] = [
            f"{function.__module__}.{function.__qualname__}",
            of(list(function.__defaults__ or ())),
            of(function.__kwdefaults__ or {}),
            of(dict(vars(function))),
        ]
        for cell in function.__closure__ or ():
            try:
                content = cell.cell_contents
            except ValueError:  # a name that is not bound yet
                continue
            parts.append(of(content))
        if self._is_users(function.__module__):
            parts.append(_code(function.__code__, function.__doc__))
            names = sorted(set(_names(function.__code__)))
            parts.append(dict(self._named(names, function.__globals__)))
        return parts

    def _named(self, names: list[str], variables: Mapping[str, Any]) -> Iterator[tuple[str, Tree]]:
        """Yield the global values of these names, and those of modules that are named with their module."""
        for name in names:
            if name not in variables or name.startswith("__"):
                continue
            value = variables[name]
            if isinstance(value, ModuleType):
                if self._is_users(value.__name__):
                    inner = [(part, vars(value)[part]) for part in names if part in vars(value)]
                    yield name, [[part, self._seen(v)] for part, v in inner if v is not value]
            else:
                yield name, self._seen(value)

    def _is_users(self, module: str) -> bool:
        """Return whether a module is a user's: not of this program, a distribution or the standard library."""
        if module not in self._users:
            loaded, spec = sys.modules.get(module), resolved(module)
            if module.partition(".")[0] in THIS_PROGRAM:
                self._users[module] = False
            elif loaded is None or spec is None or "__source__" in vars(loaded):
                self._users[module] = True
            else:
                entry = entry_of(module, spec)
                self._users[module] = entry is not None and entry[0].startswith("module")
        return self._users[module]

    def of_class(self, kind: type) -> Tree:
        """Return the state of a class: its functions and the plain values among its attributes."""
        return self._once(kind, "class", lambda: self._class(kind))

    def _class(self, kind: type) -> Tree:
        name = f"{kind.__module__}.{kind.__qualname__}"
        if not self._is_users(kind.__module__):
            return name
        self.modules.add(kind.__module__)
        attributes = {
            name: self._seen(value)
            for name, value in vars(kind).items()
            if not name.startswith("__") or (callable(value) and not _is_generated(value))
        }
        return [name, [self.of_class(base) for base in kind.__bases__], attributes]


def _is_generated(method: object) -> bool:
    """Return whether a method was written by ``dataclass``."""
    code = getattr(getattr(method, "__wrapped__", method), "__code__", None)
    return isinstance(code, CodeType) and code.co_filename == "<string>"


def _names(code: CodeType) -> Iterator[str]:
    """Yield all names that code and the functions within it use."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _code(code: CodeType, text_of: str | None = None) -> Tree:
    """Return code without its lines and its documentation, as a tree."""
    constants = [_constant(None if part == text_of else part) for part in code.co_consts]
    names = [code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars]
    return [digest(code.co_code), code.co_flags, constants, [list(part) for part in names]]


def _constant(constant: object) -> Tree:
    """Return a constant of code as a tree."""
    if isinstance(constant, CodeType):
        return _code(constant)
    return repr(constant) if constant is ... else canonical(constant)


def _refused(value: object, holder: str) -> InvalidInput:
    """Return the error for an object whose state cannot be seen."""
    return InvalidInput(
        f"{holder} holds an object of {type(value).__qualname__}, whose state cannot be seen, so that what is stored "
        f"could be another's: {REMEDY}."
    )

"""State of functions and classes: code, defaults, closures and the globals that they name, as trees to be hashed.

The files that they come from do not determine it: two functions of one file differ by their defaults and closures, and
a constant may depend on the environment.
"""

import pickle
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from functools import cached_property, partial
from types import CodeType, FunctionType, MethodType, ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.identity import Tree, canonical, text
from studies.store.fingerprint.modules import THIS_PROGRAM, current_spec, digest, fingerprint_of

PLAIN = (type(None), bool, str, bytes, int, float, complex)
CONTAINERS = (tuple, list, dict, set, frozenset)
REMEDY = "make it a function of a file, a partial of one, or a frozen dataclass with __call__"


@dataclass(eq=False)
class States:
    """States of functions and classes, each computed once.

    Attributes
    ----------
    modules
        Names of the modules from which functions and classes came.
    """

    modules: set[str] = field(default_factory=set)
    _taken: dict[tuple[int, str | None], tuple[object, Tree]] = field(default_factory=dict)
    _users: dict[str, bool] = field(default_factory=lambda: {"__main__": True, "builtins": False})

    def state_of(self, value: Any, owner: str | None = "measures") -> Tree:
        """Return the state of a function, class or value, and of all that it holds.

        For an object whose state cannot be seen, :class:`~contactstudy.InvalidInput` names its `owner`; without an
        owner the state is None.
        """
        if type(value) in PLAIN:
            return canonical(value)
        if owner is None and isinstance(value, ModuleType):
            return None
        state = self._callable(value, owner)
        return self._once(value, owner, self._value) if state is None else state

    def _value(self, value: Any, owner: str | None) -> Tree:
        """Return the state of a value that is no function."""
        kind = type(value)
        if kind in CONTAINERS:
            items = value.items() if kind is dict else value
            parts = [self.state_of(item, owner) for item in items]
            return [kind.__name__, sorted(parts, key=text) if kind in (set, frozenset) else parts]
        is_record = is_dataclass(value) and not isinstance(value, (*CONTAINERS, *PLAIN))
        if owner is None and hasattr(value, "__dict__"):
            is_record |= kind is SimpleNamespace or self._is_users(kind.__module__)
        is_fixed = not is_dataclass(value) or kind.__dataclass_params__.frozen
        if is_fixed or owner is None:
            if is_record:
                return [self.of_class(kind), self.state_of(_attributes(value), owner)]
            with suppress(InvalidInput, RecursionError):
                return [self.of_class(kind), canonical(value)]
        if owner is not None:
            raise InvalidInput(
                f"{owner} holds an object of {kind.__qualname__}, whose state cannot be seen, so that what is "
                f"stored could be another's: {REMEDY}."
            )
        with suppress(Exception):  # an object of a library, which may not be written
            return [f"{kind.__module__}.{kind.__qualname__}", digest(pickle.dumps(value))]
        return None

    def _callable(self, value: Any, owner: str | None) -> Tree | None:
        """Return the state of a function or class with what it holds; None for another value."""
        if isinstance(value, type):
            return self.of_class(value)
        if isinstance(value, partial):
            parts = [value.func, value.args, value.keywords, vars(value)]
            return ["partial", self.state_of(parts, owner)]
        if isinstance(value, MethodType):
            return ["method", self.state_of([value.__func__, value.__self__], owner)]
        if isinstance(value, FunctionType):
            return self._once(value, owner, self._function)
        if isinstance(value, property):
            return self.state_of([value.fget, value.fset], owner)
        if isinstance(value, cached_property):
            return self.state_of(value.func, owner)
        is_callable = callable(value) or isinstance(value, classmethod)
        if is_callable and hasattr(value, "__wrapped__"):  # a method, or a cache around a function
            return self.state_of(value.__wrapped__, owner)
        if isinstance(value, np.ufunc):  # of a library; another one may be made of any function
            libraries = np, sys.modules.get("scipy.special")
            is_known = any(getattr(library, value.__name__, None) is value for library in libraries)
            return repr(value) if is_known else None
        name = getattr(value, "__qualname__", None)
        instance = getattr(value, "__self__", None)
        if (
            callable(value)
            and name
            and (instance is None or isinstance(instance, ModuleType | type))
        ):
            return f"{getattr(value, '__module__', '')}.{name}"  # of compiled code
        return None

    def _once(
        self, value: Any, owner: str | None, state: Callable[[Any, str | None], Tree]
    ) -> Tree:
        """Return the state of an object that may refer to itself, computed once."""
        identity = id(value), owner
        if identity not in self._taken:
            self._taken[identity] = value, "itself"
            self._taken[identity] = value, state(value, owner)
        return self._taken[identity][1]

    def _function(self, function: FunctionType, owner: str | None) -> Tree:
        """Return the code of a function, what it holds, and the values that it names."""
        self.modules.add(function.__module__)
        values = [function.__defaults__, function.__kwdefaults__, vars(function)]
        parts = [f"{function.__module__}.{function.__qualname__}", self.state_of(values, owner)]
        for cell in function.__closure__ or ():
            try:
                content = cell.cell_contents
            except ValueError:  # a name that is not bound yet
                continue
            parts.append(self.state_of(content, owner))
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
                    yield (
                        name,
                        [[part, self.state_of(v, None)] for part, v in inner if v is not value],
                    )
            else:
                yield name, self.state_of(value, None)

    def _is_users(self, module: str) -> bool:
        """Return whether a module is the user's: not of this program, a distribution or the standard library."""
        if module not in self._users:
            loaded, spec = sys.modules.get(module), current_spec(module)
            if module.partition(".")[0] in THIS_PROGRAM:
                self._users[module] = False
            elif loaded is None or spec is None or "__source__" in vars(loaded):
                self._users[module] = True
            else:
                entry = fingerprint_of(module, spec)
                self._users[module] = entry is not None and entry[0].startswith("module")
        return self._users[module]

    def of_class(self, kind: type) -> Tree:
        """Return the state of a class: its functions and the plain values among its attributes."""
        return self._once(kind, None, self._class)

    def _class(self, kind: type, _: str | None) -> Tree:
        """Return the state of a class; only the name of one that is not the user's."""
        name = f"{kind.__module__}.{kind.__qualname__}"
        if not self._is_users(kind.__module__):
            return name
        self.modules.add(kind.__module__)
        attributes = {
            name: self.state_of(value, None)
            for name, value in vars(kind).items()
            if not name.startswith("__") or (callable(value) and not _is_generated(value))
        }
        if is_dataclass(kind):
            factories = [part.default_factory for part in fields(kind)]
            attributes["__dataclass_fields__"] = self.state_of(
                [factory for factory in factories if factory is not MISSING], None
            )
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


def _code(code: CodeType, docstring: str | None = None) -> Tree:
    """Return code without its line numbers and its `docstring`, as a tree."""
    constants = [_constant(None if part == docstring else part) for part in code.co_consts]
    names = [code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars]
    return [digest(code.co_code), code.co_flags, constants, [list(part) for part in names]]


def _constant(constant: object) -> Tree:
    """Return a constant of code as a tree."""
    if isinstance(constant, CodeType):
        return _code(constant)
    return repr(constant) if constant is ... else canonical(constant)


def _attributes(value: object) -> dict[str, Any]:
    """Return the attributes of an object, without fields that are not compared and without what was cached."""
    parts = fields(value) if is_dataclass(value) else ()
    attributes = {part.name: getattr(value, part.name) for part in parts}
    attributes |= getattr(value, "__dict__", {})
    ignored = {part.name for part in parts if not part.compare} | {
        name for name, part in vars(type(value)).items() if isinstance(part, cached_property)
    }
    return {name: part for name, part in attributes.items() if name not in ignored}

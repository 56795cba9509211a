"""The code that makes a number of a case, as a fingerprint: where it changes, numbers may."""

import ast
import hashlib
import importlib.util
import inspect
import sysconfig
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import contactstudy
from contactstudy import InvalidInput
from studies.store.identity import canonical, text

# Libraries that the numbers of a case depend on, and the folders of the core that cannot change a number.
LIBRARIES = ("numpy", "scipy", "ducc0")
NOT_NUMERICAL = ("io", "planning")


@cache
def versions() -> Mapping[str, str]:
    """Version of the core and of the libraries it computes with, and a hash of the core's numerical code."""
    core = Path(contactstudy.__file__).parent
    found = {"contactstudy": contactstudy.__version__, "source": source_fingerprint(core)}
    for name in LIBRARIES:
        if importlib.util.find_spec(name):
            try:
                found[name] = version(name)
            except PackageNotFoundError:
                found[name] = "unknown"
    return found


def source_fingerprint(core: Path) -> str:
    """A hash of the modules in the package ``core`` that can change a number.

    Comments, docstrings and layout do not count.
    """
    digest = hashlib.sha256()
    for path in sorted(core.rglob("*.py")):
        name = path.relative_to(core)
        if name.parts[0] not in NOT_NUMERICAL:
            tree = _without_docstrings(ast.parse(path.read_text(encoding="utf-8")))
            digest.update(f"{name} {ast.dump(tree)}".encode())
    return digest.hexdigest()[:12]


def measures_fingerprint(measures: Callable[..., object], kinds: frozenset[type]) -> str:
    """A hash of ``measures``, of the methods of the computations ``kinds``, and of what these call.

    Comments, docstrings and layout do not count; nor does the core, which has its version, nor a
    library.
    """
    seen: dict[int, str] = {}
    for root in (measures, *kinds):
        _follow(root, seen)
    return hashlib.sha256("\n".join(sorted(set(seen.values()))).encode()).hexdigest()[:12]


def _follow(thing: object, seen: dict[int, str]) -> None:
    if not callable(thing) and not isinstance(thing, ModuleType):
        with suppress(InvalidInput):  # a table of functions, or the like
            seen[id(thing)] = text(canonical(thing))
        return
    if isinstance(thing, type):
        if id(thing) not in seen and not _is_library(thing):
            seen[id(thing)] = thing.__name__
            for method in _methods(thing):
                _follow(method, seen)
        return
    function = inspect.unwrap(thing) if callable(thing) else thing
    if not isinstance(function, FunctionType) or id(function) in seen or _is_library(function):
        return
    try:
        source = ast.parse(inspect.cleandoc("\n" + inspect.getsource(function)))
    except (OSError, SyntaxError, TypeError):  # typed at a prompt, or a lambda amid a line
        seen[id(function)] = function.__code__.co_code.hex() + repr(function.__code__.co_names)
    else:
        seen[id(function)] = ast.dump(_without_docstrings(source))
    for used in _used(function):
        _follow(used, seen)


def _methods(kind: type) -> Iterator[object]:
    """But for what a dataclass makes of its fields: those are the case's own."""
    own = {part.name for part in fields(kind)} if is_dataclass(kind) else set()
    for owner in kind.__mro__:
        for name, part in vars(owner).items():
            if name in own:
                continue
            if not name.startswith("__") or name == "__post_init__":
                method = getattr(part, "__func__", part)
                yield method.fget if isinstance(method, property) else method


def _without_docstrings(tree: ast.Module) -> ast.Module:
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef) and ast.get_docstring(
            node
        ):
            node.body = node.body[1:] or [ast.Pass()]
    return tree


def _used(function: FunctionType) -> Iterator[object]:
    """What the names in ``function`` stand for, those in a module it names as well."""
    names = _names(function.__code__)
    for name in names:
        found = function.__globals__.get(name)
        yield found
        if isinstance(found, ModuleType) and not _is_library(found):
            yield from (getattr(found, other) for other in names if hasattr(found, other))


def _names(code: Any) -> list[str]:
    inner = [name for part in code.co_consts if hasattr(part, "co_names") for name in _names(part)]
    return [*code.co_names, *inner]


@cache
def _libraries() -> tuple[str, ...]:
    paths = sysconfig.get_paths()
    return paths["stdlib"], paths["purelib"], paths["platlib"]


def _is_library(thing: FunctionType | ModuleType | type) -> bool:
    module = thing if isinstance(thing, ModuleType) else inspect.getmodule(thing)
    if module is None:
        return False
    if module.__name__.split(".")[0] == "contactstudy":
        return True
    if module.__name__.split(".")[0] == "studies":
        return False
    file = getattr(module, "__file__", None)
    return file is None or str(file).startswith(_libraries())

"""Fingerprints of the code and the files that the numbers of a case come from."""

import ast
import hashlib
import importlib.util
import secrets
import sys
import sysconfig
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache, partial
from importlib.machinery import ModuleSpec, PathFinder
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import ModuleType

from contactstudy import InvalidInput
from contactstudy.domain.identity import canonical, text
from contactstudy.domain.version import VERSION, source_hash
from studies.model.study import NOT_NUMBERS, Study

# Libraries that the numbers of a case depend on.
LIBRARIES = ("numpy", "scipy", "ducc0")
# Parts of this package that make numbers; other parts run, store and show them.
NUMERICAL = ("definitions", "model", "reference", "scene_study")
OF_CASES = "cases of "
CONSTANT = (bool, int, float, complex, str, bytes, tuple, frozenset)
INSTALLED = ("site-packages", "dist-packages")


@cache
def versions() -> dict[str, str]:
    """Return the version of the core and of the libraries it computes with, and a hash of the core's code."""
    found_versions = {"contactstudy": VERSION, "source": source_hash()}
    for name in LIBRARIES:
        if importlib.util.find_spec(name):
            try:
                found_versions[name] = version(name)
            except PackageNotFoundError:
                found_versions[name] = "unknown"
    return found_versions


def study_fingerprint(study: Study, kinds: Iterable[type]) -> dict[str, str]:
    """Return a hash of each file that the numbers of a study come from, by the name of its module or file.

    These are the module of its measures, every module that it imports anywhere, but for installed distributions, and the
    ``files`` that the study names; after ``OF_CASES``, further modules that the classes of its cases come from. All
    bytes count, comments too, but not the axes, figures, findings and tables of a study file; so do numbers and text
    that a module has as constants, wherever they come from. Code that was typed at a prompt never has the same hash.

    Parameters
    ----------
    study
        The study.
    kinds
        Classes of its cases.

    Raises
    ------
    InvalidInput
        For a file that cannot be read.
    """
    hashes: dict[str, str] = {}
    measures = study.measures
    while isinstance(measures, partial):
        arguments = text(canonical((measures.args, measures.keywords)))
        hashes["arguments"] = _hash(hashes.get("arguments", ""), arguments)
        measures = measures.func
    hashes["measures"] = _function(measures)
    _add_module(getattr(measures, "__module__", None) or type(measures).__module__, hashes)
    for name in study.files:
        try:
            hashes[name] = _hash((study.folder / name).read_bytes())
        except (OSError, ValueError) as error:
            raise InvalidInput(
                f"Study {study.name!r} names the file {name!r}, which cannot be read ({error}): mend 'files'."
            ) from None
    all_hashes = dict(hashes)
    for kind in kinds:
        _add_module(kind.__module__, all_hashes)
    return hashes | {
        f"{OF_CASES}{name}": all_hashes[name] for name in all_hashes.keys() - hashes.keys()
    }


def _function(function: object) -> str:
    """Return the identity of a function within its module: its name, its defaults and its closure."""
    named = function if hasattr(function, "__qualname__") else type(function)
    values = [getattr(function, "__defaults__", None), getattr(function, "__kwdefaults__", None)]
    with suppress(ValueError):  # a name that is not bound yet
        values += [cell.cell_contents for cell in getattr(function, "__closure__", None) or ()]
    constants = []
    for value in values:
        with suppress(InvalidInput):
            constants.append(text(canonical(value)))
    if "<lambda>" in named.__qualname__:  # which differ in their line alone
        constants.append(str(getattr(getattr(function, "__code__", None), "co_firstlineno", 0)))
    return f"{named.__module__}.{named.__qualname__} {_hash(*constants)}"


def agree(stored: Mapping[str, str], now: Mapping[str, str]) -> bool:
    """Return whether numbers of the context `stored` are valid in the context `now`."""
    return not disagreements(stored, now)


def disagreements(stored: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Return sentences on where two contexts differ; classes of cases that only one of them has are ignored."""
    return [
        f"{name} was {stored.get(name, 'absent')} and is {now.get(name, 'absent')}"
        for name in sorted(stored.keys() | now.keys())
        if stored.get(name) != now.get(name)
        and not (name.startswith(OF_CASES) and (name not in stored or name not in now))
    ]


def _add_module(name: str, hashes: dict[str, str]) -> None:
    """Add the hashes of the loaded module `name`, and of the modules that it imports."""
    if file := getattr(sys.modules.get(name), "__file__", None):
        if _counts(name, Path(file)):
            _add(name, Path(file), hashes)
    else:
        hashes[name] = secrets.token_hex(6)


def _add(name: str, file: Path, hashes: dict[str, str]) -> None:
    """Add the hash of the module ``name`` in ``file``, and those of the modules that it imports."""
    module = sys.modules.get(name)
    # the text of a study file as it was read: it may have been edited since
    source = getattr(module, "__source__", None)
    label = name if source is None else file.name
    if label in hashes:
        return
    numerical = file.read_bytes() if source is None else _numerical(source)
    hashes[label] = _hash(numerical, _constants(module))
    if file.suffix == ".py":
        package = name if file.name == "__init__.py" else name.rpartition(".")[0]
        for imported in _imports(numerical, package):
            spec = _spec(imported)
            if spec is not None and spec.origin and _counts(imported, Path(spec.origin)):
                _add(imported, Path(spec.origin), hashes)


def _numerical(source: bytes) -> bytes:
    """Return the text of a study file without what cannot change a number of a case.

    These are its docstring, and each definition in ``NOT_NUMBERS`` that nothing else in the file names.
    """
    tree = ast.parse(source)
    lines: list[bytes | None] = list(source.splitlines(keepends=True))
    for node in tree.body:
        names = {getattr(node, "name", "")}
        if isinstance(node, ast.Assign):
            names = {getattr(target, "id", "") for target in node.targets}
        is_docstring = node is tree.body[0] and ast.get_docstring(tree) is not None
        if is_docstring or (
            names <= NOT_NUMBERS and not any(_is_named(n, node, tree) for n in names)
        ):
            decorated = getattr(node, "decorator_list", [])
            first = min(part.lineno for part in (node, *decorated))
            lines[first - 1 : node.end_lineno] = [None] * ((node.end_lineno or first) - first + 1)
    return b"".join(line for line in lines if line is not None)


def _is_named(name: str, definition: ast.stmt, tree: ast.Module) -> bool:
    """Return whether anything in `tree` outside `definition` uses `name`, or shares a line with the definition."""
    for node in tree.body:
        if node is definition:
            continue
        if (
            node.lineno <= (definition.end_lineno or 0)
            and (node.end_lineno or 0) >= definition.lineno
        ):
            return True
        for part in ast.walk(node):
            words = (getattr(part, word, None) for word in ("id", "attr", "value"))
            if any(isinstance(word, str) and word == name for word in words):
                return True
    return False


def _constants(module: ModuleType | None) -> str:
    """Return the numbers and texts among the values of a module."""
    if module is None or module.__name__.startswith("studies."):
        return ""
    constants = {}
    for name, value in sorted(vars(module).items()):
        if not name.startswith("__") and name not in NOT_NUMBERS and isinstance(value, CONSTANT):
            with suppress(InvalidInput):
                constants[name] = canonical(value)
    return text(constants)


@cache
def _imports(source: bytes, package: str) -> tuple[str, ...]:
    """Return the names of all modules that the code `source` of a module in `package` may import, parents first."""
    modules: list[str] = []
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Import():
                names = [alias.name for alias in node.names]
            case ast.ImportFrom():
                base = "." * node.level + (node.module or "")
                with suppress(ImportError):
                    base = importlib.util.resolve_name(base, package)
                names = [f"{base}.{alias.name}" for alias in node.names]
            case ast.Call(func=ast.Attribute(attr="import_module") | ast.Name(id="import_module" | "__import__"),
                          args=[ast.Constant(value=str(name)), *_]):  # fmt: skip
                names = [name]
            case _:
                continue
        for name in names:
            parts = name.split(".")
            modules += (".".join(parts[: k + 1]) for k in range(len(parts)))
    return tuple(dict.fromkeys(modules))


def _spec(name: str) -> ModuleSpec | None:
    """Return the specification of a module without importing it; None if it is not found."""
    parent, _, _ = name.rpartition(".")
    with suppress(ImportError, ValueError):
        if not parent:
            return importlib.util.find_spec(name)
        folder = _spec(parent)
        if folder is not None and folder.submodule_search_locations is not None:
            return PathFinder.find_spec(name, folder.submodule_search_locations)
    return None


def _counts(name: str, file: Path) -> bool:
    """Return whether the hash of a module counts: it is neither installed nor covered by the versions."""
    package, _, subpackages = name.partition(".")
    if package == "contactstudy" or (
        package == "studies" and subpackages.split(".")[0] not in NUMERICAL
    ):
        return False
    standard = sysconfig.get_paths()["stdlib"]
    is_installed = any(part in INSTALLED for part in file.parts) or str(file).startswith(standard)
    return not is_installed and file.is_file()


def _hash(*parts: str | bytes) -> str:
    """Return twelve digits of a hash of several texts."""
    digest = hashlib.sha256()
    for part in parts:
        raw = part.encode() if isinstance(part, str) else part
        digest.update(len(raw).to_bytes(8) + raw)
    return digest.hexdigest()[:12]

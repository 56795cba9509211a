"""Version of this program, with a hash of its code, and what it imports on first use.

A package that only some features need is imported when such a feature is used, and an error names the feature and the
command that installs the package.
"""

import ast
import hashlib
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

VERSION = "0.1.0"
# Instant at which the first module of this program was loaded [s since the epoch]. A file that is newer is not the code
# that runs.
LOADED = time.time()
# Folders and modules of the core that cannot change a number of a solution: they read, write, show and plan.
NOT_NUMERICAL = ("io", "planning", "forecast.py")


@cache
def source_hash(core: Path = Path(__file__).parents[1]) -> str:
    """Return a hash of the modules in the folder ``core``, by default this package, that can change a number."""
    digest = hashlib.sha256()
    for path in sorted(core.rglob("*.py")):
        name = path.relative_to(core)
        if name.parts[0] not in NOT_NUMERICAL:
            source = path.read_bytes()
            digest.update(f"{name} {len(source)} ".encode() + source)
    return digest.hexdigest()[:12]


# Packages of this program, of which no module can be missing.
OWN_PACKAGES = ("contactstudy", "studies")
# What pip is asked for, where it differs from the name of the package.
INSTALLS = {
    "SurfaceTopography": "'contactstudy[measured]'",
    "click": "contactstudy",  # the command needs more than this one
    "distributed": "'contactstudy[cluster]'",
    "pyevtk": "'contactstudy[vtk]'",
    "tomli_w": "tomli-w",
}


class MissingPackageError(ModuleNotFoundError):
    """Error for a package that is not installed; the message names the feature that needs it and the remedy."""


def import_for(use: str, module: str) -> Any:
    """Return a module, imported for a `use`.

    Raises
    ------
    MissingPackageError
        If a package is not installed.
    """
    with needed_for(use):
        return import_module(module)


def loaded() -> int:
    """Return how many modules are imported, loops compiled and tables of free faces made in this process.

    Where the number has grown during a solve, its time is longer than that of the same solve again.
    """
    compiled: Any = sys.modules.get("contactstudy.domain.loops.compiled")
    loops = () if compiled is None else compiled.LOOPS
    faces: Any = sys.modules.get("contactstudy.elasticity.free_faces")
    tables = 0 if faces is None else faces.face_table.cache_info().misses
    return len(sys.modules) + sum(len(loop.overloads) for loop in loops) + tables


@contextmanager
def needed_for(use: str) -> Iterator[None]:
    """Name the `use` in the error for a package that an import in this context lacks."""
    try:
        yield
    except ModuleNotFoundError as missing:
        raise missing_package(use, missing) from missing


def missing_package(use: str, missing: ModuleNotFoundError) -> ModuleNotFoundError:
    """Return the error `missing` with a message that names the `use`.

    An error about a module of this program, or one that has such a message, is returned unchanged.
    """
    package = (missing.name or "").partition(".")[0]
    if package in ("", *OWN_PACKAGES) or isinstance(missing, MissingPackageError):
        return missing
    install = INSTALLS.get(package, package)
    return MissingPackageError(
        f"{use} needs {package}, which is not installed: pip install {install}.", name=missing.name
    )


def names_on_first_use(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a `package` whose names are imported on first use.

    The names are those that the stub beside its `file` imports; a module of the package itself may be one of them.
    """
    stub = ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))
    places: dict[str, tuple[str, str]] = {}
    for statement in stub.body:
        if isinstance(statement, ast.ImportFrom):
            parts = (package if statement.level else "", statement.module or "")
            module = ".".join(filter(None, parts))
            places |= {alias.name: (module, alias.name) for alias in statement.names}

    def find(name: str) -> Any:
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        use, (module, attribute) = f"{package}.{name}", places[name]
        source = import_for(use, use if module == package else module)
        value = source if module == package else getattr(source, attribute)
        setattr(sys.modules[package], name, value)
        return value

    names = sorted(places)
    return find, names.copy, names

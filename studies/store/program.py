"""The program that computes a case: what must be equal for a stored case to be used again.

A stored case is used again if its fields, its study's measures, every numerical source file of the program, the user's
modules that the study imports, the files that it depends on, and the versions of Python and of the libraries that
compute are the same.
"""

import os
import platform
import re
import site
import sys
import sysconfig
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path
from types import ModuleType
from typing import Any

import cloudpickle

from contactstudy import InvalidInput
from contactstudy.domain.identity import Memo, digest, hashed
from contactstudy.domain.version import LOADED
from studies.model.study import Study

ROOT, PACKAGES = Path(__file__).parents[2], ("contactstudy", "studies")
FOLDERS = tuple(f"{package}/" for package in PACKAGES)
# folders of this program that show numbers and change none
NOT_NUMERICAL = ("studies/cli/", "studies/report/", "contactstudy/io/pictures/")
# distributions that compute; those that are missing do not count
LIBRARIES = (
    "numpy", "scipy", "ducc0", "numba", "cupy-cuda12x", "SurfaceTopography", "ContactMechanics", "aspher", "tamaas",
)  # fmt: skip
# folders of Python and of distributions
INSTALLED = tuple(
    os.path.join(folder, "")  # noqa: PTH118
    for folder in {
        *(sysconfig.get_paths()[name] for name in ("stdlib", "platstdlib", "purelib", "platlib")),
        *site.getsitepackages(), site.getusersitepackages(),
    }
)  # fmt: skip
IMPORT = re.compile(
    rb"(?:^|[;:])[ \t]*(?:from[ \t]+([.\w]+)[ \t]+import\b[ \t]*(\([^)]*\)|[^#;\n]*)|import[ \t]+([^#;\n]+))",
    re.MULTILINE,
)
WORD = re.compile(rb"\w+")
# words of a source that may import any module
AT_RUN_TIME = re.compile(
    rb"\b(?:import_module|__import__|spec_from_file_location|pkgutil|runpy|exec)\b"
)
UNREADABLE, MEASURES = "cannot be read", "the study's measures"

Digests = Mapping[str, str]  # of files and versions, by their names
Stat = tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Program:
    """The program of a study.

    Parameters
    ----------
    digests
        Digests of source files and of files that the study depends on, and versions, by their names.
    paths
        Paths of the files that the study depends on, by their names.
    """

    digests: Digests
    paths: Mapping[str, Path]

    @classmethod
    def of(cls, study: Study, case: object, memo: Memo) -> "Program":
        """Return the program of a study, of which one `case` is given, and a memo of the digests of all.

        Raises
        ------
        InvalidInput
            For a file that cannot be read, that changed since it was loaded, and measures whose state cannot be seen.
        """
        about = {MEASURES: digest(study.measures, memo)}
        held = (study.case_at, case, *(of for of, _ in memo.values()))
        named = {getattr(of, "__module__", "") for of in held}
        modules = {name: vars(sys.modules[name]) for name in named if name in sys.modules}
        users = {name: module for name, module in modules.items() if _is_users(name, module)}
        sources = {name: of["__source__"] for name, of in users.items() if "__source__" in of}
        for name, module in users.items():
            if name in sources:  # a study file, whose bytes were read once, and are sent to workers
                about[Path(module["__file__"]).name] = hashed(sources[name])
            elif "__file__" not in module:
                # typed at a prompt or in a notebook: known in this session alone
                kinds = {of for of in held if isinstance(of, type) and of.__module__ == name}
                kinds_by_name = sorted(kinds, key=lambda of: of.__qualname__)
                about["typed code"] = hashed(_pickled((study.measures, kinds_by_name)))
        if users:
            look()
            files = _imported(users, sources)
            about |= {name: content(path) for name, path in files.items()}
            _refuse([name for name in files if _LOADED.get(name, about[name]) != about[name]])
            texts = [*sources.values(), *(_bytes(path) or b"" for path in files.values())]
            names = [name for text in texts for name in imported_names(text)]
            about |= _versions_imported(names, files)
        loaded = modules.get(getattr(study.case_at, "__module__", ""), {}).get("__depends__", {})
        paths = {name: study.folder / name for name in study.depends}
        about |= {name: content(path) for name, path in paths.items()}
        for name in paths:
            if about[name] == UNREADABLE:
                raise InvalidInput(
                    f"Study {study.name!r} depends on the file {name!r}, which cannot be read: correct 'depends'."
                )
        _refuse([name for name in paths if loaded.get(name, about[name]) != about[name]])
        _refuse([name for name, path in _own_files().items() if _is_newer(path, LOADED)])
        return cls({**own_digests(), **about}, paths)

    @cached_property
    def key(self) -> str:
        """Digest of all of it."""
        return digest(sorted(self.digests.items()))

    def check(self, where: str = "") -> None:
        """Raise InvalidInput if the program in this process, `where` it is said to be, is not this one.

        Its files are looked at as they are now, and whether they changed since they were loaded. A library that is
        missing here counts.
        """
        files = user_files() if self._has_users else {}
        if unknown := sorted(files.keys() - self.digests.keys() - _LOADED.keys()):
            raise InvalidInput(
                f"{_listed(unknown)} was imported while a case was computed: import it at the top of the study's file."
            )
        files = {name: path for name, path in files.items() if name in self.digests}
        now = {
            name: _content_now(of) for name, of in ({**_own_files(), **files, **self.paths}).items()
        }
        now = {**own_digests(), **now}
        own = set(filter(_is_own, self.digests))
        stale = {name for name, path in _own_files().items() if _is_newer(path, LOADED)}
        differing = sorted(
            {name for name in own | now.keys() if now.get(name) != self.digests.get(name)} | stale
        )
        if differing:
            what = f"{_listed(differing)} changed since the run was started"
            remedy = "start it again"
            if where:
                what = f"{_listed(differing)} on {where} is not what the run was started with"
                remedy = "install the same there, and start the run again"
            raise InvalidInput(f"{what}: what was computed with it is not stored; {remedy}.")

    @cached_property
    def _has_users(self) -> bool:
        """True if modules of the user's count."""
        return any(not _is_own(name) for name in self.digests if name != MEASURES)


def _is_own(name: str) -> bool:
    """Return whether a name of a digest is that of this program's source, of Python or of a library that computes."""
    return name == "Python" or name in LIBRARIES or name.startswith(FOLDERS)


def _refuse(changed: list[str]) -> None:
    """Raise InvalidInput if files have changed since they were loaded."""
    if changed:
        raise InvalidInput(
            f"{_listed(changed)} changed since this program loaded it: start the program again, so that nothing of two "
            "versions is mixed."
        )


def differences(before: Digests, now: Digests) -> str:
    """Return in words in which files and versions two programs differ."""
    names = [name for name in before.keys() | now.keys() if before.get(name) != now.get(name)]
    texts = {
        name: f"{name} {before[name]} -> {now.get(name, 'none')}"
        for name in names
        if "." in before.get(name, "")
    }  # versions
    return _listed([texts.get(name, name) for name in sorted(names)])


def _listed(names: list[str]) -> str:
    """Return the first four names, and the number of others, in words."""
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


@cache
def own_digests() -> Digests:
    """Return the digests of this program's files, and the versions of Python and of the libraries that compute."""
    found = {"Python": platform.python_version()}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return {**{name: _content_now(path) for name, path in _own_files().items()}, **found}


@cache
def _own_files() -> Mapping[str, Path]:
    """Return the source files of this program that can change a number."""
    paths = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
    named = {path.relative_to(ROOT).as_posix(): path for path in paths}
    return {name: path for name, path in named.items() if not name.startswith(NOT_NUMERICAL)}


def user_files() -> dict[str, Path]:
    """Return the files of loaded modules that are the user's: not of this program, of Python or of a distribution.

    A study file is none of them, because it is sent to workers as it was read.
    """
    modules = ((name, vars(of)) for name, of in list(sys.modules.items()) if type(of) is ModuleType)
    return {
        name: Path(module["__file__"])
        for name, module in modules
        if module.get("__file__") and "__source__" not in module and _is_users(name, module)
        and name != "__mp_main__"
    }  # fmt: skip


def _is_users(name: str, module: Mapping[str, Any]) -> bool:
    """Return whether a module is the user's."""
    if name.partition(".")[0] in PACKAGES:
        return False
    file = module.get("__file__")
    return not str(file).startswith(INSTALLED) if file else name == "__main__"


def _imported(start: Iterable[str], sources: Mapping[str, bytes]) -> dict[str, Path]:
    """Return the files of the user's loaded modules that the modules of some names import, these included.

    `sources` are those of study files by the names of their modules. A name that is imported need not be a module.
    """
    loaded, found = user_files(), dict[str, Path]()
    queue = list(start)
    seen = set(queue)
    while queue:
        name = queue.pop()
        source = sources.get(name, b"")
        if name in loaded:
            found[name] = loaded[name]
            source = _bytes(loaded[name]) or b""
        named = set(imported_names(source, name, loaded.get(name)))
        if AT_RUN_TIME.search(source):
            named |= loaded.keys()
        queue += named - seen
        seen |= named
    return found


def imported_names(source: bytes, module: str = "", path: Path | None = None) -> Iterator[str]:
    """Yield the dotted names that a source imports, also in its functions, and those of the packages that they are in.

    Relative ones are those of the module with a name and a path.
    """
    package = module.split(".") if path and path.stem == "__init__" else module.split(".")[:-1]
    yield from _with_parents(module)
    for origin, names, modules in IMPORT.findall(source.replace(b"\\\n", b" ")):
        base = origin.decode().lstrip(".")
        if dots := len(origin) - len(base):
            base = ".".join([*package[: len(package) - dots + 1], *filter(None, [base])])
        several = [part.split()[0].decode() for part in modules.split(b",") if part.split()]
        for name in (*several, base, *(f"{base}.{part.decode()}" for part in WORD.findall(names))):
            yield from _with_parents(name)


def _with_parents(name: str) -> Iterator[str]:
    """Yield a dotted name and those of the packages that it is in."""
    parts = name.split(".")
    for end in range(1, len(parts) + 1):
        yield ".".join(parts[:end])


def _versions_imported(names: Iterable[str], files: Mapping[str, Path]) -> dict[str, str]:
    """Return the versions of the further distributions that have modules of some names."""
    known = {*sys.stdlib_module_names, *PACKAGES, "", *(name.partition(".")[0] for name in files)}
    named = {name.partition(".")[0] for name in names} - known
    return {of: version(of) for name in named for of in _distributions(name)}


@cache
def _distributions(module: str) -> list[str]:
    """Return the names of the distributions that have a module; most have one of their own name, which is quick."""
    with suppress(PackageNotFoundError):
        version(module)
        return [module]
    return list(packages_distributions().get(module, ()))


# digests of the user's modules as they were loaded, by name; empty where that is not certain
_LOADED: dict[str, str] = {}
_looked = LOADED


def look() -> None:
    """Note the digests of the user's modules that were loaded since the last look."""
    global _looked
    now = time.time()
    for name, path in user_files().items():
        if name not in _LOADED:
            _LOADED[name] = "" if _is_newer(path, _looked) else content(path)
    _looked = now


def _is_newer(path: Path, instant: float) -> bool:
    """Return whether a file has changed since an instant [s since the epoch]."""
    try:
        status = path.stat()
    except OSError:
        return True
    return max(status.st_mtime, status.st_ctime) > instant


def content(path: Path) -> str:
    """Return the digest of a file's content; of its archive, for a module in one."""
    source = _bytes(path)
    return hashed(source) if source is not None else UNREADABLE


_CONTENT: dict[Path, tuple[Stat, str]] = {}


def _content_now(path: Path) -> str:
    """Return the digest of a file's content, which is read again only if its size or its times have changed."""
    try:
        status = os.stat(path)  # noqa: PTH116 (twice as quick)
        stat = status.st_mtime_ns, status.st_ctime_ns, status.st_size
    except OSError:
        return content(path)
    if path not in _CONTENT or _CONTENT[path][0] != stat:
        _CONTENT[path] = stat, content(path)
    return _CONTENT[path][1]


def _bytes(path: Path) -> bytes | None:
    """Return the content of a file; of its archive, for a module in one; None where it cannot be read."""
    try:
        return next((of for of in (path, *path.parents) if of.is_file()), path).read_bytes()
    except (OSError, ValueError):
        return None


def _pickled(value: object) -> bytes:
    """Return a value pickled with all code that it names; nothing where it cannot be pickled."""
    try:
        return bytes(cloudpickle.dumps(value))
    except Exception:  # noqa: BLE001 (a user's own objects may do anything)
        return b""

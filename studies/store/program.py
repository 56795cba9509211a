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
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path
from types import ModuleType
from typing import Any

import cloudpickle

from contactstudy import InvalidInput
from contactstudy.domain.files import Memo, digest, hashed
from contactstudy.domain.imports import LOADED
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
# statements that import, whose words name modules
IMPORT = re.compile(r"(?:^|[;:])[ \t]*(?:from|import)\b[^\n(]*(?:\([^)]*\))?", re.MULTILINE)
# words of a source that may import any module
AT_RUN_TIME = re.compile(r"\b(?:import_module|__import__|spec_from_file_location|pkgutil|runpy|exec)\b")
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
        memo_key = (study.case_at, case, *(of for of, _ in memo.values()))
        named = {getattr(of, "__module__", "") for of in memo_key}
        modules = {name: vars(sys.modules[name]) for name in named if name in sys.modules}
        users = {name: module for name, module in modules.items() if _is_users(name, module)}
        sources = {name: of["__source__"] for name, of in users.items() if "__source__" in of}
        for name, module in users.items():
            if name in sources:  # a study file, whose bytes were read once, and are sent to workers
                about[Path(module["__file__"]).name] = hashed(sources[name])
            elif "__file__" not in module:
                # typed at a prompt or in a notebook: known in this session alone
                kinds = {of for of in memo_key if isinstance(of, type) and of.__module__ == name}
                kinds_by_name = sorted(kinds, key=lambda of: of.__qualname__)
                about["typed code"] = hashed(_pickled((study.measures, kinds_by_name)))
        if users:
            look()
            files, words = _imported(users, sources)
            about |= {name: content(path) for name, path in files.items()}
            _refuse([name for name in files if _LOADED.get(name, about[name]) != about[name]])
            about |= {of: version(of) for of in _distributions(words)}
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
        now = {name: content(of) for name, of in ({**_own_files(), **files, **self.paths}).items()}
        now = {**own_digests(), **now}
        own_modules = set(filter(_is_own, self.digests))
        stale = {name for name, path in _own_files().items() if _is_newer(path, LOADED)}
        differing = sorted(
            {name for name in own_modules | now.keys() if now.get(name) != self.digests.get(name)} | stale
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
        name: f"{name} {before[name]} -> {now.get(name, 'none')}" for name in names if "." in before.get(name, "")
    }  # with their versions before and now
    return _listed([texts.get(name, name) for name in sorted(names)])


def _listed(names: list[str]) -> str:
    """Return the first four names, and the number of others, in words."""
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


@cache
def own_digests() -> Digests:
    """Return the digests of this program's files, and the versions of Python and of the libraries that compute."""
    versions = {"Python": platform.python_version()}
    for name in LIBRARIES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            continue
    return {**{name: content(path) for name, path in _own_files().items()}, **versions}


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


def _imported(start: Iterable[str], sources: Mapping[str, bytes]) -> tuple[dict[str, Path], set[str]]:
    """Return the files of the user's loaded modules that those of some names import, these included; and all words.

    A module counts if a source that counts has all parts of its name in its statements that import, the words.
    `sources` are those of study files by the names of their modules.
    """
    loaded, files, words = user_files(), dict[str, Path](), set[str]()
    queue = list(start)
    other_modules = loaded.keys() - set(queue)
    while queue:
        name = queue.pop()
        files |= {name: loaded[name]} if name in loaded else {}
        source = sources.get(name) or (_bytes(loaded[name]) if name in loaded else None) or b""
        text = source.decode("utf-8", "replace")
        statements = " ".join(IMPORT.findall(text.replace("\\\n", " ")))
        names_used = set(re.findall(r"\w+", statements))
        words |= names_used
        if "from ." in statements:
            names_used |= set(name.split("."))
        is_any = AT_RUN_TIME.search(text)
        news = {
            of for of in other_modules if is_any or names_used.issuperset(of.split(".")) or name.startswith(f"{of}.")
        }
        queue += news
        other_modules -= news
    return files, words


def _distributions(words: Iterable[str]) -> set[str]:
    """Return the names of the other distributions that have a module called like one of the words."""
    modules = packages_distributions()
    return {of for name in {*words} & modules.keys() - {*PACKAGES} for of in modules[name]}


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


_CONTENT: dict[Path, tuple[Stat | None, str]] = {}


def content(path: Path) -> str:
    """Return the digest of a file's content, read again only if its size or its times have changed.

    For a module in an archive it is that of the archive.
    """
    try:
        status = os.stat(path)  # noqa: PTH116 (twice as quick)
        stat = status.st_mtime_ns, status.st_ctime_ns, status.st_size
    except OSError:
        stat = None
    if stat is None or _CONTENT.get(path, (None, ""))[0] != stat:
        source = _bytes(path)
        _CONTENT[path] = stat, UNREADABLE if source is None else hashed(source)
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

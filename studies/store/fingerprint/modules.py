"""Fingerprints of the modules that a process has imported, or would import now.

They are a digest of the source for a module of a user or of this program, a version for one of a distribution, and the
version of Python.
"""

import hashlib
import importlib
import os
import secrets
import site
import sys
import sysconfig
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any

CODE = (".py", ".pyc", ".pyd", ".so")
PYTHON = "{}.{}".format(*sys.version_info)
THIS_PROGRAM = ("contactstudy", "studies")
# distributions that send, run and show cases, and change no number
NO_EFFECT_ON_NUMBERS = frozenset((
    "charset_normalizer", "click", "cloudpickle", "dask", "distributed", "fsspec", "jinja2", "locket", "markupsafe",
    "msgpack", "packaging", "partd", "psutil", "pyyaml", "setuptools", "sortedcontainers", "tblib", "threadpoolctl",
    "toolz", "tornado", "tqdm", "zict",
))  # fmt: skip
REAL_PATH = cache(os.path.realpath)
CLOCK_MARGIN = 0.02  # seconds by which the clock of a file system may be late
# such as {"module studies.model.case": digest, "distribution numpy": version}
Fingerprints = Mapping[str, str]


@cache
def _site_folders() -> tuple[str, ...]:
    """Return the folders in which distributions are installed."""
    paths = sysconfig.get_paths()
    folders = [paths["purelib"], paths["platlib"], site.getusersitepackages()]
    return tuple(dict.fromkeys(map(os.path.realpath, [*folders, *site.getsitepackages()])))


@cache
def _installed() -> tuple[Mapping[str, str], Mapping[str, str]]:
    """Return the distribution of each installed file, and the version of each distribution.

    A distribution that did not come from an index has a digest of its code beside its version.
    """
    files: dict[str, str] = {}
    versions: dict[str, str] = {}
    for folder in _site_folders():
        for about in Path(folder).glob("*.dist-info"):
            name, _, version = about.stem.lower().partition("-")
            with suppress(OSError):
                rows = (about / "RECORD").read_text(encoding="utf-8").splitlines()
                code = [row for row in rows if row.partition(",")[0].strip('"').endswith(CODE)]
                if (about / "direct_url.json").exists():
                    version = f"{version} {digest(chr(10).join(sorted(code)).encode())}"
                versions.setdefault(name, version)
                for row in code:
                    path = f"{folder}/{row.partition(',')[0].strip(chr(34))}"
                    files[os.path.normpath(path) if ".." in path or os.sep != "/" else path] = name
    return files, versions


@cache
def _is_standard(folder: str) -> bool:
    """Return whether a folder is of the standard library, and no folder of distributions within."""
    paths = sysconfig.get_paths()
    standard = {os.path.realpath(paths[name]) for name in ("stdlib", "platstdlib")}
    path = Path(folder)
    parents = {str(path), *map(str, path.parents)}
    return bool(parents & standard) and not parents & set(_site_folders())


def digest(content: bytes) -> str:
    """Return 16 hexadecimal digits of the BLAKE2b hash of `content`."""
    return hashlib.blake2b(content, digest_size=8).hexdigest()


def fingerprint_of(name: str, spec: ModuleSpec) -> tuple[str, str] | None:
    """Return name and fingerprint of a module: a digest of its source, or the version of its distribution.

    None for a module of the standard library, of a distribution that changes no number, and without a known file.
    """
    origin = spec.origin if spec.has_location else None
    if origin is None:
        return (f"module {name}", "a folder") if spec.submodule_search_locations else None
    path = os.path.abspath(origin)  # noqa: PTH100 (a path object takes ten times as long)
    folder, file = os.path.split(path)
    folder = REAL_PATH(folder)
    files, versions = _installed()
    distribution = files.get(f"{folder}{os.sep}{file}", "")
    if distribution in NO_EFFECT_ON_NUMBERS or name.startswith("__editable__"):
        return None
    if distribution and distribution not in THIS_PROGRAM:
        return f"distribution {distribution}", versions[distribution]
    if not distribution and _is_standard(folder):
        return None
    get_data: Any = getattr(spec.loader, "get_data", None)
    try:
        content = get_data(origin) if get_data else Path(path).read_bytes()
    except OSError:
        return f"module {name}", "unreadable"
    return f"module {name}", digest(content)


def current_spec(name: str) -> ModuleSpec | None:
    """Return the specification of the module that an import of `name` would load now; nothing is imported."""
    parent, _, _ = name.rpartition(".")
    path: list[str] | None = None
    if parent:
        above = current_spec(parent)
        if above is None or above.submodule_search_locations is None:
            return None
        path = list(above.submodule_search_locations)
        loaded = _spec_of(sys.modules.get(parent))
        if loaded is not None and loaded.origin == above.origin:  # it may have added folders
            path += getattr(sys.modules[parent], "__path__", ())
    for finder in sys.meta_path:
        if finder is not RECORDER:
            with suppress(Exception):  # third-party finders may raise anything
                if spec := finder.find_spec(name, path, None):
                    return spec
    # one that was loaded by its path
    return _spec_of(sys.modules.get(name))


def variables_of(module: object) -> Mapping[str, Any]:
    """Return the variables of a module, without importing a lazy one; none of another object."""
    try:
        return object.__getattribute__(module, "__dict__")  # type: ignore[no-any-return]
    except AttributeError:
        return {}


def _spec_of(module: object) -> ModuleSpec | None:
    """Return the specification of a module."""
    spec = variables_of(module).get("__spec__")
    return spec if isinstance(spec, ModuleSpec) else None


class ImportRecorder:
    """Import hook that records the fingerprints of all that this process imports.

    It is the first finder of ``sys.meta_path``, finds nothing, and notes the source of each module before it is loaded.
    A module whose source has changed meanwhile, or may have, gets a fingerprint that matches nothing.

    Attributes
    ----------
    record
        Fingerprints at the last :meth:`scan`.
    started
        Time at which the process started [s since the epoch].
    """

    def __init__(self) -> None:
        self.record: Fingerprints = {"python": PYTHON}
        self._modules: dict[str, object] = {}
        self._noted: dict[str, tuple[str, str] | None] = {}
        self._seen: tuple[list[str], list[object]] = [], []
        # the interpreter itself takes longer than the margin before it loads anything of this program
        self.started = self._scanned = _process_start() + CLOCK_MARGIN
        self._busy = False

    def find_spec(self, name: str, path: Any, target: Any = None) -> None:
        """Note the source that is about to be loaded as `name`."""
        if self._busy:  # a third-party finder that calls all finders
            return
        self._busy = True
        try:
            for finder in sys.meta_path:
                if finder is not self and (spec := finder.find_spec(name, path, target)):
                    self._noted[name] = fingerprint_of(name, spec)
                    return
        finally:
            self._busy = False

    def scan(self) -> Fingerprints:
        """Return the record with what was loaded since the last scan."""
        current: tuple[list[str], list[object]] = list(sys.modules), list(sys.modules.values())
        modules, noted = self._modules, self._noted
        if current == self._seen and not noted:
            return self.record
        now, self._seen = time.time(), current
        changed = [
            (name, module)
            for name, module in list(sys.modules.items())
            if modules.get(name) is not module or name in noted
        ]
        entries = dict(self.record)
        for name, module in changed:
            modules[name] = module
            # a study file is identified by its syntax tree
            if name in ("__main__", "__mp_main__") or "__source__" in variables_of(module):
                noted.pop(name, None)
                continue
            self._add(name, _spec_of(module) or current_spec(name), entries)
        for entry in noted.values():  # deleted again
            if entry is not None:
                _add_fingerprint(*entry, entries)
        noted.clear()
        self._scanned = now
        if entries != self.record:
            self.record = entries
        return self.record

    def _add(self, name: str, spec: ModuleSpec | None, entries: dict[str, str]) -> None:
        """Add the entry of a module."""
        entry = None if spec is None else fingerprint_of(name, spec)
        is_noted = name in self._noted
        before = self._noted.pop(name, None)
        if entry is None or spec is None:
            return
        key, value = entry
        path = getattr(spec.loader, "archive", spec.origin)
        is_older_file = not spec.has_location or is_older(path, self._scanned)
        certain = entry == before if is_noted else is_older_file
        if not certain and key.startswith("module"):
            value = f"{value} or another {secrets.token_hex(4)}"
        _add_fingerprint(key, value, entries)


def is_older(path: Any, instant: float) -> bool:
    """Return whether a file was not changed since an instant [s since the epoch]."""
    try:
        status = os.stat(path)  # noqa: PTH116
    except (OSError, TypeError):
        return False
    return max(status.st_mtime, status.st_ctime) < instant - CLOCK_MARGIN


def _add_fingerprint(key: str, value: str, entries: dict[str, str]) -> None:
    """Add a fingerprint; two that differ become one that matches nothing, since both modules may be in use."""
    before = entries.get(key, value)
    entries[key] = value if value == before else f"{value} after {before}"


def _process_start() -> float:
    """Return the time at which this process started [s since the epoch]."""
    with suppress(OSError, AttributeError, IndexError):
        fields = Path("/proc/self/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        ticks = float(fields[19]) / os.sysconf("SC_CLK_TCK")
        return time.time() - time.clock_gettime(time.CLOCK_BOOTTIME) + ticks
    import psutil  # whose import takes 30 ms, and whose time on Linux is that to a second

    return float(psutil.Process().create_time())


RECORDER = ImportRecorder()
sys.meta_path.insert(0, RECORDER)


class CurrentModules:
    """Fingerprints of what an import would load now, each looked up once."""

    def __init__(self) -> None:
        importlib.invalidate_caches()
        self._entries: dict[str, str] = {"python": PYTHON}
        self._changes: dict[int, tuple[Fingerprints, list[str]]] = {}

    def changes(self, record: Fingerprints) -> list[str]:
        """Return the names of the fingerprints that differ from those of what would be loaded now."""
        if id(record) not in self._changes:
            changes = [key for key, value in record.items() if self._entry(key) != value]
            self._changes[id(record)] = record, changes
        return self._changes[id(record)][1]

    def _entry(self, key: str) -> str:
        """Return the fingerprint that a process would record under the name `key` now."""
        if key not in self._entries:
            kind, _, name = key.partition(" ")
            if kind == "distribution":
                present = _installed()[1].get(name, "absent")
            else:
                spec = current_spec(name)
                entry = None if spec is None else fingerprint_of(name, spec)
                present = "absent" if entry is None else entry[1] if entry[0] == key else entry[0]
            self._entries[key] = present
        return self._entries[key]


def listed(changes: Sequence[str]) -> str:
    """Return the names of changed modules and distributions in words: the first four, and the number of the others."""
    names = [change.removeprefix("module ") for change in changes[:4]]
    others_text = [f"and {len(changes) - 4} more"] if len(changes) > 4 else []
    return ", ".join(names + others_text)

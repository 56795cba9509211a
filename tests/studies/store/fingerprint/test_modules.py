import importlib
import os
import sys
import zipfile
from collections.abc import Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

from studies.store.fingerprint.modules import RECORDER, CurrentModules

NAMES = ("helper_of_study", "other_of_study", "package_of_study")


@pytest.fixture(autouse=True)
def _own_modules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(RECORDER, "record", {})
    forget()
    yield
    forget()


def forget() -> None:
    for name in list(sys.modules):
        if name.partition(".")[0] in NAMES:
            del sys.modules[name]


def loaded(name: str) -> dict[str, str]:
    """What is recorded when a module is imported, without what was there before."""
    importlib.invalidate_caches()
    importlib.import_module(name)
    return {
        key: value
        for key, value in RECORDER.scan().items()
        if key.partition(" ")[2].startswith(NAMES)
    }


def write(path: Path, text: str) -> None:
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8")


def changes(record: dict[str, str]) -> list[str]:
    return CurrentModules().changes(record)


HOW = {
    "plainly": "import other_of_study",
    "its names": "from other_of_study import *",
    "in a function": "def f():\n    import other_of_study\nf()",
    "by a computed name": "import importlib\nimportlib.import_module('other_' + 'of_study')",
    "and deleted": "import other_of_study, sys\ndel sys.modules['other_of_study']",
    "beside a package without a file, as six.moves is": "import other_of_study, sys\nfrom importlib.machinery "
    "import ModuleSpec\nfrom importlib.util import module_from_spec\nname = __name__ + '.moves'\n"
    "sys.modules[name] = module_from_spec(ModuleSpec(name, None, is_package=True))",
}


@pytest.mark.parametrize("how", HOW)
def test_a_module_counts_however_it_was_imported(how: str, tmp_path: Path) -> None:
    write(tmp_path / "other_of_study.py", "K = 1.0\n")
    write(tmp_path / "helper_of_study.py", HOW[how])
    record = loaded("helper_of_study")
    assert changes(record) == []
    write(tmp_path / "other_of_study.py", "K = 2.0\n")
    assert changes(record) == ["module other_of_study"]


def test_packages_folders_and_archives_count(tmp_path: Path) -> None:
    write(tmp_path / "package_of_study" / "part.py", "K = 1.0\n")
    record = loaded("package_of_study.part")
    assert changes(record) == []
    write(tmp_path / "package_of_study" / "__init__.py", "")
    assert changes(record) == ["module package_of_study"]
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("helper_of_study.py", "K = 1.0\n")
    sys.path.insert(0, str(tmp_path / "a.zip"))
    try:
        assert changes(loaded("helper_of_study")) == ["module package_of_study"]
    finally:
        sys.path.remove(str(tmp_path / "a.zip"))


def test_a_module_that_is_shadowed_moved_or_removed_is_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path / "helper_of_study.py", "K = 1.0\n")
    record = loaded("helper_of_study")
    write(tmp_path / "first" / "helper_of_study.py", "K = 1.0\n")
    monkeypatch.syspath_prepend(tmp_path / "first")
    assert changes(record) == []  # the same source at another place
    write(tmp_path / "first" / "helper_of_study.py", "K = 2.0\n")
    assert changes(record) == ["module helper_of_study"]
    (tmp_path / "first" / "helper_of_study.py").unlink()
    (tmp_path / "helper_of_study.py").unlink()
    forget()
    assert changes(record) == ["module helper_of_study"]


def test_an_edit_of_equal_size_and_time_is_seen(tmp_path: Path) -> None:
    path = tmp_path / "helper_of_study.py"
    write(path, "K = 1.0\n")
    times = path.stat()
    record = loaded("helper_of_study")
    write(path, "K = 2.0\n")
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    assert changes(record) == ["module helper_of_study"]


def test_what_was_edited_while_or_after_it_was_loaded_matches_nothing(tmp_path: Path) -> None:
    path = tmp_path / "helper_of_study.py"
    # it edits itself while it is loaded
    write(path, "from pathlib import Path\nPath(__file__).write_text('K = 2.0')\nK = 1.0\n")
    assert changes(loaded("helper_of_study")) == ["module helper_of_study"]
    forget()
    # what a module has taken from the former one may still be in use
    assert changes(loaded("helper_of_study")) == ["module helper_of_study"]
    write(tmp_path / "other_of_study.py", "K = 1.0\n")
    assert "module other_of_study" not in changes(loaded("other_of_study"))
    write(tmp_path / "other_of_study.py", "K = 2.0\n")
    importlib.reload(sys.modules["other_of_study"])
    assert "module other_of_study" in changes(loaded("other_of_study"))


def test_a_module_that_was_loaded_by_its_path_is_known_by_it(tmp_path: Path) -> None:
    path = tmp_path / "elsewhere" / "any.py"
    write(path, "K = 1.0\n")
    spec = spec_from_file_location("helper_of_study", path)
    os.utime(path, (1e9, 1e9))
    module = module_from_spec(spec)
    sys.modules["helper_of_study"] = module
    spec.loader.exec_module(module)
    record = RECORDER.scan()
    write(path, "K = 2.0\n")
    assert "module helper_of_study" in CurrentModules().changes(record)


def test_distributions_count_by_version_and_the_standard_library_by_that_of_python() -> None:
    RECORDER._modules.clear()
    record = RECORDER.scan()
    assert record["distribution numpy"] == importlib.import_module("numpy").__version__
    assert record["module studies.store.fingerprint.modules"]
    names = {key.partition(" ")[2].partition(".")[0] for key in record}
    assert not names & {"json", "os", "numpy.linalg", "dask", "cloudpickle"}
    assert changes({"distribution numpy": "1.0", "python": "2.7"}) == [
        "distribution numpy",
        "python",
    ]


def test_a_file_in_a_folder_called_like_that_of_distributions_counts_by_its_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path / "site-packages" / "helper_of_study.py", "K = 1.0\n")
    monkeypatch.syspath_prepend(tmp_path / "site-packages")
    assert list(loaded("helper_of_study")) == ["module helper_of_study"]

"""Which edits make stored numbers be computed anew: all that may change one, no figure, axis or title."""

import re
import shutil
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import pytest

import contactstudy
from contactstudy import InvalidInput
from contactstudy.domain.version import source_hash
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.registry import load
from studies.store.fingerprint import agree
from studies.store.request import Request
from tests.studies.conftest import quiet

HEAD = '''"""A study."""

from dataclasses import dataclass
from functools import lru_cache, partial, wraps
from types import SimpleNamespace

import numpy as np

from studies import Axis

points = (Axis("a", (1, 2, 3), "a"),)
times = "none"


@dataclass(frozen=True)
class Thing:
    a: int

    def prepare(self):
        return self.a

    def run(self, prepared):
        return prepared + 1

    def record(self, result):
        return {}


def scene_at(point):
    return Thing(point["a"])


def figure(dataset):
    return ()


'''
# what a study file measures, before and after an edit, or the helper that it imports
MEASURES = "def measures(case, r): return {'s': f(r)}\n"
EDITS = {
    "swapped constants": (
        "A=2.0\nB=3.0\ndef f(r): return A*r-B\n",
        "A=3.0\nB=2.0\ndef f(r): return A*r-B\n",
    ),
    "default argument": ("K=1.0\ndef f(r,k=K): return k*r\n", "K=2.0\ndef f(r,k=K): return k*r\n"),
    "closure": (
        "def make(k):\n    return lambda r: k*r\nf=make(1.0)\n",
        "def make(k):\n    return lambda r: k*r\nf=make(2.0)\n",
    ),
    "partial": (
        "def g(r,k): return k*r\nf=partial(g,k=1.0)\n",
        "def g(r,k): return k*r\nf=partial(g,k=2.0)\n",
    ),
    "table of functions": (
        "T=[lambda r: 1.0*r]\ndef f(r): return T[0](r)\n",
        "T=[lambda r: 2.0*r]\ndef f(r): return T[0](r)\n",
    ),
    "plain object": (
        "class M:\n    def __call__(s,r): return 1.0*r\nf=M()\n",
        "class M:\n    def __call__(s,r): return 2.0*r\nf=M()\n",
    ),
    "decorator": (
        "def d(g):\n    @wraps(g)\n    def w(r): return 1.0*g(r)\n    return w\n@d\ndef f(r): return r\n",
        "def d(g):\n    @wraps(g)\n    def w(r): return 2.0*g(r)\n    return w\n@d\ndef f(r): return r\n",
    ),
    "thirteenth digit": (
        "K=1.0\ndef f(r): return K*r\n",
        "K=1.00000000000002\ndef f(r): return K*r\n",
    ),
    "number or text": (
        "K=2\ndef f(r): return len(str(K))\n",
        "K='2'\ndef f(r): return len(str(K))\n",
    ),
    "nested class": (
        "class C:\n    class D:\n        K=1.0\ndef f(r): return C.D.K*r\n",
        "class C:\n    class D:\n        K=2.0\ndef f(r): return C.D.K*r\n",
    ),
    "namespace": (
        "N=SimpleNamespace(k=1.0)\ndef f(r): return N.k*r\n",
        "N=SimpleNamespace(k=2.0)\ndef f(r): return N.k*r\n",
    ),
    "library object": (
        "P=np.poly1d([1.0,0])\ndef f(r): return P(r)\n",
        "P=np.poly1d([2.0,0])\ndef f(r): return P(r)\n",
    ),
    "figure that is measured": (
        "def f(r): return r+len(figure(None))\n",
        "def f(r): return r-len(figure(None))\n",
    ),
}
IMPORTS = {
    "at the top": ("from helper_of_study import f\n", "helper_of_study.py"),
    "inside": (
        "def f(r):\n    import helper_of_study\n    return helper_of_study.f(r)\n",
        "helper_of_study.py",
    ),
    "in a package": (
        "def f(r):\n    import package_of_study.part\n    return package_of_study.part.f(r)\n",
        "package_of_study/part.py",
    ),
    "from a package": (
        "def f(r):\n    from package_of_study import part\n    return part.f(r)\n",
        "package_of_study/part.py",
    ),
    "by name": (
        "def f(r):\n    from importlib import import_module\n    return import_module('helper_of_study').f(r)\n",
        "helper_of_study.py",
    ),
    "by another": (
        "def f(r):\n    import first_of_study\n    return first_of_study.f(r)\n",
        "helper_of_study.py",
    ),
}


@pytest.fixture(autouse=True)
def _own_modules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("helper_of_study", "package_of_study", "package_of_study.part"):
        monkeypatch.delitem(sys.modules, name, raising=False)


def context(path: Path, text: str) -> Mapping[str, str]:
    path.write_text(text, encoding="utf-8")
    return Request.of(load(str(path))).context


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_of_what_makes_the_numbers_is_noticed(edit: str, tmp_path: Path) -> None:
    before, after = (context(tmp_path / "one.py", HEAD + text + MEASURES) for text in EDITS[edit])
    assert not agree(before, after)


@pytest.mark.parametrize("how", IMPORTS)
def test_an_edit_of_a_module_is_noticed_wherever_it_is_imported(how: str, tmp_path: Path) -> None:
    use, file = IMPORTS[how]
    (tmp_path / "package_of_study").mkdir()
    (tmp_path / "package_of_study" / "__init__.py").touch()
    (tmp_path / "first_of_study.py").write_text("from helper_of_study import f\n")
    (tmp_path / "helper_of_study.py").touch()
    contexts = []
    for factor in (1.0, 2.0):
        (tmp_path / file).write_text(f"def f(r): return {factor} * r\n")
        contexts.append(context(tmp_path / "one.py", HEAD + use + MEASURES))
    assert not agree(*contexts)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("return ()", "shown = 1\n    return (shown,)"),
        ("(1, 2, 3)", "(1, 2, 3, 4)"),
        ('times = "none"', 'times = "taken"'),
        ("A study.", "A study, otherwise called."),
    ],
)
def test_an_edit_of_figures_axes_and_title_is_none(old: str, new: str, tmp_path: Path) -> None:
    text = f"{HEAD}def f(r): return r\n{MEASURES}"
    assert old in text
    before = context(tmp_path / "one.py", text)
    assert agree(before, context(tmp_path / "one.py", text.replace(old, new)))


def test_a_constant_counts_by_its_value_wherever_it_comes_from(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = f"{HEAD}import os\nK = float(os.environ['OF_STUDY'])\ndef f(r): return K * r\n{MEASURES}"
    contexts = []
    for value in ("1.0", "2.0"):
        monkeypatch.setenv("OF_STUDY", value)
        contexts.append(context(tmp_path / "one.py", text))
    assert not agree(*contexts)


def test_another_function_of_the_same_module_counts(tmp_path: Path) -> None:
    text = f"{HEAD}def f(r): return r\n{MEASURES}def other(case, r): return {{'s': -r}}\n"
    path = tmp_path / "one.py"
    path.write_text(text)
    study = load(str(path))
    module = sys.modules[study.measures.__module__]
    other = replace(study, measures=module.other)
    assert not agree(Request.of(study).context, Request.of(other).context)

    def made(factor: float) -> Callable[[object, float], dict[str, float]]:
        return lambda case, result: {"s": factor * result}

    one, two = (Request.of(replace(study, measures=made(k))).context for k in (1.0, 2.0))
    assert not agree(one, two)


def test_files_that_a_study_names_count(tmp_path: Path) -> None:
    text = f"{HEAD}files = ('data.json',)\ndef f(r): return r\n{MEASURES}"
    contexts = []
    for content in ("1", "2"):
        (tmp_path / "data.json").write_text(content)
        contexts.append(context(tmp_path / "one.py", text))
    assert not agree(*contexts)
    (tmp_path / "data.json").unlink()
    with pytest.raises(InvalidInput, match=r"names the file 'data.json', which cannot be read"):
        context(tmp_path / "one.py", text)


def test_what_was_read_counts_and_not_what_the_file_has_become(tmp_path: Path) -> None:
    path = tmp_path / "one.py"
    text = f"{HEAD}def f(r): return r\n{MEASURES}"
    path.write_text(text)
    study = load(str(path))
    path.write_text(text.replace("return r\n", "return 2 * r\n"))
    assert agree(Request.of(study).context, Request.of(study).context)
    assert not agree(Request.of(study).context, Request.of(load(str(path))).context)


def test_another_class_at_a_new_value_computes_nothing_anew(tmp_path: Path) -> None:
    (tmp_path / "helper_of_study.py").write_text(
        "from one_of_study import Thing\nclass Other(Thing): pass\n"
    )
    text = f"{HEAD}def f(r): return r\n{MEASURES}"
    path = tmp_path / "one_of_study.py"
    path.write_text(text)
    study = load(str(path))
    options = RunOptions(workers=0)
    run(study, tmp_path / "out", options=options, log=quiet)
    from helper_of_study import Other  # type: ignore[import-not-found]

    said: list[str] = []
    grown = replace(
        study.override({"a": [1, 2, 3, 4]}),
        scene_at=lambda point: Other(4) if point["a"] == 4 else study.scene_at(point),
    )
    run(grown, tmp_path / "out", options=options, log=said.append)
    assert any("3 cases are stored, 1 to compute" in line for line in said)


def test_a_fingerprint_has_the_twelve_digits_that_stored_cases_go_by(tmp_path: Path) -> None:
    (tmp_path / "kernel.py").write_text("A = 1", encoding="utf-8")
    assert re.fullmatch("[0-9a-f]{12}", source_hash(tmp_path))
    # of this program's core and of no other folder, unless one is given
    assert source_hash() == source_hash(Path(contactstudy.__file__).parent)


@pytest.mark.parametrize(
    ("path", "effect"),
    [("analytic.py", "other"), ("domain/grid.py", "other"), ("io/dataset.py", "same"), ("planning/plan.py", "same")],
)  # fmt: skip
def test_only_core_code_that_can_change_a_number_counts(
    path: str, effect: str, tmp_path: Path
) -> None:
    core = tmp_path / "core"
    shutil.copytree(Path(contactstudy.__file__).parent, core)
    before = source_hash(core)
    source_hash.cache_clear()
    with (core / path).open("a", encoding="utf-8") as file:
        file.write("EXTRA = 1\n")
    assert ("same" if source_hash(core) == before else "other") == effect

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from contactstudy import InvalidInput
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.registry import load
from studies.store.request import Request
from tests.studies.conftest import quiet

HEAD = '''"""A study."""

from dataclasses import dataclass
from functools import lru_cache, partial, wraps
from types import SimpleNamespace

import numpy as np

from studies import Axis

axes = (Axis("a", (1, 2, 3), "a"),)
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


def case_at(point):
    return Thing(point["a"])


def figure(dataset):
    return ()


'''
# what a study file measures: its text, and what an edit puts in the place of what
MEASURES = "def measures(case, r): return {'s': f(r)}\n"
EDITS = {
    "swapped constants": ("A=2.0\nB=3.0\ndef f(r): return A*r-B\n", "2.0\nB=3", "3.0\nB=2"),
    "default argument": ("K=1.0\ndef f(r,k=K): return k*r\n", "1", "2"),
    "closure": ("def make(k):\n    return lambda r: k*r\nf=make(1.0)\n", "1", "2"),
    "partial": ("def g(r,k): return k*r\nf=partial(g,k=1.0)\n", "1", "2"),
    "table of functions": ("T=[lambda r: 1.0*r]\ndef f(r): return T[0](r)\n", "1", "2"),
    "plain object": ("class M:\n    def __call__(s,r): return 1.0*r\nf=M()\n", "1", "2"),
    "decorator": (
        "def d(g):\n    @wraps(g)\n    def w(r): return 1.0*g(r)\n    return w\n@d\ndef f(r): return r\n", "1", "2",
    ),
    "thirteenth digit": ("K=1.0\ndef f(r): return K*r\n", "0", "00000000000002"),
    "number or text": ("K=2\ndef f(r): return len(str(K))\n", "2", "'2'"),
    "nested class": ("class C:\n    class D:\n        K=1.0\ndef f(r): return C.D.K*r\n", "1", "2"),
    "namespace": ("N=SimpleNamespace(k=1.0)\ndef f(r): return N.k*r\n", "1", "2"),
    "library object": ("P=np.poly1d([1.0,0])\ndef f(r): return P(r)\n", "[1", "[2"),
    "figure that is measured": ("def f(r): return r+len(figure(None))\n", "+", "-"),
    "decorator argument": (
        "def d(k):\n    return lambda g: lambda r: k*g(r)\n@d(1.0)\ndef f(r): return r\n", "1", "2",
    ),
    "axes bound by an expression": ("other = [T := (1.0, 2.0)]\ndef f(r): return len(T)*r\n", "2", "2.0, 3"),
    "name that is put together": (
        "values = (1.0, 2.0)\ndef f(r): return len(globals()['val'+'ues'])*r\n", "2", "2.0, 3",
    ),
    "default with an effect": (
        "K={}\ndef f(r): return K['k']*r\ndef tables(d, _=K.update(k=1.0)): return ()\n", "1", "2",
    ),
    "function called like one of Python's": (
        "K=[]\ndef range(n): K.append(n)\nshown = range(1)\ndef f(r): return K[0]*r\n", "1", "2",
    ),
}  # fmt: skip
KEPT = {
    "figure": ("return ()", "shown = 1\n    return (shown,)"),
    "axis": ("(1, 2, 3)", "(1, 2, 3, 4)"),
    "times": ('times = "none"', 'times = "taken"'),
    "title": ("A study.", "A study, otherwise called."),
    "comment": ("times =", "# a comment\ntimes ="),
    "layout": ('return Thing(point["a"])', 'return Thing(\n        point["a"],\n    )'),
    "documentation": ("def case_at(point):", 'def case_at(point):\n    """The case."""'),
    "constant of a figure": ("def figure(", "WIDTH = 5.0\n\n\ndef figure("),
    "helper of a figure": ("def figure(", "def shown(x):\n    return 2 * x\n\n\ndef figure("),
}


def part(path: Path, text: str) -> Mapping[str, str]:
    path.write_text(text, encoding="utf-8")
    return Request.of(load(str(path))).context.part


@pytest.mark.cases(100)
@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_of_what_makes_the_numbers_is_noticed(edit: str, tmp_path: Path) -> None:
    text, old, new = EDITS[edit]
    assert old in text
    edited = text, text.replace(old, new)
    before, after = (part(tmp_path / "one.py", HEAD + one + MEASURES) for one in edited)
    assert before != after


@pytest.mark.cases(100)
@pytest.mark.parametrize("edit", KEPT)
def test_an_edit_of_what_only_people_see_is_none(edit: str, tmp_path: Path) -> None:
    text = f"{HEAD}def f(r): return r\n{MEASURES}"
    old, new = KEPT[edit]
    assert old in text
    before = part(tmp_path / "one.py", text)
    assert part(tmp_path / "one.py", text.replace(old, new)) == before
    assert part(tmp_path / "one.py", text.replace("\n", "\r\n")) == before


@pytest.mark.parametrize(
    "constant",
    [
        "float({})", "np.polynomial.Polynomial([float({})])", "{{'k': float({})}}", "np.array([float({})])",
        "Thing(float({}))", "SimpleNamespace(k=float({}))", "Plain(float({}))",
        "type('P', (), {{'k': Plain(float({}))}})",
    ],
)  # fmt: skip
def test_a_constant_counts_by_its_value_wherever_it_comes_from(
    constant: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = constant.format("os.environ['OF_STUDY']")
    plain = "class Plain:\n    def __init__(self, k): self.k = k\n"
    text = f"{HEAD}import os\n{plain}K = {made}\ndef f(r): return K\n{MEASURES}"
    parts = []
    for value in ("1.0", "2.0", "1.0"):
        monkeypatch.setenv("OF_STUDY", value)
        parts.append(part(tmp_path / "one.py", text))
    assert parts[0] == parts[2] != parts[1]


def test_a_file_that_a_study_depends_on_counts(tmp_path: Path) -> None:
    text = f"{HEAD}depends = ('data.json',)\ndef f(r): return r\n{MEASURES}"
    parts = []
    for content in ("1", "2"):
        (tmp_path / "data.json").write_text(content)
        parts.append(part(tmp_path / "one.py", text))
    assert parts[0] != parts[1]
    (tmp_path / "data.json").unlink()
    with pytest.raises(
        InvalidInput, match=r"depends on the file 'data.json', which cannot be read"
    ):
        part(tmp_path / "one.py", text)


def test_what_was_read_counts_and_not_what_the_file_has_become(tmp_path: Path) -> None:
    path = tmp_path / "one.py"
    text = f"{HEAD}def f(r): return r\n{MEASURES}"
    path.write_text(text)
    study = load(str(path))
    before = Request.of(study).context.part
    path.write_text(text.replace("return r\n", "return 2 * r\n"))
    assert Request.of(study).context.part == before
    assert Request.of(load(str(path))).context.part != before


def test_another_class_at_a_new_value_recomputes_nothing(tmp_path: Path) -> None:
    text = f"{HEAD}class Other(Thing): pass\ndef f(r): return r\n{MEASURES}"
    path = tmp_path / "one_of_study.py"
    path.write_text(text)
    study = load(str(path))
    options = RunOptions(workers=0)
    run(study, tmp_path / "out", options=options, log=quiet)
    other = study.measures.__globals__["Other"]  # type: ignore[attr-defined]
    said: list[str] = []
    grown = replace(
        study.override({"a": [1, 2, 3, 4]}),
        case_at=lambda point: other(4) if point["a"] == 4 else study.case_at(point),
    )
    run(grown, tmp_path / "out", options=options, log=said.append)
    assert any("3 cases are stored, 1 to compute" in line for line in said)

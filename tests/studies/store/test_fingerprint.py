import re
import shutil
import textwrap
from pathlib import Path

import pytest

import contactstudy
from studies.registry import load
from studies.store.fingerprint import measures_fingerprint, source_fingerprint

FILE = '''
"""A study."""

from dataclasses import dataclass

from studies.model.axis import Axis

points = (Axis("n", (1, 2), "n"),)
SCALE = 2.0


@dataclass(frozen=True)
class Thing:
    n: int

    def prepare(self):
        return self.n

    def run(self, prepared):
        return prepared + 1

    def record(self, result):
        return {}


def scene_at(point):
    return Thing(point["n"])


def helper(x):
    return SCALE * x


def measures(case, result):
    """Twice."""
    return {"twice": helper(result)}


def figure(dataset):
    return ()
'''


def fingerprint(path: Path, text: str) -> str:
    path.write_text(textwrap.dedent(text), encoding="utf-8")
    study = load(str(path))
    return measures_fingerprint(study.measures, frozenset(type(case) for case in study.cases()))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("helper(result)}", "helper(result) + 1}"),
        ("SCALE * x", "SCALE + x"),
        ("SCALE = 2.0", "SCALE = 3.0"),
        ("prepared + 1", "prepared + 2"),
        ("return self.n", "return -self.n"),
    ],
)
def test_a_change_of_what_makes_the_numbers_is_noticed(old: str, new: str, tmp_path: Path) -> None:
    before = fingerprint(tmp_path / "one.py", FILE)
    assert old in FILE
    assert fingerprint(tmp_path / "two.py", FILE.replace(old, new)) != before


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"""Twice."""', '"""Two times."""'),
        ("return ()", "return (1,)"),
        ("(1, 2)", "(1, 2, 3)"),
        ("    return SCALE * x", "    # as agreed\n    return SCALE * x"),
        ("    n: int", "    n: int\n    more: int = 0"),
    ],
)
def test_a_change_of_words_figures_and_axes_is_none(old: str, new: str, tmp_path: Path) -> None:
    before = fingerprint(tmp_path / "one.py", FILE)
    assert fingerprint(tmp_path / "two.py", FILE.replace(old, new)) == before


def test_a_fingerprint_has_the_twelve_digits_that_stored_cases_go_by(tmp_path: Path) -> None:
    (tmp_path / "kernel.py").write_text("A = 1", encoding="utf-8")
    digits = "[0-9a-f]{12}"
    assert re.fullmatch(digits, source_fingerprint(tmp_path))
    assert re.fullmatch(digits, measures_fingerprint(load("grid").measures, frozenset()))


def test_studies_measure_differently() -> None:
    found = {
        measures_fingerprint(load(name).measures, frozenset({type(load(name).cases()[0])}))
        for name in ("paper", "padding", "kernels", "speed")
    }
    assert len(found) == 4


@pytest.mark.parametrize(
    ("path", "old", "new", "effect"),
    [
        ("analytic.py", "\n\n", "\n\n# a remark\n", "same"),
        ("analytic.py", '"""', '"""Otherwise worded. ', "same"),
        ("analytic.py", "def ", "EXTRA = 1\n\n\ndef ", "other"),
        ("domain/padding.py", "def ", "EXTRA = 1\n\n\ndef ", "other"),
        ("io/dataset.py", "def ", "EXTRA = 1\n\n\ndef ", "same"),
        ("planning/plan.py", "def ", "EXTRA = 1\n\n\ndef ", "same"),
    ],
)
def test_only_core_code_that_can_change_a_number_counts(
    path: str, old: str, new: str, effect: str, tmp_path: Path
) -> None:
    core = tmp_path / "core"
    shutil.copytree(Path(contactstudy.__file__).parent, core)
    before = source_fingerprint(core)
    text = (core / path).read_text(encoding="utf-8")
    place = text.index(f"\n{old}") + 1 if old == "def " else text.index(old)
    (core / path).write_text(text[:place] + text[place:].replace(old, new, 1))
    found = "same" if source_fingerprint(core) == before else "other"
    assert found == effect

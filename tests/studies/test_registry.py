"""Studies in Python files: a mistake is said with its file and line."""

from pathlib import Path

import pytest

from contactstudy import InvalidInput
from studies.engine.request import Request
from studies.registry import load

GOOD = '''"""Plain numbers."""
from dataclasses import dataclass
from studies import Axis, Study
@dataclass(frozen=True)
class Number:
    number: int
    def prepare(self): return self.number
    def run(self, prepared): return prepared
    def record(self, result): return {}
def case_at(point):
    return Number(point["number"])
def measures(case, result): return {}
study = Study("numbers", "Plain numbers.", (Axis("number", (1, 2), "a number"),), case_at, measures)
def figure(dataset): return ()
'''
AXIS = 'Axis("number", (1, 2), "a number"),'


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("(" + AXIS + ")", "None", r", line 13: Study.axes is None: give studies.Axis"),
        (AXIS, AXIS + AXIS, r", line 13: Study '\w+' has two axes 'number'"),
        ("(1, 2)", "(1, 1)", r", line 13: Axis 'number' has the value 1 twice"),
        ("(1, 2)", "(1, 'a')", r", line 13: Axis 'number' has values \(1, 'a'\)"),
        ("import Axis", "import Axes", r", line 3: ImportError: cannot import name 'Axes'"),
        ("class Number:", "class Number", r", line 5: SyntaxError: expected ':'"),
        ("def figure", "raise SystemExit(3)\ndef figure", r", line 14: SystemExit: 3"),
        (", measures)", ", 5)", r", line 13: Study.measures is 5: give a function"),
        ("study = ", "other = ", " has no study: define study"),
        ('"numbers"', '"grid"', " has the name of a built-in study, 'grid'"),
    ],
)
def test_a_mistake_is_said_with_its_line(old: str, new: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    assert old in GOOD
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(InvalidInput, match=rf"^Study file '.*mine\.py'{said}"):
        load(str(path))


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("raise KeyError('x')", r"raises KeyError in case_at \(mine\.py, line 11\) at .*'number': 1"),
        ("return None", r"gives None at .*: return a studies\.model\.case\.Case"),
    ],
)
def test_a_scene_that_is_none_is_said_with_its_point(body: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(GOOD.replace('return Number(point["number"])', body))
    with pytest.raises(InvalidInput, match=said):
        Request.of(load(str(path)))

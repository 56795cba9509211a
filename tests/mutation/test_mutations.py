import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.mutation.mutations import mutations

pytest.importorskip("coverage")

pytestmark = pytest.mark.whole

ROOT = Path(__file__).parents[2]

SOURCE = '''"""Halves 3."""
LIMIT: float = 1.5


def half(x: int) -> float:
    """Of 2."""
    if x <= 0:
        raise ValueError(f"{x + 1} is 3")
    return max(-x, x) / 2
'''


def test_signs_factors_indices_comparisons_and_extremes_are_changed_and_words_are_not() -> None:
    found = [(one.line, one.old, one.new) for one in mutations("half.py", SOURCE)]
    assert found == [
        (2, "1.5", "3.0"),
        (7, "<=", "<"),
        (7, "0", "1"),
        (9, "max", "min"),
        (9, "-", "+"),
        (9, "/", "*"),
        (9, "2", "3"),
    ]


TESTED = """from contactstudy.half import LIMIT, half
def test_red_on_the_unchanged_code(): assert half(4) == 3
def test_half(): assert half(4) == 2
def test_no_limit(): assert True
"""
CAMPAIGN = """from pathlib import Path
from tests.mutation.campaign import Campaign
from tests.mutation.coverage_record import CoverageRecord
from tests.mutation.mutations import mutations
if __name__ == "__main__":
    copy = Path("project").resolve()
    record = CoverageRecord(Path("record").resolve())
    record.measure(copy, 0)
    campaign = Campaign(record, copy, 60.0)
    path = "contactstudy/half.py"
    for one in mutations(path, (copy / path).read_text(encoding="utf-8"))[3:5]:
        print(one, campaign.fate(one), sep=": ")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs forks")
def test_a_change_is_noticed_by_a_test_that_is_green_without_it(tmp_path: Path) -> None:
    for name, text in (
        ("contactstudy/__init__.py", ""),
        ("contactstudy/half.py", SOURCE),
        ("tests/__init__.py", ""),
        ("tests/contactstudy/__init__.py", ""),
        ("tests/contactstudy/test_half.py", TESTED),
        ("pyproject.toml", (ROOT / "pyproject.toml").read_text(encoding="utf-8")),
    ):
        file = tmp_path / "project" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    script = tmp_path / "campaign.py"
    script.write_text(CAMPAIGN)
    done = subprocess.run(
        [sys.executable, script],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    killed = "killed by tests/contactstudy/test_half.py::test_half"
    fates = [line for line in done.stdout.splitlines() if line.startswith("contactstudy/half.py")]
    assert fates == [
        f"contactstudy/half.py:9: 'max' -> 'min': {killed}",
        "contactstudy/half.py:9: '-' -> '+': survived",
    ]

"""Every example of the gallery runs and asserts the number that it is about."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

GALLERY = sorted((Path(__file__).parent.parent / "examples" / "gallery").glob("plot_*.py"))


@pytest.mark.cases(1)
@pytest.mark.parametrize("example", GALLERY, ids=lambda path: path.stem)
def test_an_example_runs_and_its_number_holds(example: Path, tmp_path: Path) -> None:
    environment = os.environ | {"MPLBACKEND": "Agg"}
    done = subprocess.run(
        [sys.executable, str(example)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert not list(tmp_path.iterdir())


def test_there_are_ten_examples_and_each_asserts_something() -> None:
    assert len(GALLERY) >= 10
    for example in GALLERY:
        assert "\nassert " in example.read_text(
            encoding="utf-8"
        ) or "    assert " in example.read_text(encoding="utf-8"), example

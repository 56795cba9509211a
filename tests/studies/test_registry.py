import subprocess
import sys

import pytest

from studies.registry import BUILT_IN, OPTIONAL, load, load_drawing

DRAWS = ("matplotlib", "studies.report")


def imported_by(code: str) -> set[str]:
    """Which of the plotting modules a fresh interpreter has imported after ``code``."""
    script = f"{code}\nimport sys\nprint(*[name for name in {DRAWS!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


@pytest.mark.parametrize("name", [*BUILT_IN, *OPTIONAL])
def test_every_study_has_a_definition_and_a_drawing(name: str) -> None:
    assert load(name).name == name
    assert callable(load_drawing(name).figure)


def test_listing_all_studies_imports_no_plotting_library() -> None:
    code = """
from click.testing import CliRunner
from studies.cli.commands import cli
assert CliRunner().invoke(cli, ["studies"]).exit_code == 0
"""
    assert imported_by(code) == set()


def test_a_worker_process_imports_no_plotting_library() -> None:
    code = """
import cloudpickle, pickle
import studies.engine.workers.worker
from studies.model.outcome import Work
from studies.registry import BUILT_IN, load
for name in BUILT_IN:
    study = load(name)
    pickle.loads(cloudpickle.dumps((Work(study.measures), study.cases()[0])))
"""
    assert imported_by(code) == set()
    assert imported_by("from studies.report import style") == set(
        DRAWS
    )  # the check itself can fail

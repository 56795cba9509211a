import subprocess
import sys

DRAWS = ("matplotlib", "studies.report")


def test_neither_listing_studies_nor_a_worker_process_imports_a_plotting_library() -> None:
    script = f"""
import sys
def drawing():
    return [name for name in {DRAWS!r} if name in sys.modules]
from click.testing import CliRunner
from studies.cli.commands import cli
assert CliRunner().invoke(cli, ["studies"]).exit_code == 0
assert drawing() == []
import cloudpickle, pickle
import studies.engine.workers.preload
from studies.model.outcome import Work
from studies.registry import BUILT_IN, load
for name in BUILT_IN:
    study = load(name)
    pickle.loads(cloudpickle.dumps((Work(study.measures), study.cases()[0])))
assert drawing() == []
from studies.report import style
assert drawing() == list({DRAWS!r})  # the check itself can fail
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr

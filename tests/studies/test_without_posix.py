"""Nothing that Windows lacks is needed: with all of that gone, every module is imported and a study runs."""

import json
import sys
from pathlib import Path

import pytest

from studies.model.outcome import CaseStatus
from tests.studies.conftest import python

SCRIPT = """
import tests.without_posix

import importlib
import json
import pkgutil
import sys
from contextlib import suppress
from pathlib import Path

from contactstudy import InvalidInput
from contactstudy.domain.device import available_bytes
from studies.engine.options import RunOptions
from studies.engine.run import run
from contactstudy.domain.files import locked
from tests.studies.engine import trouble

for package in ("contactstudy", "studies"):
    for module in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
        importlib.import_module(module.name)

found, said, folder = {}, [], Path(sys.argv[1])
options = RunOptions(workers=1, time_limit=2.0, repeats=0)
study = trouble.study([1, 2, trouble.RAISES, trouble.HANGS])

def statuses():
    dataset = run(study, folder, options=options, log=said.append)
    return dataset["case_status"].values.tolist()

found["statuses"] = statuses()
journal = folder / "trouble.journal.jsonl"
lines = journal.read_bytes().splitlines(keepends=True)
hurt = next(n for n, line in enumerate(lines) if b'"case":' in line[:40])
lines[hurt] = lines[hurt].replace(b"square", b"squire", 1)
journal.write_bytes(b"".join(lines))
found["again"] = statuses()

class Waits(BaseException):
    pass

def wait(line):
    found["holder"] = line
    raise Waits

with locked(folder / "held.lock", print), suppress(Waits), locked(folder / "held.lock", wait):
    pass
try:
    RunOptions(workers=0, time_limit=1.0)
except InvalidInput as refused:
    found["refused"] = str(refused)
found["bytes"] = available_bytes()
print(json.dumps(found | {"said": [str(line) for line in said]}))
"""


@pytest.mark.whole
@pytest.mark.skipif(sys.platform == "win32", reason="there all tests are this one")
def test_a_study_runs_goes_on_and_labels_its_failures_without_posix(tmp_path: Path) -> None:
    done = python(SCRIPT, tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    ok, failed, timeout = CaseStatus.OK, CaseStatus.FAILED, CaseStatus.TIMEOUT
    assert found["statuses"] == found["again"] == [ok, ok, failed, timeout]
    assert any("1 damaged lines of the journal are set aside" in line for line in found["said"])
    assert any("3 cases are stored, 1 to compute" in line for line in found["said"])
    assert "waiting for process" in found["holder"]
    assert found["refused"].startswith("time_limit is 1.0 and workers is 0: this system cannot")
    assert 0 < found["bytes"] < float("inf")

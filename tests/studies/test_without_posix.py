"""Nothing that Windows lacks is needed: with all of that gone, every module is imported and a study runs.

The standard library is that of Windows as far as Linux can act it, also in worker processes: functions and modules that
Windows lacks are gone, bytes are locked as there, and a file that this process has open is neither replaced nor removed.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from studies.model.outcome import CaseStatus

SITE = """
import errno, fcntl, os, select, signal, sys
from importlib import import_module
from types import SimpleNamespace

for name in ("locket", "psutil", "subprocess"):  # they ask for the system when they are imported
    import_module(name)

def locking(descriptor, mode, size):
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OSError(errno.EACCES, "Permission denied") from None

def refusing(change):
    def changed(*paths, **named):
        for number in () if "dir_fd" in named else os.listdir("/proc/self/fd"):
            place = f"/proc/self/fd/{number}"
            if os.path.exists(place) and os.readlink(place) in map(os.path.abspath, paths):
                raise PermissionError(errno.EACCES, "The file is open", place)
        return change(*paths, **named)
    return changed

sys.modules["msvcrt"] = SimpleNamespace(locking=locking, LK_NBLCK=2)
sys.modules.update(dict.fromkeys("fcntl grp pwd resource termios tty".split()))
lacking = {
    os: "O_CLOEXEC O_NOFOLLOW O_NONBLOCK fork forkpty killpg pread pwrite register_at_fork sched_getaffinity setsid "
    "waitid",
    signal: "SIGALRM SIGHUP SIGQUIT alarm pthread_kill setitimer",
    select: "epoll poll",
}
for module, names in lacking.items():
    for name in names.split():
        vars(module).pop(name, None)
os.process_cpu_count = os.cpu_count  # of Python 3.13, where it asks what is gone
for name in ("remove", "rename", "replace", "unlink"):
    setattr(os, name, refusing(getattr(os, name)))
"""

SCRIPT = """
import importlib
import json
import pkgutil
import sys
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

found, said, folder = {}, [], Path.cwd()
options = RunOptions(workers=1, time_limit=2.0, repeats=0)
study = trouble.study([1, 2, trouble.RAISES, trouble.HANGS])

def statuses():
    return run(study, folder, options=options, log=said.append)["case_status"].values.tolist()

found["statuses"] = statuses()
journal = folder / "cases.jsonl"
journal.write_bytes(journal.read_bytes().replace(b"square", b"squire", 1))
found["again"] = statuses()

try:
    with locked(folder / "held.lock", "it"), locked(folder / "held.lock", "it"):
        pass
except InvalidInput as refused:
    found["holder"] = str(refused)
found["bytes"] = available_bytes()
print(json.dumps(found | {"said": [str(line) for line in said]}))
"""


@pytest.mark.whole
@pytest.mark.skipif(sys.platform == "win32", reason="there all tests are this one")
def test_a_study_runs_goes_on_and_labels_its_failures_without_posix(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(SITE, encoding="utf-8")
    places = os.pathsep.join([str(tmp_path), str(Path(__file__).parents[2])])
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": places}, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    ok, failed, timeout = CaseStatus.OK, CaseStatus.FAILED, CaseStatus.TIMEOUT
    assert found["statuses"] == found["again"] == [ok, ok, failed, timeout]
    assert any("1 line of cases.jsonl is damaged" in line for line in found["said"])
    assert any("3 cases are stored, 1 to compute" in line for line in found["said"])
    assert "it is locked by process" in found["holder"]
    assert 0 < found["bytes"] < float("inf")

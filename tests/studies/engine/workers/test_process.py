import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import cloudpickle
import psutil
import pytest

from contactstudy import InvalidInput
from studies.engine.workers import process as module
from studies.engine.workers.process import SupervisedProcess, pickled_settings
from studies.engine.workers.process_tree import WORKER_VARIABLE, kill_process_tree
from studies.model.outcome import CaseStatus, Outcome, RunSettings
from studies.store.fingerprint.modules import CurrentModules
from tests.studies.conftest import POSIX
from tests.studies.engine import trouble
from tests.studies.engine.trouble import DIES, RAISES, Trouble

FORKED = pytest.mark.skipif(module.METHOD != "forkserver", reason="processes are not forked")
OK, FAILED, KILLED = CaseStatus.OK, CaseStatus.FAILED, CaseStatus.KILLED


@dataclass(frozen=True)
class Leaving(Trouble):
    """Ends its process with an exit code, as some libraries do."""

    def run(self, prepared: float) -> float:
        super().run(prepared)
        os._exit(3)


@pytest.fixture
def worker() -> Iterator[SupervisedProcess]:
    one = SupervisedProcess(pickled_settings(RunSettings(trouble.measures)))
    yield one
    one.end()


def outcomes_of(worker: SupervisedProcess, *cases: Trouble) -> list[Outcome]:
    names = [str(place) for place in range(len(cases))]
    return list(worker.run(cloudpickle.dumps(cases), names, None))


def squares(outcomes: list[Outcome]) -> list[float | CaseStatus]:
    return [
        float(one.variables["square"]) if one.case_status is OK else one.case_status
        for one in outcomes
    ]


@POSIX
def test_every_case_of_a_batch_is_answered_in_its_order(
    worker: SupervisedProcess, tmp_path: Path
) -> None:
    """One that its process dies of is tried a second time, for it may have been ended from outside."""
    log = tmp_path / "log"
    cases = [Trouble(float(n), log=str(log)) for n in (DIES, 1, RAISES, 2, 4, DIES, 5, 6)]
    begun = time.perf_counter()
    outcomes = outcomes_of(worker, *cases)
    taken = time.perf_counter() - begun
    assert squares(outcomes) == [KILLED, 1, FAILED, 4, 16, KILLED, 25, 36]
    tried = [float(line) for line in log.read_text(encoding="utf-8").split()]
    assert tried == [DIES, DIES, 1, RAISES, 2, 4, DIES, DIES, 5, 6]
    assert outcomes[0].error == (
        "Killed: its process was ended by SIGKILL, perhaps out of memory while it was computed"
    )
    assert all(0 <= one.seconds <= taken for one in outcomes)


@POSIX
def test_the_exit_code_of_a_case_is_said(worker: SupervisedProcess, tmp_path: Path) -> None:
    log = tmp_path / "log"
    outcomes = outcomes_of(worker, Leaving(1.0, log=str(log)), Trouble(2.0))
    assert squares(outcomes) == [KILLED, 4]
    assert "its process ended with exit code 3" in outcomes[0].error
    assert log.read_text(encoding="utf-8").split() == ["1.0", "1.0"]


@dataclass(frozen=True)
class Ending:
    def __reduce__(self) -> tuple[object, tuple[int]]:
        return os._exit, (3,)


def test_a_study_that_ends_every_process_that_reads_it_is_given_up() -> None:
    one = SupervisedProcess(pickled_settings(RunSettings(Ending())))  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match=r"^3 worker processes ended before .* exit code 3"):
        outcomes_of(one, Trouble(1.0))


def test_a_run_against_the_clock_is_a_sample_or_says_why_not(worker: SupervisedProcess) -> None:
    for case, failure in ((Trouble(2.0), None), (Trouble(float(RAISES)), "ArithmeticError")):
        (outcome,) = worker.run(cloudpickle.dumps((case,)), ("one",), None, "time")
        assert (outcome.sample is None) == (failure is not None)
        assert failure is None or (outcome.failure.kind, outcome.failure.stage) == (
            failure,
            "timing",
        )


def test_an_outcome_says_what_its_process_had_loaded(worker: SupervisedProcess) -> None:
    (one,) = outcomes_of(worker, Trouble(1.0))
    assert CurrentModules().changes(one.loaded) == []
    assert "module tests.studies.engine.trouble" in one.loaded
    assert "distribution numpy" in one.loaded


def server() -> psutil.Process:
    return next(
        one
        for one in psutil.Process().children()
        if "multiprocessing.forkserver" in str(one.cmdline())
    )


SCRIPT = """
from tests.studies.engine.workers.test_process import *
one = SupervisedProcess(pickled_settings(RunSettings(trouble.measures)))
outcomes_of(one, Trouble(1.0))
print(*(part.path for part in server().memory_maps()))
one.end()
"""


@pytest.mark.whole
@FORKED
def test_what_worker_processes_need_is_loaded_before_they_are_forked(tmp_path: Path) -> None:
    (tmp_path / "random.py").write_text("1 / 0")
    done = subprocess.run(
        [sys.executable, "-P", "-c", SCRIPT], cwd=tmp_path, capture_output=True, text=True,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[4])},
    )  # fmt: skip
    assert "_multiarray_umath" in done.stdout, done.stderr


@pytest.mark.cases(1)
@FORKED
@pytest.mark.parametrize("signal_name", ["SIGKILL", "SIGTERM"])
def test_the_end_of_the_process_that_forks_ends_no_run(
    worker: SupervisedProcess, signal_name: str
) -> None:
    assert squares(outcomes_of(worker, Trouble(2.0))) == [4]
    server().send_signal(getattr(signal, signal_name))
    # the next one is asked for while the system ends it
    other = SupervisedProcess(pickled_settings(RunSettings(trouble.measures)))
    assert squares(outcomes_of(other, Trouble(4.0), Trouble(5.0))) == [16, 25]
    assert squares(outcomes_of(worker, Trouble(6.0))) == [36]
    other.end()


def test_a_worker_that_ends_while_its_process_starts_leaves_none() -> None:
    """Python would wait at its exit for a process that nobody ends."""
    one = SupervisedProcess(pickled_settings(RunSettings(trouble.measures)))
    before = set(multiprocessing.active_children())
    with ThreadPoolExecutor(1) as pool, module.START_LOCK:
        answers = pool.submit(outcomes_of, one, Trouble(2.0))
        while not hasattr(one, "_worker_id"):  # it has not come to the lock
            time.sleep(0.001)
        one.end()
    assert answers.result() == []
    assert set(multiprocessing.active_children()) <= before


@POSIX
def test_what_a_worker_left_behind_ends_with_it_and_nothing_else() -> None:
    """Told by the identifier in its environment, also where it leads a session of its own."""

    def waiting(worker_id: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [sys.executable, "-c", "input()"],
            stdin=subprocess.PIPE,
            env=os.environ | {WORKER_VARIABLE: worker_id},
            start_new_session=True,
        )

    leader, left, other = waiting("first"), waiting("first"), waiting("second")
    kill_process_tree(leader.pid, "first")
    assert other.poll() is None
    for one in (leader, left, other):
        one.communicate()
    assert (leader.returncode, left.returncode) == (-9, -9)
    assert other.returncode == 1  # of an empty input, and of no signal

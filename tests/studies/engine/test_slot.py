import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cloudpickle
import psutil
import pytest

from contactstudy import InvalidInput
from studies.engine import slot as module
from studies.engine.compute import Task
from studies.engine.slot import Slot
from studies.model.outcome import CaseStatus, Outcome
from tests.studies.conftest import POSIX
from tests.studies.engine.trouble import DIES, RAISES, Square, Trouble, lines, measures, settings_of

OK, FAILED, TIMEOUT, KILLED = list(CaseStatus)[1:5]
LINUX = pytest.mark.skipif(module.METHOD != "forkserver", reason="processes have no keeper")


@dataclass(frozen=True)
class Ending(Square):
    """Ends its process in one of several ways, or never."""

    how: str

    def run(self, prepared: float) -> float:
        match self.how:
            case "exit":
                os._exit(3)
            case "compiled":  # which holds the interpreter's lock
                ctypes.PyDLL(None).sleep(1000)
            case "fork":  # its child must not answer, too
                ctypes.CDLL(None).fork()
            case "stop":
                os.kill(os.getpid(), signal.SIGSTOP)
            case "left":
                # two generations in sessions of their own, one of them another program
                if os.fork() == 0:
                    os.setsid()
                    if os.fork() == 0:
                        time.sleep(1000)
                    os._exit(0)
                subprocess.Popen([sys.executable, "-c", "input()"], start_new_session=True, stdin=-1)
                os.kill(os.getpid(), signal.SIGKILL)
        return 0.0


@pytest.fixture
def slot() -> Iterator[Slot]:
    with Slot(settings_of(measures, Ending(1.0, "exit"))) as one:
        yield one


def performed(slot: Slot, *cases: Square, limit: float | None = None) -> list[Outcome]:
    """Of all cases, however many a batch has time for."""
    tasks = [Task(f"{place:08x}", case) for place, case in enumerate(cases)]
    outcomes: list[Outcome] = []
    while left := tasks[len(outcomes) :]:
        outcomes += slot.perform(cloudpickle.dumps(left), len(left), limit)
    return outcomes


def squares(outcomes: list[Outcome]) -> list[float | CaseStatus]:
    return [float(one.variables["square"]) if one.case_status is OK else one.case_status for one in outcomes]


@POSIX
def test_every_case_of_a_batch_is_answered_in_its_order_and_one_that_dies_is_tried_twice(
    slot: Slot, tmp_path: Path
) -> None:
    log = tmp_path / "log"
    cases = [Trouble(float(n), log=str(log)) for n in (DIES, 1, RAISES, 2, DIES, 5)]
    outcomes = performed(slot, *cases)
    assert squares(outcomes) == [KILLED, 1, FAILED, 4, KILLED, 25]
    assert [*map(float, lines(log))] == [DIES, DIES, 1, RAISES, 2, DIES, DIES, 5]
    assert "its process was ended by SIGKILL, perhaps out of memory" in outcomes[0].error
    (left,) = performed(slot, Ending(1.0, "exit"))
    assert "its process ended with exit code 3" in left.error


@POSIX
def test_a_case_that_forks_has_one_answer(slot: Slot) -> None:
    cases = [Trouble(2.0), Ending(1.0, "fork"), Trouble(4.0), Trouble(5.0)]
    assert squares(performed(slot, *cases)) == [4, 0, 16, 25]


@LINUX
@pytest.mark.parametrize("how", ["compiled", "stop"])
def test_a_limit_ends_what_no_signal_handler_of_python_reaches(slot: Slot, how: str) -> None:
    assert squares(performed(slot, Trouble(2.0))) == [4]
    (late,) = performed(slot, Ending(1.0, how), limit=0.5)
    assert late.case_status is TIMEOUT
    assert late.seconds >= 0.5
    assert "not done after 0.5 s; give more with --time-limit" in late.error
    assert squares(performed(slot, Trouble(4.0))) == [16]


@LINUX
def test_what_a_case_has_started_ends_with_it_wherever_it_is(slot: Slot) -> None:
    assert squares(performed(slot, Trouble(2.0))) == [4]
    before = set(psutil.pids())
    assert squares(performed(slot, Ending(1.0, "left"), Trouble(4.0))) == [KILLED, 16]
    server = next(one for one in psutil.Process().children() if "forkserver" in str(one.cmdline()))
    present = {one.pid for one in server.children(recursive=True)}
    assert not any(
        "input()" in str(one.info["cmdline"])
        for one in psutil.process_iter(["cmdline"])
        if one.pid not in before | present
    )
    # a keeper and its child
    assert len(present) == 2


@LINUX
def test_the_end_of_the_process_that_forks_ends_no_run(slot: Slot) -> None:
    assert squares(performed(slot, Trouble(2.0))) == [4]
    next(one for one in psutil.Process().children() if "forkserver" in str(one.cmdline())).kill()
    with Slot(settings_of(measures)) as other:
        assert squares(performed(other, Trouble(4.0), Trouble(5.0))) == [16, 25]
    assert squares(performed(slot, Trouble(6.0))) == [36]


@dataclass(frozen=True)
class Reading:
    def __reduce__(self) -> tuple[object, tuple[int]]:
        return os._exit, (3,)


def test_a_study_that_ends_every_process_that_reads_it_is_given_up() -> None:
    with (
        Slot(cloudpickle.dumps((Reading(), None))) as one,
        pytest.raises(InvalidInput, match=r"^3 worker processes ended before .* exit code 3"),
    ):
        performed(one, Trouble(1.0))

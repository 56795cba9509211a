import signal

import pytest

from studies.store.stop import Stop, StopRun
from tests.studies.conftest import POSIX, python

pytestmark = POSIX


def test_a_signal_is_taken_note_of_and_raised_where_it_is_asked_for() -> None:
    def work() -> None:
        with Stop() as stop:
            stop.check()
            signal.raise_signal(signal.SIGINT)
            assert stop.signal == signal.SIGINT
            with pytest.raises(StopRun):
                stop.check()
            with pytest.raises(StopRun), stop.interruptible():
                raise AssertionError("not begun")

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        work()
    assert signal.getsignal(signal.SIGINT) == before


def test_a_block_that_may_be_left_is_left_at_once_and_the_program_ends_as_by_its_signal() -> None:
    with pytest.raises(KeyboardInterrupt), Stop() as stop, stop.interruptible():
        signal.raise_signal(signal.SIGINT)
    with pytest.raises(SystemExit) as ended, Stop() as stop, stop.interruptible():
        signal.raise_signal(signal.SIGTERM)
    assert ended.value.code == 128 + 15


PATIENT = """
import signal, sys
from studies.store.stop import Stop
with Stop():
    for n in range(int(sys.argv[1])):
        signal.raise_signal(signal.SIGTERM)
    print("alive")
"""


@pytest.mark.parametrize(("times", "code", "said"), [(2, 128 + signal.SIGTERM, "alive\n"), (3, -signal.SIGTERM, "")])
def test_who_asks_a_third_time_is_obeyed_anywhere(times: int, code: int, said: str) -> None:
    done = python(PATIENT, times)
    assert (done.returncode, done.stdout) == (code, said), done.stderr

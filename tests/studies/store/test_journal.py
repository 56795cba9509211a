import json
import signal
import struct
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from contactstudy import InvalidInput
from studies.model.outcome import CaseStatus, Outcome, TimedRun
from studies.store.journal import Journal, decoded_variable, encoded, encoded_variable
from studies.store.stop import Stop, StopRun
from tests.studies.conftest import POSIX, python

SAMPLE = TimedRun(1.0, 2.0, 0.5, 1.5)
FIRST = {"point": {"number": 1}, "case": "a", "program": "p"}


def opened(path: Path, machine: str = "here") -> Journal:
    return Journal(path / "cases.jsonl", machine)


def add(journal: Journal, case: str, value: float = 1.0) -> None:
    outcome = Outcome(CaseStatus.OK, {"square": xr.Variable((), value)}, seconds=3.0)
    journal.add((case, "p"), "study", {"number": 1}, outcome)


def test_a_case_comes_back_with_its_numbers(tmp_path: Path) -> None:
    with opened(tmp_path) as journal:
        journal.start("study", "now", "p", {"numpy": "1.0"}, FIRST)
        add(journal, "a", value=7.5)
        journal.add(("b", "p"), "study", {}, Outcome(CaseStatus.FAILED, {}, "why"))
        add(journal, "a", value=8.5)  # once more, as after --retry
    found = opened(tmp_path)
    stored = found.outcome(("a", "p"))
    assert (stored.case_status, stored.seconds) == (CaseStatus.OK, 3.0)
    assert float(stored.variables["square"]) == 8.5
    assert found.outcome(("b", "p")).error == "why"
    assert found.outcome(("a", "of another program")) is None
    assert (found.history["study"], found.firsts["study"]) == (["now"], FIRST)
    assert found.programs == {"p": {"numpy": "1.0"}}


def test_times_are_of_one_machine_until_they_are_dropped(tmp_path: Path) -> None:
    a, b, c = ((name, "p") for name in "abc")
    with opened(tmp_path) as journal:
        for key, solve in ((c, 2.0), (a, 2.0), (a, 3.0)):
            journal.add_time(key, Outcome(CaseStatus.OK, sample=replace(SAMPLE, solve=solve)))
        journal.add_time(b, Outcome(CaseStatus.FAILED, {}, "too short"))
    found = opened(tmp_path)
    assert found.samples == {a: [SAMPLE, replace(SAMPLE, solve=3.0)], c: [SAMPLE]}
    assert found.untimed == {b: "too short"}
    with opened(tmp_path, machine="there") as elsewhere:
        assert (elsewhere.samples, elsewhere.untimed) == ({}, {})
        elsewhere.drop_times([a, b, c])
    with opened(tmp_path) as journal:
        journal.drop_times([a, b])
    again = opened(tmp_path)
    assert (again.samples, again.untimed) == ({c: [SAMPLE]}, {})


def test_two_processes_may_write_at_the_same_time(tmp_path: Path) -> None:
    with opened(tmp_path) as one, opened(tmp_path) as other:
        assert not list(one.notes())
        assert "another run writes to" in " ".join(other.notes())
        for number in range(20):
            add(one if number % 3 else other, str(number), value=float(number))
    found = opened(tmp_path)
    assert {float(found.outcome(key).variables["square"]) for key in found.cases} == set(range(20))


@pytest.mark.parametrize("replacement", [None, b""])
def test_a_journal_removed_or_replaced_while_it_was_written_is_said(replacement: bytes | None, tmp_path: Path) -> None:
    journal = opened(tmp_path)
    with suppress(InvalidInput), journal:
        journal.path.unlink()
        if replacement is not None:
            journal.path.write_bytes(replacement)
        with pytest.raises(InvalidInput, match="was removed or replaced"):
            journal.sync()


CASE = {"case": "b", "program": "p", "study": "s", "point": {}, "status": "OK", "seconds": 1.0,
        "error": "", "values": {}}  # fmt: skip
ODD: dict[str, bytes] = {
    "torn": encoded(CASE)[:-9],
    "damaged": encoded(CASE).replace(b"seconds", b"secants"),
    "no seconds": encoded({name: value for name, value in CASE.items() if name != "seconds"}),
    "unknown status": encoded(CASE | {"status": "bogus"}),
    "a sample of others": encoded({"time": "a", "program": "p", "sample": {"x": 1}}),
    "no JSON": b"nothing at all\n",
}


@pytest.mark.cases(9)
@pytest.mark.parametrize("kind", ODD)
def test_a_line_that_cannot_be_read_counts_as_not_stored_and_is_said_until_a_run_begins(
    kind: str, tmp_path: Path
) -> None:
    with opened(tmp_path) as journal:
        add(journal, "a")
    with journal.path.open("ab") as file:
        file.write(ODD[kind])
    for _ in range(2):
        with opened(tmp_path) as journal:
            assert "1 line of cases.jsonl is damaged or of another version" in " ".join(journal.notes())
            assert set(journal.cases) - {("c", "p")} == {("a", "p")}
            add(journal, "c", value=4.0)
    with opened(tmp_path) as journal:
        journal.start("s", "now", "p", {}, {})
    found = opened(tmp_path)
    assert list(found.notes()) == []
    assert float(found.outcome(("c", "p")).variables["square"]) == 4.0


def there_and_back(variable: xr.Variable) -> xr.Variable:
    return decoded_variable(json.loads(json.dumps(encoded_variable(variable))))


@given(st.floats())
def test_a_number_comes_back_to_the_last_bit(value: float) -> None:
    back = there_and_back(xr.Variable((), value)).values.item()
    assert struct.pack("d", back) == struct.pack("d", value) or value != value


@pytest.mark.parametrize(
    "values",
    [
        np.array([0.1, -0.0, np.nan, np.inf]), np.float32(0.1), np.array([[1, 2], [3, 4]], dtype=np.int8),
        np.uint64(2**64 - 1), np.bool_(1), np.array(["a", "größer"]), np.zeros((0, 3)),
        np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    ],
    ids=str,
)  # fmt: skip
def test_any_array_comes_back_to_the_last_bit(values: Any) -> None:
    values = np.asarray(values)
    dims = tuple("xyz"[: values.ndim])
    back = there_and_back(xr.Variable(dims, values))
    assert (back.dims, back.values.dtype) == (dims, values.dtype)
    assert back.values.tobytes() == values.tobytes()


def test_attributes_come_back_with_their_types() -> None:
    attrs = {"flags": np.array([0, 1], dtype=np.int8), "n": 3, "x": 3.0, "words": ["a", "b"], "one": np.float32(0.1)}
    back = there_and_back(xr.Variable((), 1.0, attrs)).attrs
    np.testing.assert_array_equal(back.pop("flags"), attrs["flags"], strict=True)
    assert back == {name: value for name, value in attrs.items() if name != "flags"}
    assert [type(value) for value in back.values()] == [int, float, list, np.float32]


# Signals that stop a run


@POSIX
def test_a_signal_is_taken_note_of_and_raised_where_it_is_asked_for() -> None:
    def work() -> None:
        with Stop() as stop:
            stop.check()
            signal.raise_signal(signal.SIGINT)
            with pytest.raises(StopRun):
                stop.check()
            with pytest.raises(StopRun), stop.interruptible():
                raise AssertionError("not begun")

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        work()
    assert signal.getsignal(signal.SIGINT) == before
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


@POSIX
@pytest.mark.parametrize(("times", "code", "said"), [(2, 128 + signal.SIGTERM, "alive\n"), (3, -signal.SIGTERM, "")])
def test_who_asks_a_third_time_is_obeyed_anywhere(times: int, code: int, said: str) -> None:
    done = python(PATIENT, times)
    assert (done.returncode, done.stdout) == (code, said), done.stderr

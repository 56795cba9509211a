import json
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

SAMPLE = TimedRun(1.0, 2.0, 0.5, 1.5)
FIRST = {"point": {"number": 1}, "program": "p", "fields": {}}


def outcome(value: float = 1.0) -> Outcome:
    return Outcome(CaseStatus.OK, {"square": xr.Variable((), value)}, seconds=3.0)


def opened(path: Path, machine: str = "here") -> Journal:
    return Journal(path / "cases.jsonl", machine)


def add(journal: Journal, *cases: str, value: float = 1.0) -> None:
    for case in cases:
        journal.add((case, "p"), "study", {"number": 1}, outcome(value))


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
    failed = Outcome(CaseStatus.FAILED, {}, "too short")
    with opened(tmp_path) as journal:
        journal.add_time(c, Outcome(CaseStatus.OK, sample=SAMPLE))
        journal.add_time(a, Outcome(CaseStatus.OK, sample=SAMPLE))
        journal.add_time(a, Outcome(CaseStatus.OK, sample=replace(SAMPLE, solve=3.0)))
        journal.add_time(b, failed)
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


def test_a_journal_removed_or_replaced_while_it_was_written_is_said(tmp_path: Path) -> None:
    path = tmp_path / "cases.jsonl"
    for replacement in (None, b""):
        journal = opened(tmp_path)
        with suppress(InvalidInput), journal:
            path.unlink()
            if replacement is not None:
                path.write_bytes(replacement)
            with pytest.raises(InvalidInput, match="was removed or replaced"):
                journal.sync()


CASE = {"case": "b", "program": "p", "study": "s", "point": {}, "status": "OK", "seconds": 1.0,
        "error": "", "values": {}}  # fmt: skip
ODD: dict[str, bytes] = {
    "torn": encoded(CASE)[:-9],
    "damaged": encoded(CASE).replace(b"seconds", b"secants"),
    "no seconds": encoded({name: value for name, value in CASE.items() if name != "seconds"}),
    "unknown status": encoded(CASE | {"status": "bogus"}),
    "values that are text": encoded(CASE | {"values": "x"}),
    "an error that is no text": encoded(CASE | {"error": {"kind": "a"}}),
    "a sample of others": encoded({"time": "a", "program": "p", "sample": {"x": 1}}),
    "nothing known": encoded({"hello": 1}),
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
    assert list(opened(tmp_path).notes()) == []
    assert float(opened(tmp_path).outcome(("c", "p")).variables["square"]) == 4.0


def there_and_back(variables: dict[str, xr.Variable]) -> dict[str, xr.Variable]:
    written = json.dumps({name: encoded_variable(variable) for name, variable in variables.items()})
    return {name: decoded_variable(fields) for name, fields in json.loads(written).items()}


@given(st.floats())
def test_a_number_comes_back_to_the_last_bit(value: float) -> None:
    back = there_and_back({"a": xr.Variable((), value)})["a"].values.item()
    assert struct.pack("d", back) == struct.pack("d", value) or value != value


@pytest.mark.parametrize(
    "values",
    [
        np.array([0.1, -0.0, np.nan, np.inf]), np.float32(0.1), np.array([[1, 2], [3, 4]], dtype=np.int8),
        np.array(2**62 + 1), np.uint64(2**64 - 1), np.bool_(1), np.array(["a", "größer"]),
        np.array(["2020-01-01"], dtype="datetime64[ns]"), np.array(1 + 2j), np.zeros((0, 3)),
        np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    ],
    ids=str,
)  # fmt: skip
def test_any_array_comes_back_to_the_last_bit(values: Any) -> None:
    values = np.asarray(values)
    dims = tuple("xyz"[: values.ndim])
    back = there_and_back({"a": xr.Variable(dims, values, {"units": "1"})})["a"]
    assert back.dims == dims
    assert back.attrs == {"units": "1"}
    assert back.values.dtype == values.dtype
    assert back.values.tobytes() == values.tobytes()


def test_attributes_come_back_with_their_types() -> None:
    flags = np.array([0, 1], dtype=np.int8)
    attrs = {"flag_values": flags, "n": 3, "x": 3.0, "words": ["a", "b"], "one": np.float32(0.1)}
    back = there_and_back({"a": xr.Variable((), 1.0, attrs)})["a"].attrs
    assert back["flag_values"].dtype == np.int8
    np.testing.assert_array_equal(back["flag_values"], flags)
    assert (back["n"], back["x"], back["words"]) == (3, 3.0, ["a", "b"])
    assert isinstance(back["n"], int)
    assert isinstance(back["x"], float)
    assert back["one"] == np.float32(0.1)

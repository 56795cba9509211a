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
from contactstudy.domain.identity import keys
from studies.model.outcome import CaseStatus, Outcome, TimedRun
from studies.store.fingerprint.modules import RECORDER
from studies.store.journal import FORMAT, Journal
from studies.store.records import (
    CaseIdentity,
    Context,
    decoded_variable,
    encoded,
    encoded_variable,
)

CONTEXT = {"code": "1"}

SAMPLE = TimedRun(1.0, 2.0, 0.5, 1.5, 0.1)


def identity(name: str, **more: str) -> CaseIdentity:
    tree = {"": "Case", "number": name} | more
    return CaseIdentity(name, keys(tree)[1], tree, {"number": name})


def outcome(seconds: float = 0.0, value: float = 1.0) -> Outcome:
    return Outcome(CaseStatus.OK, {"square": xr.Variable((), value)}, None, seconds)


def opened(path: Path, context: dict[str, str] | None = None, machine: str = "here") -> Journal:
    part = CONTEXT if context is None else context
    return Journal(path / "x.journal.jsonl", Context(part), machine)


def test_a_case_comes_back_with_its_numbers(tmp_path: Path) -> None:
    with opened(tmp_path) as journal:
        journal.start("now", {"number": [1, 2]})
        journal.begin("a")
        assert journal.interrupted == "a"
        journal.add(identity("a"), outcome(3.0, value=7.5))
        journal.begin("b")
    found = opened(tmp_path)
    record = found.records["a"]
    assert (record.seconds, record.case_status) == (3.0, CaseStatus.OK)
    assert float(record.outcome.variables["square"]) == 7.5
    assert record.is_of(identity("a"))
    assert not record.is_of(identity("a", offset="1"))
    assert found.interrupted == "b"
    assert list(found.axes["number"]) == [1, 2]
    assert found.history == ["now"]


def test_what_changed_in_a_case_or_at_its_point_is_said(tmp_path: Path) -> None:
    with opened(tmp_path) as journal:
        journal.start("now", {})
        journal.add(identity("a"), outcome())
        assert journal.reason_to_recompute(identity("a")) == ""
        changed = replace(identity("a"), tree={"": "Case", "number": "z"})
        assert journal.reason_to_recompute(changed) == "case.number was a and is z"
        moved = replace(identity("z"), key="other", point={"number": "a"})
        assert "number was" in journal.reason_to_recompute(moved)
        assert journal.reason_to_recompute(identity("new")) == ""
    other = opened(tmp_path, {"code": "2"})
    assert other.reason_to_recompute(identity("a")) == "code changed"
    classes = replace(identity("a"), state="of other classes")
    assert (
        opened(tmp_path).reason_to_recompute(classes) == "the state of the case's classes changed"
    )


def test_a_case_of_which_anything_loaded_has_changed_is_of_another_program(tmp_path: Path) -> None:
    right = RECORDER.scan()
    for name, value in {
        "module studies.model.case": "0",
        "module gone": "1",
        "python": "2",
    }.items():
        (tmp_path / name).mkdir()
        with opened(tmp_path / name) as journal:
            journal.start("now", {})
            journal.add(identity("a"), replace(outcome(), loaded=right))
            journal.add(identity("b"), replace(outcome(), loaded={**right, name: value}))
        found = opened(tmp_path / name)
        assert (set(found.records), set(found.other_records)) == ({"a"}, {"b"})
        assert found.reason_to_recompute(identity("b")) == f"{name.removeprefix('module ')} changed"


def test_times_are_of_one_machine_until_they_are_dropped(tmp_path: Path) -> None:
    with opened(tmp_path) as journal:
        journal.start("now", {})
        for name in "abc":
            journal.add(identity(name), outcome())
        journal.add_timed_run("c", SAMPLE)
        journal.add_timed_run("a", SAMPLE)
        journal.add_timed_run("a", replace(SAMPLE, solve=3.0))
        journal.add_timing_failure("b", "too short")
    found = opened(tmp_path)
    assert found.samples_of("a") == [SAMPLE, replace(SAMPLE, solve=3.0)]
    assert found.reason_without_times("b") == "too short"
    elsewhere = opened(tmp_path, machine="there")
    assert (elsewhere.samples, elsewhere.untimed) == ({}, {})
    assert set(elsewhere.records) == {"a", "b", "c"}
    with opened(tmp_path, machine="there") as journal:
        journal.drop_times("abc")
    with opened(tmp_path) as journal:
        journal.start("now", {})
        journal.drop_times("ab")
        assert (journal.samples_of("a"), journal.untimed) == ([], {})
        journal.add_timed_run("a", replace(SAMPLE, solve=4.0))
    again = opened(tmp_path)
    assert again.samples_of("a") == [replace(SAMPLE, solve=4.0)]
    assert again.samples_of("c") == [SAMPLE]
    assert again.untimed == {}


def test_cases_of_another_context_are_kept_apart(tmp_path: Path) -> None:
    with opened(tmp_path) as journal:
        journal.start("now", {"number": [1]})
        journal.add(identity("a"), outcome())
    with opened(tmp_path, {"code": "2"}) as journal:
        journal.start("later", {"number": [5]})
        journal.add(identity("b"), outcome())
    now = opened(tmp_path, {"code": "2"})
    assert (set(now.records), set(now.other_records)) == ({"b"}, {"a"})
    assert list(now.axes["number"]) == [5]
    assert now.history == ["now", "later"]


def test_a_journal_removed_or_replaced_while_it_was_written_is_said(tmp_path: Path) -> None:
    path = tmp_path / "x.journal.jsonl"
    for replacement in (None, b""):
        journal = opened(tmp_path)
        with suppress(InvalidInput), journal:
            journal.start("now", {})
            path.unlink()
            if replacement is not None:
                path.write_bytes(replacement)
            with pytest.raises(InvalidInput, match="was removed or replaced"):
                journal.sync()


CASE = {
    "case": "a", "status": "ok", "point": {"number": "a"}, "tree": {"": "Case"}, "exact": "e",
    "seconds": 1.0,
}  # fmt: skip

MALFORMED: dict[str, dict[str, object]] = {
    "no seconds": {name: value for name, value in CASE.items() if name != "seconds"},
    "unknown status": CASE | {"status": "bogus"},
    "values that are text": CASE | {"values": "x"},
    "more in a failure": CASE | {"failure": {"kind": "a", "sentence": "b", "stage": "c", "d": 1}},
    "a sample of others": {"time": "a", "epoch": 0, "machine": "here", "sample": {"x": 1}},
    "a run without a study": {"run": "b", "format": FORMAT},
    "a case of an unknown program": CASE | {"program": "b"},
    "nothing known": {"hello": 1},
}


@pytest.mark.parametrize("kind", MALFORMED)
def test_a_line_that_no_version_wrote_is_set_aside_though_its_checksum_is_right(
    kind: str, tmp_path: Path
) -> None:
    with opened(tmp_path) as journal:
        journal.start("now", {"number": [1]})
        journal.add(identity("b"), outcome(value=7.0))
        stamp = journal.records["b"].stamp
        path = journal.path
    with path.open("ab") as file:
        file.write(encoded({"program": stamp, "values": {}} | MALFORMED[kind]))
    with opened(tmp_path) as journal:
        assert list(journal.records) == ["b"]
        assert float(journal.records["b"].outcome.variables["square"]) == 7
        assert "1 damaged lines" in journal.notes[0]
        assert journal.samples == {}
    assert opened(tmp_path).notes == []


def test_a_journal_of_another_format_is_set_aside_with_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "x.journal.jsonl"
    old = encoded({"run": "a", "format": 3, "context": {}, "machine": "here"})
    path.write_bytes(old)
    assert opened(tmp_path).records == {}
    assert path.read_bytes() == old
    with opened(tmp_path) as journal:
        journal.start("now", {})
        journal.add(identity("a"), outcome())
        assert journal.notes == [
            "the journal was written by another version: it is set aside as x.journal.jsonl.damaged"
        ]
    assert path.with_name("x.journal.jsonl.damaged").read_bytes() == old
    assert set(opened(tmp_path).records) == {"a"}


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

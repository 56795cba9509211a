"""What a journal keeps of runs, times and epochs, and when it is on disk."""

import os
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.model.outcome import CaseStatus, Outcome, Sample
from studies.store import journal as module
from studies.store.journal import Journal
from studies.store.journal_lines import encoded
from studies.store.records import CaseIdentity

CONTEXT = {"code": "1"}
PROVENANCE = {"history": "now"}
SAMPLE = Sample(1.0, 2.0, 0.5, 1.5, 1, 0.1)


def identity(name: str, **more: str) -> CaseIdentity:
    return CaseIdentity(name, {"": "Case", "number": name} | more, {"number": name})


def outcome(seconds: float = 0.0, value: float = 1.0) -> Outcome:
    return Outcome(
        CaseStatus.OK, {"square": xr.Variable((), value)}, None, seconds, {}, seconds / 2
    )


def opened(path: Path, context: dict[str, str] | None = None, machine: str = "here") -> Journal:
    return Journal(path / "x.journal.jsonl", CONTEXT if context is None else context, machine)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> dict[str, float]:
    """A clock wound by hand, and how often something was put on disk."""
    at = {"now": 100.0, "synced": 0.0}
    whole = os.fsync

    def fsync(descriptor: int) -> None:
        at["synced"] += 1
        whole(descriptor)

    monkeypatch.setattr(module, "monotonic", lambda: at["now"])
    monkeypatch.setattr(os, "fsync", fsync)
    return at


def test_long_cases_are_on_disk_at_once_and_short_ones_together(
    tmp_path: Path, clock: dict[str, float]
) -> None:
    with opened(tmp_path) as journal:
        journal.start(PROVENANCE, {"number": [1, 2]})
        count = clock["synced"]
        assert not journal.add(identity("a"), outcome(0.02))
        # a twentieth of a second later, and a little more
        clock["now"] += 0.0499
        assert not journal.add(identity("b"), outcome(0.025))
        assert clock["synced"] == count
        clock["now"] += 0.001
        assert journal.add(identity("c"), outcome(0.0))
        assert clock["synced"] == count + 1
        # counted from there on; a case of half of that is written at once
        assert not journal.add(identity("d"), outcome(0.0))
        assert journal.add(identity("e"), outcome(0.0251))
        assert clock["synced"] == count + 2
        journal.time("a", SAMPLE)
        assert clock["synced"] == count + 2
        clock["now"] += 0.0501
        journal.time("a", SAMPLE)
        assert clock["synced"] == count + 3
    assert clock["synced"] == count + 4
    assert set(opened(tmp_path).contents.records) == set("abcde")


def test_a_case_comes_back_with_its_numbers(tmp_path: Path) -> None:
    with opened(tmp_path) as journal:
        journal.start(PROVENANCE, {"number": [1, 2]})
        journal.begin("a")
        assert journal.contents.begun is None
        journal.add(identity("a"), outcome(3.0, value=7.5))
        journal.begin("b")
        journal.score({"factor": 2.0})
    found = opened(tmp_path).contents
    record = found.records["a"]
    assert (record.seconds, record.cpu, record.case_status) == (3.0, 1.5, CaseStatus.OK)
    assert float(record.outcome.variables["square"]) == 7.5
    value = record.variable("square")
    assert value is not None
    assert float(value) == 7.5
    assert record.variable("cube") is None
    assert record.error == ""
    assert record.is_of(identity("a"))
    assert not record.is_of(identity("a", offset="1"))
    assert found.begun == "b"
    assert dict(found.score) == {"factor": 2.0}
    assert list(found.axes["number"]) == [1, 2]
    assert found.history == ["now"]


def test_what_changed_in_a_case_or_at_its_point_is_said(tmp_path: Path) -> None:
    with opened(tmp_path) as journal:
        journal.start(PROVENANCE, {})
        journal.add(identity("a"), outcome())
        assert journal.contents.changed(identity("a")) == []
        [said] = journal.contents.changed(replace(identity("a"), tree={"": "Case", "number": "z"}))
        assert said == "case.number was 'a' and is 'z'" or "number was" in said
        moved = CaseIdentity("other", {"": "Case", "number": "z"}, {"number": "a"})
        assert len(journal.contents.changed(moved)) == 1
        assert journal.contents.changed(identity("new")) == []


def test_times_are_of_one_machine_and_of_the_last_epoch(tmp_path: Path) -> None:
    with opened(tmp_path) as journal:
        journal.start(PROVENANCE, {})
        journal.add(identity("a"), outcome())
        journal.time("a", SAMPLE)
        journal.time("a", replace(SAMPLE, solve=3.0))
        journal.cannot_time("b", "too short")
    found = opened(tmp_path).contents
    assert found.samples == {"a": [SAMPLE, replace(SAMPLE, solve=3.0)]}
    assert found.untimed == {"b": "too short"}
    assert found.epoch == 0
    elsewhere = opened(tmp_path, machine="there").contents
    assert (elsewhere.samples, elsewhere.untimed) == ({}, {})
    assert set(elsewhere.records) == {"a"}
    with opened(tmp_path) as journal:
        journal.start(PROVENANCE, {})
        journal.forget_times()
        assert (journal.contents.samples, journal.contents.untimed) == ({}, {})
        journal.forget_times()
        assert journal.contents.epoch == 2
        journal.time("a", replace(SAMPLE, solve=4.0))
    again = opened(tmp_path).contents
    assert again.epoch == 2
    assert again.samples == {"a": [replace(SAMPLE, solve=4.0)]}
    assert again.untimed == {}


def test_cases_of_another_context_are_kept_apart_and_without_one_all_count(tmp_path: Path) -> None:
    with opened(tmp_path) as journal:
        journal.start(PROVENANCE, {"number": [1]})
        journal.add(identity("a"), outcome())
    with opened(tmp_path, {"code": "2"}) as journal:
        journal.start({"history": "later"}, {"number": [5]})
        journal.add(identity("b"), outcome())
    now = opened(tmp_path, {"code": "2"}).contents
    assert (set(now.records), set(now.other_records)) == ({"b"}, {"a"})
    assert list(now.axes["number"]) == [5]
    assert now.history == ["now", "later"]
    every = Journal(tmp_path / "x.journal.jsonl", None, "here").contents
    assert (set(every.records), every.other_records) == ({"a", "b"}, {})


def test_a_journal_that_was_removed_or_replaced_while_it_was_written_is_said(
    tmp_path: Path,
) -> None:
    path = tmp_path / "x.journal.jsonl"
    journal = opened(tmp_path)
    with suppress(InvalidInput), journal:
        journal.start(PROVENANCE, {})
        path.unlink()
        with pytest.raises(InvalidInput, match="was removed or replaced"):
            journal.sync()
    journal = opened(tmp_path)
    with suppress(InvalidInput), journal:
        journal.start(PROVENANCE, {})
        path.rename(tmp_path / "moved")
        path.write_bytes(b"")
        with pytest.raises(InvalidInput, match="was removed or replaced"):
            journal.sync()


def test_a_hole_in_one_of_two_copies_loses_no_case_beside_the_one_between_them(
    tmp_path: Path,
) -> None:
    path = tmp_path / "x.journal.jsonl"
    with opened(tmp_path) as journal:
        journal.start(PROVENANCE, {"number": [1]})
        journal.add(identity("between"), outcome())
        journal.add(identity("a"), outcome())
    lines = path.read_bytes().splitlines(keepends=True)
    for name in (b'"run":', b'"axis":'):
        twice = [n for n, line in enumerate(lines) if name in line[:40]]
        assert len(twice) == 2
        for number in twice:
            torn = lines.copy()
            torn[number] = torn[number][:-5] + b"#" + torn[number][-4:]
            path.write_bytes(b"".join(torn))
            found = opened(tmp_path).contents
            assert float(found.records["a"].outcome.variables["square"]) == 1
            assert list(found.axes["number"]) == [1]
            # nobody knows the versions of what comes before the first whole line of its run
            assert ("between" in found.records) == (number != 0)


CASE = {
    "case": "a", "status": "ok", "point": {"number": "a"}, "tree": {"": "Case"}, "seconds": 1.0, "cpu": 1.0,
}  # fmt: skip
NUMBER, ROW = [[], "<f8", [], {}], [["k"], "<f8", [2], {}]
ODD: dict[str, list[dict[str, object]]] = {
    "no seconds": [{name: value for name, value in CASE.items() if name != "seconds"}],
    "nan seconds": [CASE | {"seconds": float("nan")}],
    "unknown status": [CASE | {"status": "bogus"}],
    "no tree": [{name: value for name, value in CASE.items() if name != "tree"}],
    "a key that is no text": [CASE | {"case": [1]}],
    "values that are text": [CASE | {"values": "x"}],
    "a value that is a list": [CASE | {"values": {"s": [*NUMBER, [1, 2]]}}],
    "a value that is nan": [CASE | {"values": {"s": [*NUMBER, float("nan")]}}],
    "a value that is whole": [CASE | {"values": {"s": [*NUMBER, 1]}}],
    "a value of bad letters": [CASE | {"values": {"s": [*ROW, "!!!"]}}],
    "a value that is too short": [CASE | {"values": {"s": [*ROW, "AAAA"]}}],
    "a value of objects": [CASE | {"values": {"s": [[], "|O", [], {}, "AAAAAAAAAAA="]}}],
    "a value of nonsense": [CASE | {"values": {"s": [[], "zz", [], {}, "AAAA"]}}],
    "a value without a type": [CASE | {"values": {"s": [[], 1.0]}}],
    "a name for a group": [CASE | {"values": {"a/b": [*NUMBER, 1.0]}}],
    "more in a failure": [CASE | {"failure": {"kind": "a", "sentence": "b", "stage": "c", "d": 1}}],
    "a failure that moves a cursor": [
        CASE | {"failure": {"kind": "a", "sentence": "\x1b[31m", "stage": "c"}}
    ],
    "an axis of tables": [{"axis": "a", "values": [{"x": 1}]}],
    "a sample of others": [{"time": "a", "epoch": 0, "sample": {"x": 1}}],
    "an epoch that is text": [{"time": "a", "epoch": "9", "sample": {}}, {"retime": "a"}],
    "no reason": [{"untimed": "a", "epoch": 0}],
    "a score that is text": [{"score": "x"}],
    "a score that hides values": [{"score": {"_FillValue": 1}}],
    "a beginning of lists": [{"begin": [1]}],
    "a run without versions": [{"run": "b"}],
    "nothing known": [{"hello": 1}],
}


@pytest.mark.parametrize("kind", ODD)
def test_a_line_that_no_version_wrote_is_set_aside_though_its_checksum_is_right(
    kind: str, tmp_path: Path
) -> None:
    with opened(tmp_path) as journal:
        journal.start(PROVENANCE, {"number": [1]})
        journal.add(identity("b"), outcome(value=7.0))
        run = journal._run
        path = journal.path
    with path.open("ab") as file:
        for line in ODD[kind]:
            file.write(encoded({"of": run, "values": {}} | line))
    with opened(tmp_path) as journal:
        assert list(journal.contents.records) == ["b"]
        assert float(journal.contents.records["b"].outcome.variables["square"]) == 7
        assert f"{len(ODD[kind])} damaged lines" in journal.notes[0]
        assert journal.contents.samples == {}
    assert opened(tmp_path).notes == []


def test_damaged_lines_are_moved_to_another_file_and_the_others_stay_as_they_are(
    tmp_path: Path,
) -> None:
    with opened(tmp_path) as journal:
        journal.start(PROVENANCE, {"number": [1, 2]})
        journal.add(identity("b"), outcome(value=7.0))
        path = journal.path
    whole = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join((whole[0], b"first\n", *whole[1:-1], b"second one\n", whole[-1])))
    with opened(tmp_path) as journal:
        journal.start(PROVENANCE, {"number": [1, 2]})
    assert path.read_bytes().startswith(b"".join(whole))
    assert path.with_name(f"{path.name}.damaged").read_bytes() == b"first\nsecond one\n"


def test_a_journal_of_another_format_is_left_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "x.journal.jsonl"
    path.write_bytes(encoded({"run": "a", "format": 9, "context": {}, "machine": "here"}))
    with pytest.raises(
        InvalidInput, match=r"of format 9, and this version reads format 3\): use the"
    ):
        opened(tmp_path)

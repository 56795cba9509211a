"""The journal of a study: an append-only log with one line for each result, from which its state is replayed."""

import hashlib
import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict
from functools import cached_property
from pathlib import Path
from time import monotonic
from typing import Any, Self

from contactstudy import InvalidInput
from contactstudy.domain.files import open_descriptor, reason, replacing, set_aside
from contactstudy.domain.identity import Tree, differences, text
from studies.model.outcome import CaseStatus, Outcome, TimedRun
from studies.store.fingerprint.modules import digest, listed
from studies.store.records import (
    START,
    CaseIdentity,
    Context,
    Program,
    Record,
    decoded,
    encoded,
    encoded_variable,
    failure_of,
    without_garbage_collection,
)

FORMAT = 8
# errors that a line may raise which no version has written
MALFORMED_LINE = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError)
# Seconds after which lines are synced to the disk, which takes 0.3 ms; shorter cases are synced together.
SYNC_INTERVAL = 0.05


class Journal:
    """The journal of a study, read at once, and in a ``with`` statement open for writing.

    Every line starts with a checksum of its content. A line that fails it, or that this version does not write, goes to
    ``<path>.damaged`` when the journal is opened for writing, and its content counts as not stored; a torn last line is
    cut off. Lines are runs (study part, time, new values of axes), programs (what was loaded), the beginning of a case,
    cases and their times. A case names its program, a line above. A journal of another format is set aside as a whole.
    Only one process at a time may write.

    Parameters
    ----------
    path
        The file, which need not exist.
    context
        Part of the study, and what would be loaded now; records of another program are kept apart.
    machine
        Name of this machine; times of another machine do not count.

    Attributes
    ----------
    notes
        Sentences on damaged lines.
    records, other_records
        Records of the present program and of others, by key.
    programs
        Programs by their stamps.
    samples, untimed
        Timed runs on this machine, or why there are none, by the key of the case and the stamp of its program.
    times
        Hash of all lines with timed runs.
    axes
        Values that each axis ever had with this part of the study.
    history
        Time and command of each run.
    interrupted
        Key of the case that was being computed when the last run ended; None if there was none.
    """

    def __init__(self, path: Path, context: Context, machine: str) -> None:
        self.path, self.notes = path, list[str]()
        self._context, self._machine = context, machine
        self._synced = monotonic()
        self._stamps: dict[tuple[int, str], tuple[object, str]] = {}
        self._read()

    def __enter__(self) -> Self:
        try:
            if self._is_of_other_format:
                aside = set_aside(self.path)
                self.notes.append(
                    f"the journal was written by another version: it is set aside as {aside.name}"
                )
            elif self._damaged:
                self._set_aside()
            self._descriptor = open_descriptor(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND)
            os.ftruncate(self._descriptor, self._end)
        except OSError as error:
            raise self._write_error(error) from None
        return self

    def __exit__(self, kind: type[BaseException] | None, *raised: object) -> None:
        try:
            if kind is None or not issubclass(kind, InvalidInput):
                self.sync()
        finally:
            os.close(self._descriptor)

    def start(self, history: str, axes: Mapping[str, Iterable[Any]]) -> None:
        """Begin a run of the present study: write time and command of the run, and new values of each axis."""
        new_values = {
            name: [value for value in values if value not in self.axes.get(name, ())]
            for name, values in axes.items()
        }
        part = dict(self._context.part)
        self._write({"format": FORMAT, "history": history, "part": part, "axes": new_values})
        self.sync()

    def stamp(self, state: str, loaded: Mapping[str, str]) -> str:
        """Return the stamp of a program of this run, which is written at its first case.

        It is of the study's part, the state of the classes of the case, and what the process that computed it had
        loaded.
        """
        cached = self._stamps.get((id(loaded), state))
        if cached is None:
            program = {"part": dict(self._context.part), "state": state, "loaded": dict(loaded)}
            stamp = digest(text(program).encode())
            if stamp not in self.programs:
                self._write({"program": stamp} | program)
            # what this run computes counts in it, also where a file has been edited meanwhile
            self._current_programs.add(stamp)
            cached = self._stamps[id(loaded), state] = loaded, stamp
        return cached[1]

    def begin(self, key: str) -> None:
        """Write that this process begins a case, so that the next run knows which case a run died in."""
        self._write({"begin": key})

    def add(self, identity: CaseIdentity, outcome: Outcome) -> bool:
        """Write a case, and return whether all cases so far are on disk."""
        line: dict[str, Any] = {
            "case": identity.key,
            "program": self.stamp(identity.state, outcome.loaded),
            "status": outcome.case_status.name.lower(),
            "point": identity.point,
            "tree": identity.tree,
            "exact": identity.exact,
            "seconds": outcome.seconds,
            "values": {name: encoded_variable(v) for name, v in outcome.variables.items()},
        }
        if outcome.failure is not None:
            line["failure"] = asdict(outcome.failure)
        self._write(line)
        return self._sync_if_due(outcome.seconds)

    def add_timed_run(self, key: str, sample: TimedRun) -> None:
        """Write a timed run of the case `key`."""
        self._write_time(key, {"sample": asdict(sample)})
        self._sync_if_due()

    def add_timing_failure(self, key: str, reason: str) -> None:
        """Write why the case `key` has no times; the next run does not time it."""
        self._write_time(key, {"reason": reason})

    def _write_time(self, key: str, line: dict[str, Any]) -> None:
        """Write a line on the times of a case."""
        about = {"time": key, "program": self.records[key].stamp, "machine": self._machine}
        self._write(about | line)

    def drop_times(self, keys: Iterable[str]) -> None:
        """Make all timed runs of some cases on this machine invalid."""
        self._write({"retime": list(keys), "machine": self._machine})

    def samples_of(self, key: str) -> list[TimedRun]:
        """Return the timed runs of the present record of a case."""
        return self.samples.get(self._time_key(key), [])

    def reason_without_times(self, key: str) -> str:
        """Return why the present record of a case has no times; empty where it may have some."""
        return self.untimed.get(self._time_key(key), "")

    def _time_key(self, key: str) -> tuple[str, str]:
        """Return the key of the times of the present record of a case."""
        record = self.records.get(key)
        return key, record.stamp if record else ""

    def reason_to_recompute(self, identity: CaseIdentity) -> str:
        """Return in one line why the stored record of a case, or at its point, cannot be used; empty without one."""
        before = self.records.get(identity.key) or self.other_records.get(identity.key)
        tree = before.identity.tree if before else self._trees.get(_point_key(identity.point))
        changes = [] if tree is None else differences(tree, identity.tree)
        if before is not None:
            names = self._context.changes(self.programs[before.stamp])
            if before.state != identity.state:
                names = ["the state of the case's classes", *names]
            changes += [f"{listed(names)} changed"] if names else []
        return ", ".join(changes)

    @cached_property
    def _trees(self) -> Mapping[object, Tree]:
        """Parameters stored at each point, when this is first asked."""
        records = (*self.other_records.values(), *self.records.values())
        identities = (record.identity for record in records)
        return {_point_key(identity.point): identity.tree for identity in identities}

    def sync(self) -> None:
        """Write everything through to the disk, in the file that has the journal's name.

        Raises
        ------
        InvalidInput
            If the disk is full, or the file has been removed.
        """
        try:
            os.fsync(self._descriptor)
            is_same = os.path.samestat(self.path.lstat(), os.fstat(self._descriptor))
        except FileNotFoundError:
            is_same = False
        except OSError as error:
            raise self._write_error(error) from None
        if not is_same:
            raise InvalidInput(
                f"Journal {str(self.path)!r} was removed or replaced while the run was writing it, and what it "
                "held is lost: run the same command again."
            )
        self._synced = monotonic()

    def _sync_if_due(self, seconds: float = 0.0) -> bool:
        """Sync after a case of so many seconds, or if the last time is some time ago; return whether it was done."""
        is_due = seconds > SYNC_INTERVAL / 2 or monotonic() - self._synced > SYNC_INTERVAL
        if is_due:
            self.sync()
        return is_due

    def _write(self, line: Mapping[str, Any]) -> None:
        """Append a line to the file, and apply it; cut it off where the disk takes only a part."""
        raw = encoded(line)
        try:
            unwritten = memoryview(raw)
            while unwritten:
                unwritten = unwritten[os.write(self._descriptor, unwritten) :]
        except OSError as error:
            with suppress(OSError):
                os.ftruncate(self._descriptor, self._end)
            raise self._write_error(error) from None
        self._end += len(raw)
        self._apply(line, raw)

    def _write_error(self, error: OSError) -> InvalidInput:
        """Return the error of a journal that cannot be written."""
        return InvalidInput(
            f"Journal {str(self.path)!r} cannot be written ({reason(error)}): what was stored is kept; "
            "make room or give another folder with --out, and run the same command again."
        )

    def _clear(self) -> None:
        """Set the state before the first line."""
        self.records: dict[str, Record] = {}
        self.other_records: dict[str, Record] = {}
        self.programs: dict[str, Program] = {}
        self.samples: dict[tuple[str, str], list[TimedRun]] = {}
        self.untimed: dict[tuple[str, str], str] = {}
        self.axes: dict[str, dict[Any, None]] = {}
        self.history: list[str] = []
        self.times = hashlib.blake2b(digest_size=8)
        self.interrupted: str | None = None
        self._current_programs: set[str] = set()
        self._damaged: dict[int, bytes] = {}
        self._is_of_other_format, self._end = False, 0

    def _read(self) -> None:
        """Read the journal from the start."""
        self._clear()
        try:
            with open(open_descriptor(self.path, os.O_RDONLY), "rb") as file:  # noqa: PTH123 (a descriptor)
                self._read_lines(file)
        except FileNotFoundError:
            pass
        except OSError as error:
            raise InvalidInput(
                f"Journal {str(self.path)!r} cannot be read ({reason(error)}): give another folder with --out."
            ) from None

    @without_garbage_collection()
    def _read_lines(self, file: Iterable[bytes]) -> None:
        """Apply every line of the file without a torn last one."""
        is_journal, is_of_other_format = True, False
        for number, raw in enumerate(file):
            if number == 0:
                is_journal = raw.startswith(START) or START.startswith(raw)
            if not raw.endswith(b"\n"):
                break  # torn
            line = decoded(raw)
            if line is None or not self._try_apply(line, raw):
                self._damaged[number] = raw
            if line is not None:
                is_journal, is_of_other_format = (
                    True,
                    is_of_other_format or line.get("format", FORMAT) != FORMAT,
                )
            self._end += len(raw)
        if not is_journal:
            raise InvalidInput(
                f"Journal {str(self.path)!r} is not a journal of this program: move the file away, or give "
                "another folder with --out."
            )
        if is_of_other_format:
            self._clear()
            self._is_of_other_format = True

    def _try_apply(self, line: Mapping[str, Any], raw: bytes) -> bool:
        """Apply a line, and return whether it has the form that this version writes."""
        try:
            self._apply(line, raw)
        except MALFORMED_LINE:
            return False
        return True

    def _apply(self, line: Mapping[str, Any], raw: bytes) -> None:
        """Change the state by a line, also given as bytes; raise a ``MALFORMED_LINE`` for one of another form."""
        match line:
            case {"case": key, "program": stamp, "values": dict()}:
                failure_of(line)
                status, state = CaseStatus[line["status"].upper()], self.programs[stamp].state
                records = self.records if stamp in self._current_programs else self.other_records
                records[key] = Record(
                    key, status, line["seconds"], line["exact"], stamp, state, raw
                )
                self.interrupted = None if self.interrupted == key else self.interrupted
            case {"machine": machine} if machine != self._machine:
                pass
            case {"time": key, "program": stamp, "sample": sample}:
                timed_run = TimedRun(**sample)
                self.samples.setdefault((key, stamp), []).append(timed_run)
                self.times.update(raw)
            case {"time": key, "program": stamp, "reason": why}:
                self.untimed[key, stamp] = why
            case {"retime": list(keys)}:
                self.times.update(raw)
                dropped = set(keys)
                self.samples = {of: t for of, t in self.samples.items() if of[0] not in dropped}
                self.untimed = {of: t for of, t in self.untimed.items() if of[0] not in dropped}
            case {"begin": key}:
                self.interrupted = key
            case {"program": stamp, "part": part, "state": state, "loaded": loaded}:
                self.programs[stamp] = program = Program(part, state, loaded)
                if not self._context.changes(program):
                    self._current_programs.add(stamp)
            case {"format": _, "history": history, "part": part, "axes": axes}:
                self.history.append(history)
                for name, values in axes.items() if part == self._context.part else ():
                    self.axes.setdefault(name, {}).update(dict.fromkeys(values))
            case _:
                raise ValueError(line)

    def _set_aside(self) -> None:
        """Move damaged lines to another file, and keep the others in the journal."""
        damaged = self.path.with_name(f"{self.path.name}.damaged")
        with open(  # noqa: PTH123 (a descriptor)
            open_descriptor(damaged, os.O_WRONLY | os.O_CREAT | os.O_APPEND), "ab"
        ) as aside:
            aside.writelines(self._damaged.values())
            aside.flush()
            os.fsync(aside.fileno())
        self._end -= sum(map(len, self._damaged.values()))
        with self.path.open("rb") as file, replacing(self.path) as partial:
            undamaged = [raw for number, raw in enumerate(file) if number not in self._damaged]
            partial.write_bytes(b"".join(undamaged)[: self._end])
            file.close()  # Windows replaces no open file
        self.notes.append(
            f"{len(self._damaged)} damaged lines of the journal are set aside in {damaged}; what they held is recomputed"
        )


def _point_key(point: Mapping[str, str]) -> object:
    """Return a point as a key that does not depend on the order of its axes."""
    return tuple(sorted(point.items()))

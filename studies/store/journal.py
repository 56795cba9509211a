"""The journal of a study: one line for each result, added as it arrives and never changed."""

import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any, Self

from contactstudy import InvalidInput
from contactstudy.domain.files import open_descriptor, reason, replacing, set_aside
from studies.model.outcome import Outcome, Sample
from studies.store.journal_lines import START, decoded, encoded, encoded_variable, short_hash
from studies.store.records import (
    FORMAT,
    MALFORMED_RECORD,
    CaseIdentity,
    Contents,
    Context,
    Program,
)

# Seconds after which lines are synced to the disk, which takes 0.3 ms; shorter cases are synced together.
SYNC_INTERVAL = 0.05


class Journal:
    """The journal of a study, read at once, and in a ``with`` statement open for writing.

    Every line starts with a checksum of its content. A line that fails it, or that this version does not write, goes to
    ``<path>.damaged`` when the journal is opened for writing, and its content counts as not stored; a torn last line is
    cut off. Lines are runs (study part, machine, time), values of an axis, programs (what was loaded), the beginning of
    a case, cases and their times. A case names its program, a line above. A journal of another format is set aside as a
    whole. Only one process at a time may write.

    Parameters
    ----------
    path
        The file, which need not exist.
    context
        Part of the study, and what would be loaded now; records of another program are kept apart.
    machine
        Name of this machine; times of another machine are kept apart.
    """

    def __init__(self, path: Path, context: Context, machine: str) -> None:
        self.path = path
        self.notes: list[str] = []
        self._context, self._machine = context, machine
        self._synced = monotonic()
        self._run = ""
        self._stamps: dict[tuple[int, str], tuple[object, str]] = {}
        self._read()

    def __enter__(self) -> Self:
        try:
            if self._is_foreign:
                aside = set_aside(self.path)
                self.notes.append(
                    f"the journal was written by another version: it is set aside as {aside.name}"
                )
            elif self._damaged:
                self._set_aside()
            self._descriptor = open_descriptor(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND)
            os.ftruncate(self._descriptor, self._end)
        except OSError as error:
            raise self._refused(error) from None
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if kind is None or not issubclass(kind, InvalidInput):
                self.sync()
        finally:
            os.close(self._descriptor)

    def start(self, history: str, axes: Mapping[str, Iterable[Any]]) -> None:
        """Begin a run of the present study.

        Parameters
        ----------
        history
            Time and command of the run.
        axes
            Values of each axis.
        """
        run = {"format": FORMAT, "part": dict(self._context.part), "machine": self._machine}
        self._run = short_hash(run)
        self._write({"run": self._run, "history": history} | run)
        self.contents.history.append(history)
        for name, values in axes.items():
            known_values = self.contents.axes.setdefault(name, {})
            new_values = [value for value in values if value not in known_values]
            known_values.update(dict.fromkeys(new_values))
            if new_values:
                self._write({"axis": name, "values": new_values, "run": self._run})
        self.sync()

    def stamp(self, state: str, loaded: Mapping[str, str]) -> str:
        """Return the stamp of a program of this run, which is written at its first case.

        Parameters
        ----------
        state
            State of the classes of the case.
        loaded
            What the process that computed it had loaded.
        """
        cached = self._stamps.get((id(loaded), state))
        if cached is None:
            program = {"part": dict(self._context.part), "state": state, "loaded": dict(loaded)}
            stamp = short_hash(program)
            if stamp not in self.contents.programs:
                self._write({"program": stamp} | program)
            # what this run computes counts in it, also where a file has been edited meanwhile
            self.contents.add_program(stamp, Program(**program), computes=True)  # type: ignore[arg-type]
            cached = self._stamps[id(loaded), state] = loaded, stamp
        return cached[1]

    def begin(self, key: str) -> None:
        """Write that this process begins a case, so that the next run knows the case in which a run died."""
        self._write({"begin": key})

    def add(self, identity: CaseIdentity, outcome: Outcome) -> bool:
        """Write a case, and return whether all cases so far are on disk."""
        line: dict[str, Any] = {
            "case": identity.key,
            "program": self.stamp(identity.state, outcome.loaded),
            "status": outcome.case_status.name.lower(),
            "point": dict(identity.point),
            "tree": identity.tree,
            "exact": identity.exact,
            "seconds": outcome.seconds,
            "cpu": outcome.cpu,
            "values": {name: encoded_variable(v) for name, v in outcome.variables.items()},
        }
        if outcome.failure is not None:
            line["failure"] = asdict(outcome.failure)
        raw = self._write(line)
        self.contents.records[identity.key] = self.contents.record(line, raw)
        if outcome.seconds > SYNC_INTERVAL / 2 or monotonic() - self._synced > SYNC_INTERVAL:
            self.sync()
            return True
        return False

    def time(self, key: str, sample: Sample) -> None:
        """Write a timed run of the case `key`."""
        case = self._write_time(key, {"sample": asdict(sample)})
        self.contents.samples.setdefault(case, []).append(sample)
        if monotonic() - self._synced > SYNC_INTERVAL:
            self.sync()

    def cannot_time(self, key: str, reason: str) -> None:
        """Write why the case `key` has no times; the next run does not time it."""
        self.contents.untimed[self._write_time(key, {"reason": reason})] = reason

    def _write_time(self, key: str, line: Mapping[str, Any]) -> tuple[str, str]:
        """Write a line on the times of a case, and return its key and the stamp of its program."""
        stamp = self.contents.records[key].stamp
        about = {"program": stamp, "machine": self._machine}
        self._write({"time": key} | about | dict(line))
        return key, stamp

    def forget_times(self) -> None:
        """Make all timed runs of earlier runs invalid."""
        self.contents.forget_times()
        self._write({"retime": self.contents.epoch})

    def sync(self) -> None:
        """Write everything through to the disk, in the file that has the journal's name.

        Raises
        ------
        InvalidInput
            If the disk is full, or the file has been removed.
        """
        try:
            os.fsync(self._descriptor)
        except OSError as error:
            raise self._refused(error) from None
        try:
            on_path, opened = self.path.lstat(), os.fstat(self._descriptor)
            is_same = (on_path.st_ino, on_path.st_dev) == (opened.st_ino, opened.st_dev)
        except OSError:
            is_same = False
        if not is_same:
            raise InvalidInput(
                f"Journal {str(self.path)!r} was removed or replaced while the run was writing it, and what it "
                "held is lost: run the same command again."
            )
        self._synced = monotonic()

    def _write(self, line: Mapping[str, Any]) -> bytes:
        """Write a line at the end of the file, and return it; cut it off where the disk takes only a part."""
        raw = encoded(line)
        try:
            unwritten = memoryview(raw)
            while unwritten:
                unwritten = unwritten[os.write(self._descriptor, unwritten) :]
        except OSError as error:
            with suppress(OSError):
                os.ftruncate(self._descriptor, self._end)
            raise self._refused(error) from None
        self._end += len(raw)
        return raw

    def _refused(self, error: OSError) -> InvalidInput:
        """Return the error of a journal that cannot be written."""
        return InvalidInput(
            f"Journal {str(self.path)!r} cannot be written ({reason(error)}): what was stored is kept; "
            "make room or give another folder with --out, and run the same command again."
        )

    def _read(self) -> None:
        """Read the journal from the start."""
        self.contents = Contents(self._context, self._machine)
        self._end, self._is_foreign = 0, False
        self._damaged: list[bytes] = []
        try:
            with open(open_descriptor(self.path, os.O_RDONLY), "rb") as file:  # noqa: PTH123 (a descriptor)
                self._read_lines(file)
        except FileNotFoundError:
            pass
        except OSError as error:
            raise InvalidInput(
                f"Journal {str(self.path)!r} cannot be read ({reason(error)}): give another folder with --out."
            ) from None

    def _read_lines(self, file: Iterable[bytes]) -> None:
        """Take in every line of the file without a torn last one."""
        first, is_journal = b"", False
        for raw in file:
            first = first or raw
            if not raw.endswith(b"\n"):
                break  # torn
            line = decoded(raw)
            is_journal |= line is not None
            if line is None or not self._accepted(line, raw):
                self._damaged.append(raw)
            self._end += len(raw)
        if not is_journal and first and not (first.startswith(START) or START.startswith(first)):
            raise InvalidInput(
                f"Journal {str(self.path)!r} is not a journal of this program: move the file away, or give "
                "another folder with --out."
            )
        if self.contents.is_foreign:
            self._is_foreign, self._end = True, 0
            self.contents = Contents(self._context, self._machine)

    def _accepted(self, line: Mapping[str, Any], raw: bytes) -> bool:
        """Take in a line, and return whether it has the form that this version writes."""
        try:
            self.contents.take(line, raw)
        except MALFORMED_RECORD:
            return False
        return True

    def _set_aside(self) -> None:
        """Move damaged lines to another file, and keep the others in the journal."""
        damaged = self.path.with_name(f"{self.path.name}.damaged")
        with open(  # noqa: PTH123 (a descriptor)
            open_descriptor(damaged, os.O_WRONLY | os.O_CREAT | os.O_APPEND), "ab"
        ) as aside:
            aside.writelines(self._damaged)
            aside.flush()
            os.fsync(aside.fileno())
        lines, bad = len(self._damaged), frozenset(self._damaged)
        with self.path.open("rb") as file, replacing(self.path) as partial:
            partial.write_bytes(b"".join(raw for raw in file if raw not in bad))
            file.close()  # Windows replaces no open file
        self._read()
        self.notes.append(
            f"{lines} damaged lines of the journal are set aside in {damaged}; what they held is recomputed"
        )

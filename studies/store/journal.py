"""The journal of a folder: the results of all its studies, one line each, in a file that is only ever appended to."""

import base64
import gc
import hashlib
import json
import os
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from time import monotonic
from typing import Any, Self

import numpy as np
import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.files import lock_descriptor, open_descriptor, reason
from studies.model.outcome import CaseStatus, Outcome, TimedRun
from studies.model.plain_text import counted

START = b'{"sum":"'
HEAD = len(START) + len('0123456789abcdef",')
# seconds between two syncs to the disk: what a loss of power may take; a killed program loses nothing
SYNC_INTERVAL = 1.0
ENCODER = json.JSONEncoder(separators=(",", ":"))
# errors that a line may raise which this version has not written
MALFORMED = (LookupError, TypeError, ValueError, AttributeError)
Line = Mapping[str, Any]
Key = tuple[str, str]  # the keys of a case and of the program that computed it


class Journal:
    """The journal of a folder, read at once, and in a ``with`` statement open to append.

    Every line is JSON that starts with a checksum of the rest. A line that fails it, such as the last one of a program
    that was killed, counts as not written and stays where it is. Lines are runs of a study, cases, and their timed runs.
    Several processes may append at the same time.

    Attributes
    ----------
    cases
        Lines of cases, the last one of each.
    samples, untimed
        Timed runs on this machine, or why there are none.
    programs
        Digests of the files and versions of each program.
    history
        Time and command of each run of a study.
    firsts
        First point of the last run of a study, and the case there.
    damaged
        Number of lines that cannot be read.
    reported
        Number of them at the last run, which has reported them.
    is_shared
        Whether another run has the file open to append.
    """

    def __init__(self, path: Path, machine: str) -> None:
        self.path, self.machine, self._synced = path, machine, monotonic()
        self.cases: dict[Key, Line] = {}
        self.samples: dict[Key, list[TimedRun]] = defaultdict(list)
        self.untimed: dict[Key, str] = {}
        self.programs: dict[str, Mapping[str, str]] = {}
        self.history: dict[str, list[str]] = defaultdict(list)
        self.firsts: dict[str, Line] = {}
        self.damaged = self.reported = 0
        self.is_shared = False
        try:
            content = self._content()
        except OSError as error:
            raise self._cannot("read", error, "give another folder with --out") from None
        # a program that was killed, or a full disk, leaves part of a line
        self._is_torn = bool(content) and not content.endswith(b"\n")
        lines = [raw for raw in content.split(b"\n") if raw]
        with without_garbage_collection():
            for raw in lines:
                try:
                    self._apply(decoded(raw))
                except MALFORMED:
                    self.damaged += 1
        if self.damaged == len(lines) and not content.startswith(START[: len(content)]):
            raise InvalidInput(
                f"Journal {str(self.path)!r} is not a journal of this program: move the file away, or give another "
                "folder with --out."
            )

    def _content(self) -> bytes:
        """Return the content of the file; none if it does not exist. A link is not followed."""
        try:
            descriptor = open_descriptor(self.path, os.O_RDONLY)
        except FileNotFoundError:
            return b""
        with open(descriptor, "rb") as file:  # noqa: PTH123 (a descriptor)
            return file.read()

    def __enter__(self) -> Self:
        try:
            self._file = open_descriptor(self.path, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
            if self._is_torn:
                os.write(self._file, b"\n")
        except OSError as error:
            raise self._cannot("written", error) from None
        try:
            lock_descriptor(self._file, wait=False)
        except BlockingIOError:
            self.is_shared = True
        except OSError:
            pass  # a file system without locks
        return self

    def __exit__(self, *raised: object) -> None:
        with suppress(OSError):
            os.fsync(self._file)
        os.close(self._file)

    def notes(self) -> Iterator[str]:
        """Yield sentences on another run in the folder, and on lines that are not used and were not reported."""
        if self.is_shared:
            yield f"another run writes to {self.path}: both compute the cases that neither has stored yet"
        if self.damaged > self.reported:
            name = self.path.name
            lines = counted(self.damaged, f"line of {name} is", f"lines of {name} are")
            yield f"{lines} damaged or of another version, and not used"

    def append(self, line: Line) -> None:
        """Append a line, and apply it.

        It is in the file when this returns, and on the disk with the next line after a second.

        Raises
        ------
        InvalidInput
            If the disk is full, or the file was removed.
        """
        raw = encoded(line)
        try:
            if os.write(self._file, raw) < len(raw):
                with suppress(OSError):
                    os.write(self._file, b"\n")  # the next line is whole
                raise OSError("the disk took a part of a line")
        except OSError as error:
            raise self._cannot("written", error) from None
        if monotonic() > self._synced + SYNC_INTERVAL:
            self.sync()
        self._apply({**line, "sum": raw[len(START) : HEAD - 2].decode()})

    def sync(self) -> None:
        """Write everything through to the disk, in the file that has the journal's name."""
        try:
            os.fsync(self._file)
            is_same = os.path.samestat(self.path.lstat(), os.fstat(self._file))
        except FileNotFoundError:
            is_same = False
        except OSError as error:
            raise self._cannot("written", error) from None
        if not is_same:
            raise InvalidInput(
                f"Journal {str(self.path)!r} was removed or replaced while the run was writing it, and what it "
                "held is lost: run the same command again."
            )
        self._synced = monotonic()

    def start(self, study: str, history: str, program: str, digests: Mapping[str, str], first: Line) -> None:
        """Begin a run of a study: write time and command, its first point, and the program where it is new."""
        news = {} if program in self.programs else {"digests": dict(digests)}
        about: dict[str, object] = {"study": study, "history": history, "program": program, "first": first}
        about |= {"damaged": self.damaged} if self.damaged else {}
        self.append(about | news)

    def add(self, key: Key, study: str, point: Mapping[str, Any], outcome: Outcome) -> None:
        """Write the outcome of a case, which `study` requests first at a `point`."""
        self.append({
            "case": key[0], "program": key[1], "study": study, "point": dict(point),
            "status": outcome.case_status.name, "seconds": outcome.seconds,
            "error": outcome.error,
            "values": {name: encoded_variable(v) for name, v in outcome.variables.items()},
        })  # fmt: skip

    def add_time(self, key: Key, outcome: Outcome) -> None:
        """Write a timed run of a case, or why it cannot be timed: then the next run does not try again."""
        time = {"sample": asdict(outcome.sample)} if outcome.sample else {"reason": outcome.error}
        self.append({"time": key[0], "program": key[1], "machine": self.machine} | time)

    def drop_times(self, keys: Iterable[Key]) -> None:
        """Make the timed runs of some cases on this machine invalid."""
        self.append({"retime": [list(key) for key in keys], "machine": self.machine})

    def status(self, key: Key) -> CaseStatus | None:
        """Return the status of a stored case; None without one."""
        return CaseStatus[self.cases[key]["status"]] if key in self.cases else None

    def outcome(self, key: Key) -> Outcome | None:
        """Return the outcome of a stored case; None without one."""
        line = self.cases.get(key)
        if line is None:
            return None
        variables = {name: decoded_variable(entry) for name, entry in line["values"].items()}
        return Outcome(CaseStatus[line["status"]], variables, line["error"], line["seconds"])

    def _apply(self, line: Line) -> None:
        """Take a line into the state."""
        is_here = line.get("machine", self.machine) == self.machine
        match line:
            case {
                "case": str(key),
                "program": str(program),
                "values": dict(),
                "seconds": float() | int(),
                "status": status,
                "error": str(),
            }:
                CaseStatus[status]
                self.cases[key, program] = line
            case {"time": key, "program": program, "sample": sample}:
                sample = TimedRun(**sample)
                if is_here:
                    self.samples[key, program].append(sample)
            case {"time": key, "program": program, "reason": why}:
                self.untimed |= {(key, program): why} if is_here else {}
            case {"retime": list(keys)}:
                for case, program in keys if is_here else ():
                    self.samples.pop((case, program), None)
                    self.untimed.pop((case, program), None)
            case {"study": study, "history": history, "program": program, "first": first}:
                self.history[study].append(history)
                self.firsts[study] = first
                self.reported = line.get("damaged", 0)
                self.programs.setdefault(program, line.get("digests", {}))
            case _:
                raise ValueError(line)

    def _cannot(
        self, what: str, error: OSError, remedy: str = "make room or give another folder with --out, and run the same "
        "command again"
    ) -> InvalidInput:  # fmt: skip
        """Return the error of a journal that cannot be used."""
        return InvalidInput(
            f"Journal {str(self.path)!r} cannot be {what} ({reason(error, self.path)}): what was stored is kept; "
            f"{remedy}."
        )


@contextmanager
def without_garbage_collection() -> Iterator[None]:
    """Disable garbage collection in a block that makes many lasting objects, where it would take a third of the time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def encoded(line: Line) -> bytes:
    """Return a line with its checksum, as bytes that end with a line feed."""
    content = ENCODER.encode(line).encode()[1:]
    return START + _checksum(content) + b'",' + content + b"\n"


def decoded(raw: bytes) -> Line:
    """Return the line; raise ValueError where its checksum is not that of its content."""
    if raw[:HEAD] != START + _checksum(raw[HEAD:]) + b'",':
        raise ValueError(raw)
    line: Line = json.loads(raw)
    return line


def _checksum(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=8).hexdigest().encode()


def encoded_variable(variable: xr.Variable) -> Sequence[Any]:
    """Return dimensions, dtype, shape, attributes and value of a variable, for JSON.

    A scalar stays a number, whose digits read back exactly; of other values the bytes are stored, in base64.
    """
    values = np.asarray(variable.values)
    is_plain = values.ndim == 0 and values.dtype.str in ("<f8", "<i8")
    value = values.item() if is_plain else base64.b64encode(values.tobytes()).decode()
    attrs = {str(name): _plain(entry) for name, entry in variable.attrs.items()}
    return [variable.dims, values.dtype.str, values.shape, attrs, value]


def decoded_variable(fields: Sequence[Any]) -> xr.Variable:
    """Return the variable that :func:`encoded_variable` encoded."""
    dims, dtype, shape, attrs, value = fields
    if isinstance(value, str):
        value = np.frombuffer(base64.b64decode(value), dtype).reshape(shape).copy()
    attributes = {
        name: np.array(*entry["array"])[()] if isinstance(entry, dict) else entry for name, entry in attrs.items()
    }
    return xr.Variable(tuple(dims), np.asarray(value, dtype), attributes)


def _plain(entry: Any) -> Any:
    """Return an attribute as JSON holds it."""
    if isinstance(entry, np.ndarray | np.generic):
        return {"array": [np.asarray(entry).tolist(), np.asarray(entry).dtype.str]}
    return entry

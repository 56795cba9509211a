"""Cases and programs that a journal holds, and the form of its lines.

A line is JSON that starts with a checksum of its content; its variables read back exactly.
"""

import base64
import gc
import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from contactstudy.domain.identity import Tree, differences
from studies.model.outcome import CaseStatus, Failure, Outcome
from studies.store.fingerprint.modules import CurrentModules

Json = Any
START = b'{"sum":"'
DIGITS = 16
_HEAD = len(START) + DIGITS
ENCODER = json.JSONEncoder(separators=(",", ":"))


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


@dataclass(frozen=True, eq=False)
class CaseIdentity:
    """A case: its key, its parameters as a tree, the state of its classes, and the first point that requests it.

    The key leaves out the fields at their defaults, `exact` does not.
    """

    key: str
    exact: str
    tree: Tree
    point: Mapping[str, str]
    state: str = ""


@dataclass(frozen=True, eq=False)
class Program:
    """Program that computed a case: digests of the study's part, state of the classes, and what was loaded.

    The part is the study's measures, the statements of its file that make numbers, and the files it depends on.
    """

    part: Mapping[str, str]
    state: str
    loaded: Mapping[str, str]


@dataclass(frozen=True, eq=False)
class Context:
    """Fingerprints of the present run, with which those of a stored case are compared.

    Attributes
    ----------
    part
        Digests of the study's part, as in :class:`Program`.
    modules
        What an import would load now.
    """

    part: Mapping[str, str]
    modules: CurrentModules = field(default_factory=CurrentModules)

    def changes(self, program: Program) -> list[str]:
        """Return the names of the parts and modules in which another program differs."""
        names = sorted(program.part.keys() | self.part.keys())
        differing = [name for name in names if program.part.get(name) != self.part.get(name)]
        return differing + self.modules.changes(program.loaded)


@dataclass(eq=False, slots=True)
class Record:
    """A stored case: its status, and its line in the journal, from which its values are read on use.

    `seconds` is its wall time [s], `exact` the hash of its parameters, defaults included, `stamp` the digest of the
    program that computed it, `state` that of its classes.
    """

    key: str
    case_status: CaseStatus
    seconds: float
    exact: str
    stamp: str
    state: str
    raw: bytes

    @property
    def identity(self) -> CaseIdentity:
        """Key, parameters and first point of the case."""
        line = json.loads(self.raw)
        return CaseIdentity(self.key, self.exact, line["tree"], line["point"], self.state)

    @property
    def outcome(self) -> Outcome:
        """Outcome of the case."""
        line = json.loads(self.raw)
        variables = {name: decoded_variable(entry) for name, entry in line["values"].items()}
        return Outcome(self.case_status, variables, failure_of(line), self.seconds)

    def is_of(self, identity: CaseIdentity) -> bool:
        """Return whether this record is of exactly this case, its defaults and the state of its classes included."""
        return self.state == identity.state and (
            self.exact == identity.exact or not differences(self.identity.tree, identity.tree)
        )


def failure_of(line: Mapping[str, Any]) -> Failure | None:
    """Return the failure in the line of a case; None without one."""
    return Failure(**line["failure"]) if "failure" in line else None


def encoded(line: Mapping[str, Any]) -> bytes:
    """Return a line with its checksum, as bytes that end with a line feed."""
    content = b'",' + ENCODER.encode(line).encode()[1:]
    return START + _checksum(content) + content + b"\n"


def decoded(raw: bytes) -> dict[str, Any] | None:
    """Return the line; None where its checksum is not that of its content."""
    content = raw[_HEAD:].rstrip(b"\n")
    if not raw.startswith(START) or raw[len(START) : _HEAD] != _checksum(content):
        return None
    try:
        line = json.loads(f"{{{content[2:].decode()}")
    except (ValueError, RecursionError):
        return None
    return line if isinstance(line, dict) else None


def _checksum(content: bytes) -> bytes:
    """Return the checksum of the content of a line."""
    return hashlib.blake2b(content, digest_size=DIGITS // 2).hexdigest().encode()


PLAIN = ("<f8", "<i8")  # dtypes of a scalar that JSON holds as a number


def encoded_variable(variable: xr.Variable) -> Json:
    """Return dimensions, dtype, shape, attributes and value of a variable, for JSON.

    A scalar real or whole number stays a number, whose shortest decimals read back exactly; any other value becomes
    the base64 of its bytes.
    """
    values = np.asarray(variable.values)
    if values.ndim == 0 and values.dtype.str in PLAIN:
        value = values.item()
    else:
        value = base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()
    kind = [list(variable.dims), values.dtype.str, list(values.shape)]
    return [*kind, _plain_attributes(variable.attrs), value]


def decoded_variable(fields: Json) -> xr.Variable:
    """Return the variable that :func:`encoded_variable` encoded."""
    dims, dtype, shape, attrs, value = fields
    if isinstance(value, str):
        value = np.frombuffer(base64.b64decode(value), dtype).reshape(shape).copy()
    attributes = {name: _attribute(value) for name, value in attrs.items()}
    return xr.Variable(tuple(dims), np.asarray(value, dtype), attributes)


def _plain_attributes(attrs: Mapping[Any, Any]) -> dict[str, Json]:
    """Return attributes as JSON holds them."""
    plain: dict[str, Json] = {}
    for name, value in attrs.items():
        if isinstance(value, np.ndarray | np.generic):
            value = np.asarray(value)
            plain[str(name)] = {"dtype": value.dtype.str, "values": value.tolist()}
        else:
            plain[str(name)] = value
    return plain


def _attribute(value: Json) -> Any:
    """Return an attribute from its JSON."""
    if isinstance(value, dict):
        return np.array(value["values"], value["dtype"])[()]
    return value

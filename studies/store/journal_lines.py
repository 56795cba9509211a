"""Lines of a journal: JSON that starts with a checksum of its content, and variables in them, to the last bit."""

import base64
import hashlib
import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

START = b'{"sum":"'
DIGITS = 16
_HEAD = len(START) + DIGITS


def encoded(line: Mapping[str, Any]) -> bytes:
    """Return a line with its checksum, as bytes that end with a line feed."""
    content = b'",' + json.dumps(line, separators=(",", ":")).encode()[1:]
    return START + _checksum(content) + content + b"\n"


def decoded(raw: bytes) -> dict[str, Any] | None:
    """Return the line; None where its checksum is not that of its content."""
    content = raw[_HEAD:].rstrip(b"\n")
    if not raw.startswith(START) or raw[len(START) : _HEAD] != _checksum(content):
        return None
    try:
        line = json.loads(b"{" + content[2:])
    except (ValueError, RecursionError):
        return None
    return line if isinstance(line, dict) else None


def _checksum(content: bytes) -> bytes:
    """Return the checksum of the content of a line."""
    return hashlib.blake2b(content, digest_size=DIGITS // 2).hexdigest().encode()


def short_hash(tree: object) -> str:
    """Return twelve digits of a hash of a value's JSON, the name of what is written once and referred to."""
    text = json.dumps(tree, separators=(",", ":"), sort_keys=True).encode()
    return hashlib.blake2b(text, digest_size=6).hexdigest()


Json = Any


class VariableTypes:
    """Types of variables (dimensions, dtype, attributes), each written once and then referred to by a name.

    The name is a hash of the content. A scalar real or whole number stands as JSON, whose shortest
    decimals read back exactly; anything else as the base64 of its bytes.
    """

    def __init__(self) -> None:
        self._known: dict[str, Json] = {}
        self._names: dict[object, str] = {}

    def encode(
        self, variables: Mapping[str, xr.Variable]
    ) -> tuple[Mapping[str, Json], Mapping[str, Json]]:
        """Return the types that are new, by their names, and the variables as pairs of type name and value."""
        new: dict[str, Json] = {}
        written = {}
        for name, variable in variables.items():
            values = np.asarray(variable.values)
            kind = self._name(variable.dims, values, variable.attrs, new)
            is_plain = values.ndim == 0 and values.dtype.str in ("<f8", "<i8")
            written[name] = [kind, values.item() if is_plain else _to_text(values)]
        return new, written

    def add(self, name: str, kind: Json) -> None:
        """Add a type that was read; raise an error of Python's for one that :meth:`encode` does not make."""
        dims, dtype, shape, attrs = kind
        if name != short_hash(kind) or np.dtype(dtype).kind not in "biufcSUmM":
            raise ValueError(kind)
        xr.Variable(dims, np.empty([0 for _ in shape], dtype))
        {key: _attribute(value) for key, value in attrs.items()}
        if any(type(size) is not int or size < 0 for size in shape):
            raise ValueError(kind)
        self._known[name] = kind

    def fit(self, variables: Mapping[str, Json]) -> bool:
        """Return whether the types of all variables are known; raise an error of Python's for a value of another one."""
        return all(self._fits(*variable) for variable in variables.values())

    def _fits(self, kind: str, payload: Json) -> bool:
        """Return whether the type of a value is known; raise an error where the value is not of that type."""
        if kind not in self._known:
            return False
        _, dtype, shape, _ = self._known[kind]
        if isinstance(payload, str):
            size = len(base64.b64decode(payload, validate=True))
            if size != np.dtype(dtype).itemsize * math.prod(shape):
                raise ValueError(payload)
        elif (
            shape
            or payload != payload
            or {"<f8": float, "<i8": int}.get(dtype) is not type(payload)
        ):
            raise TypeError(payload)
        return True

    def decode(self, variables: Mapping[str, Json]) -> Mapping[str, xr.Variable]:
        """Return the variables that :meth:`encode` encoded."""
        return {
            name: self._decoded(*encoded_variable) for name, encoded_variable in variables.items()
        }

    def _decoded(self, kind: str, payload: Json) -> xr.Variable:
        """Return a variable from the name of its type and its value."""
        dims, dtype, shape, attrs = self._known[kind]
        if isinstance(payload, str):
            flat = np.frombuffer(base64.b64decode(payload), np.dtype(dtype))
            values = flat.reshape(shape).copy()
        else:
            values = np.array(payload, dtype)
        return xr.Variable(tuple(dims), values, {k: _attribute(v) for k, v in attrs.items()})

    def _name(
        self,
        dims: tuple[Any, ...],
        values: np.ndarray,
        attrs: Mapping[Any, Any],
        new: dict[str, Json],
    ) -> str:
        """Return the name of a variable's type, and add the type to `new` at its first use."""
        try:
            # 1, 1.0 and True are equal as keys of a dict, but differ as attributes
            typed_attrs = tuple((name, type(value), value) for name, value in attrs.items())
            signature: object = (dims, values.dtype.str, values.shape, typed_attrs)
            if signature in self._names:
                return self._names[signature]
        except TypeError:  # an attribute that is an array
            signature = None
        kind = [list(dims), values.dtype.str, list(values.shape), _plain_attributes(attrs)]
        name = short_hash(kind)
        if name not in self._known:
            self._known[name] = new[name] = kind
        if signature is not None:
            self._names[signature] = name
        return name


def _to_text(values: np.ndarray) -> str:
    """Return the bytes of an array as base64."""
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()


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

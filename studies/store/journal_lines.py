"""Lines of a journal: JSON that starts with a checksum of its content, with variables that read back exactly."""

import base64
import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

START = b'{"sum":"'
DIGITS = 16
_HEAD = len(START) + DIGITS
ENCODER = json.JSONEncoder(separators=(",", ":"))


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


Json = Any
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

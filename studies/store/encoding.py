"""Variables as JSON and back, to the last bit."""

import base64
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

Json = Any


class VariableTypes:
    """Dimensions, type and attributes of variables, each written once and then called by a number.

    A scalar real or whole number stands as JSON, whose shortest decimals read back as they were;
    anything else as the base64 of its bytes.
    """

    def __init__(self) -> None:
        self._known: list[Json] = []
        self._numbers: dict[object, int] = {}

    def encode(self, variables: Mapping[str, xr.Variable]) -> tuple[list[Json], Mapping[str, Json]]:
        """The kinds that are new, and the variables in terms of kinds."""
        before, found = len(self._known), {}
        for name, variable in variables.items():
            values = np.asarray(variable.values)
            number = self._number(variable.dims, values, variable.attrs)
            is_plain = values.ndim == 0 and values.dtype.str in ("<f8", "<i8")
            payload = values.item() if is_plain else _to_text(values)
            found[name] = [number, payload]
        return self._known[before:], found

    def add(self, kind: Json) -> None:
        """A kind that was read."""
        self._known.append(kind)

    def decode(self, variables: Mapping[str, Json]) -> Mapping[str, xr.Variable]:
        """The variables that were encoded."""
        return {name: self._decoded(*held) for name, held in variables.items()}

    def _decoded(self, number: int, payload: Json) -> xr.Variable:
        dims, dtype, shape, attrs = self._known[number]
        if isinstance(payload, str):
            flat = np.frombuffer(base64.b64decode(payload), np.dtype(dtype))
            values = flat.reshape(shape).copy()
        else:
            values = np.array(payload, dtype)
        return xr.Variable(tuple(dims), values, {k: _attribute(v) for k, v in attrs.items()})

    def _number(self, dims: tuple[Any, ...], values: np.ndarray, attrs: Mapping[Any, Any]) -> int:
        try:
            name: object = (dims, values.dtype.str, values.shape, tuple(attrs.items()))
            if name in self._numbers:
                return self._numbers[name]
        except TypeError:  # an attribute that is an array
            name = None
        kind = [list(dims), values.dtype.str, list(values.shape), _plain_attributes(attrs)]
        if name is None:
            name = json.dumps(kind)
        if name not in self._numbers:
            if kind not in self._known:
                self._known.append(kind)
            self._numbers[name] = self._known.index(kind)
        return self._numbers[name]


def _to_text(values: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()


def _plain_attributes(attrs: Mapping[Any, Any]) -> dict[str, Json]:
    found: dict[str, Json] = {}
    for name, value in attrs.items():
        if isinstance(value, np.ndarray | np.generic):
            value = np.asarray(value)
            found[str(name)] = {"dtype": value.dtype.str, "values": value.tolist()}
        elif isinstance(value, bool | None | Mapping):  # netCDF has none of these
            found[str(name)] = str(value)
        else:
            found[str(name)] = value
    return found


def _attribute(value: Json) -> Any:
    if isinstance(value, dict):
        return np.array(value["values"], value["dtype"])[()]
    return value

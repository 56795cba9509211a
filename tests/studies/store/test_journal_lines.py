"""One line of a journal, byte for byte."""

import json
import struct
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from studies.store.journal_lines import (
    decoded,
    decoded_variable,
    encoded,
    encoded_variable,
)

LINE = {"case": "a", "value": 1.5}


@pytest.mark.parametrize("place", range(len(encoded(LINE)) - 1))
def test_a_byte_that_changed_anywhere_is_noticed(place: int) -> None:
    raw = bytearray(encoded(LINE))
    raw[place] ^= 1
    assert decoded(bytes(raw)) is None


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
        np.array([0.1, -0.0, np.nan, np.inf]),
        np.float32(0.1),
        np.array([[1, 2], [3, 4]], dtype=np.int8),
        np.array(2**62 + 1),
        np.uint64(2**64 - 1),
        np.bool_(1),
        np.array(["a", "größer"]),
        np.array(["2020-01-01"], dtype="datetime64[ns]"),
        np.array(1 + 2j),
        np.zeros((0, 3)),
        np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    ],
    ids=str,
)
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

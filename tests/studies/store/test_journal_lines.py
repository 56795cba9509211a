"""One line of a journal, byte for byte."""

import hashlib
import json
import struct
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from studies.store.journal_lines import VariableTypes, decoded, encoded, short_hash

LINE = {"case": "a", "value": 1.5}
REST = b'","case":"a","value":1.5}'


def test_a_line_starts_with_sixteen_digits_of_the_checksum_of_the_rest() -> None:
    digits = hashlib.blake2b(REST, digest_size=8).hexdigest().encode()
    assert encoded(LINE) == b'{"sum":"' + digits + REST + b"\n"
    assert decoded(encoded(LINE)) == LINE
    assert decoded(encoded(LINE).rstrip()) == LINE


@pytest.mark.parametrize("place", range(len(encoded(LINE)) - 1))
def test_a_byte_that_changed_anywhere_is_noticed(place: int) -> None:
    raw = bytearray(encoded(LINE))
    raw[place] ^= 1
    assert decoded(bytes(raw)) is None


def test_a_line_that_is_cut_or_no_table_is_none() -> None:
    assert decoded(encoded(LINE)[:-3]) is None
    assert decoded(b"") is None


def test_a_name_is_twelve_digits_whatever_the_order_of_keys() -> None:
    assert short_hash({"a": 1, "b": 2}) == short_hash({"b": 2, "a": 1})
    assert len(short_hash({"a": 1})) == 12
    assert short_hash({"a": 1}) != short_hash({"a": 2})


def there_and_back(variables: dict[str, xr.Variable]) -> dict[str, xr.Variable]:
    writer, reader = VariableTypes(), VariableTypes()
    kinds, values = writer.encode(variables)
    kinds, values = json.loads(json.dumps([kinds, values]))
    for name, kind in kinds.items():
        reader.add(name, kind)
    return dict(reader.decode(values))


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


def test_what_is_the_same_of_many_is_written_once_under_a_name_that_says_what_it_is() -> None:
    types = VariableTypes()
    first, values = types.encode({"a": xr.Variable((), 1.0, {"units": "m"})})
    second, others = types.encode({"a": xr.Variable((), 2.0, {"units": "m"})})
    (name,) = first
    assert (second, values, others) == ({}, {"a": [name, 1.0]}, {"a": [name, 2.0]})
    apart, _ = types.encode({"a": xr.Variable((), 2.0, {"units": "mm"})})
    assert list(apart) != [name]
    assert list(VariableTypes().encode({"b": xr.Variable((), 3.0, {"units": "m"})})[0]) == [name]


def test_attributes_that_are_equal_as_numbers_but_of_other_types_are_told_apart() -> None:
    types = VariableTypes()
    encoded = {str(x): types.encode({"a": xr.Variable((), 1.0, {"x": x})})[1] for x in (1, 1.0)}
    back = [type(types.decode(values)["a"].attrs["x"]) for values in encoded.values()]
    assert back == [int, float]

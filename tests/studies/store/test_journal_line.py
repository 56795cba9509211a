"""One line of a journal, byte for byte."""

import hashlib

import pytest

from studies.store.lines.journal_line import decoded, encoded, short_hash

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

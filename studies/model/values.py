"""Values in a text, as on the command line: numbers with units, ranges, lists and tables."""

import re
import tomllib
from collections.abc import Iterator

import numpy as np

from contactstudy import InvalidInput

MAX_VALUES = 1_000_000  # of an axis, and points of a study above which a user must confirm
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
QUANTITY = re.compile(rf"({NUMBER})\s*(.*)")
RANGE = re.compile(
    rf"({NUMBER})\s*([^:,\d]*):\s*({NUMBER})\s*([^:,\d][^:,]*)?(?::\s*(\d+)\s*(?::\s*(log))?\s*([^:]*))?"
)
FORMS = (
    "give values separated by commas, such as 50 N/mm,100 N/mm, or a range with its number of values, such "
    "as 50:400:8 N/mm or, in equal ratios, 50:400:8:log N/mm"
)
OPEN, CLOSED = "[{", "]}"


def parse_values(field: str, text: str, number_type: type) -> list[object]:
    """Return the values in a text as a scene file could hold them: numbers, texts, lists, tables.

    ``50:400:8 N/mm`` is eight values from 50 to 400 N/mm, ``50:400:8:log N/mm`` in equal ratios, and for a field of
    whole numbers ``0:10`` all from 0 to 10. A unit after the last of several numbers applies to all of them.
    Raises :class:`~contactstudy.InvalidInput` for a text that is none of these.
    """
    parts = [part.strip() for part in _split(field, text)]
    if not all(parts) or not parts:
        raise InvalidInput(f"{field} is {text!r}, which lacks a value: {FORMS}.")
    values = [value for part in parts for value in _expanded(field, part, number_type)]
    return _with_shared_unit(field, text, values)


def _split(field: str, text: str) -> Iterator[str]:
    """Yield the parts of a text between commas that are in no bracket and no quotation."""
    depth, quote, begin = 0, "", 0
    for index, letter in enumerate(text):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter in OPEN:
            depth += 1
        elif letter in CLOSED:
            depth -= 1
        elif letter == "," and depth == 0:
            yield text[begin:index]
            begin = index + 1
    if depth or quote:
        raise InvalidInput(f"{field} is {text!r}: close its brackets and quotation marks.")
    yield text[begin:]


def _expanded(field: str, part: str, number_type: type) -> list[object]:
    """Return the values of one part of a text: a value, or all values of a range."""
    if part[0] in OPEN + "\"'":
        try:
            return [tomllib.loads(f"value = {part}")["value"]]
        except tomllib.TOMLDecodeError as error:
            raise InvalidInput(f"{field} is {part!r}, which is not valid TOML: {error}.") from None
    match = RANGE.fullmatch(part)
    if match is None:
        return [_plain(part)]
    groups = ((group or "").strip() for group in match.groups())
    first, first_unit, last, last_unit, count, log, unit = groups
    units = {group for group in (first_unit, last_unit, unit) if group}
    # without a count, all whole numbers between the ends; an end may be infinite as a float
    between = min(float(last) - float(first), 1e18) if number_type is int else 0
    check_count(field, int(count or between), "values")
    if len(units) > 1:
        raise InvalidInput(f"{field} is {part!r}, which has the units {sorted(units)}: write both ends in one unit.")
    values = _between(first, last, count, log, kind=number_type)
    if values is None:
        raise InvalidInput(
            f"{field} is {part!r}: give a rising range with its number of values, such as {first}:{last}:8, with :log "
            "behind it for equal ratios above 0, or of whole numbers such as 0:10."
        )
    suffix = f" {units.pop()}" if units else ""
    return [f"{value:.12g}{suffix}" if suffix else value for value in values]


def _between(first: str, last: str, count: str, spacing: str, *, kind: type) -> list[float] | None:
    """Return the values of a range, of type `kind`, both ends included; None for text that is not a range.

    Without a `count` they are all whole numbers between the ends. A range rises and has at least two values. With the
    `spacing` "log" it has equal ratios and begins above 0; one of whole numbers has whole ends.
    """
    low, high, is_integer = float(first), float(last), kind is int
    if is_integer and not (low.is_integer() and high.is_integer()):
        return None
    if not count:
        return [*range(int(low), int(high) + 1)] if is_integer and low <= high else None
    if int(count) < 2 or low >= high or (spacing and low <= 0):
        return None
    spaced = (np.geomspace if spacing else np.linspace)(low, high, int(count))
    if is_integer:
        rounded = np.round(spaced).astype(int)
        if not spacing and np.abs(spaced - rounded).max() > 1e-9 * max(-low, high):
            return None
        return [int(value) for value in np.unique(rounded)]
    # rounded to twelve digits, so that 3e-07 is not 3.0000000000000004e-07
    return [float(f"{value:.12g}") for value in spaced]


def check_count(name: str, count: int, what: str, max_count: int = MAX_VALUES) -> None:
    """Raise InvalidInput for more than `max_count` values."""
    if count > max_count:
        raise InvalidInput(f"{name} has {count} {what}, more than {max_count}: give fewer.")


def _plain(part: str) -> object:
    """Return a text as a boolean or a number, if it is one."""
    if part in ("true", "false"):
        return part == "true"
    for kind in (int, float):
        try:
            return kind(part)
        except ValueError:
            continue
    return part


def _with_shared_unit(field: str, text: str, values: list[object]) -> list[object]:
    """Return values with the unit of the last number given to those before it, if it alone has one."""
    bare = [isinstance(value, int | float) and not isinstance(value, bool) for value in values]
    last = QUANTITY.fullmatch(values[-1]) if isinstance(values[-1], str) else None
    if not any(bare) or last is None or not last[2]:
        return values
    if not all(bare[:-1]):
        raise InvalidInput(
            f"{field} is {text!r}, where some numbers have a unit and some have none: give each its unit, "
            "or the last one alone."
        )
    return [f"{value} {last[2]}" for value in values[:-1]] + values[-1:]

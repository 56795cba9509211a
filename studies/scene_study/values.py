"""The values of a varied field, as a person writes them: lists, ranges, TOML."""

import re
import tomllib
from collections.abc import Iterator

import numpy as np

from contactstudy import InvalidInput
from studies.model.axis import check_count

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
QUANTITY = re.compile(rf"({NUMBER})\s*(.*)")
RANGE = re.compile(
    rf"({NUMBER})\s*([^:,\d]*):\s*({NUMBER})\s*([^:,\d][^:,]*)?(?::\s*(\d+)\s*(?::\s*(log))?\s*([^:]*))?"
)
FORMS = (
    "give values separated by commas, such as 50 N/mm,100 N/mm, or a range with its number of values, such "
    "as 50:400:8 N/mm or, in equal ratios, 50:400:8:log N/mm"
)
MOST = 100_000
OPEN, CLOSED = "[{", "]}"


def parse_values(field: str, text: str, *, whole: bool) -> list[object]:
    """``text`` as what a scene file could hold in the place of ``field``: numbers, texts, lists, tables.

    ``50:400:8 N/mm`` is eight values from 50 to 400 N/mm, ``50:400:8:log N/mm`` in equal ratios. For a
    field of ``whole`` numbers ``0:10`` is all from 0 to 10 and ``0:10:2`` every second. A unit after the last
    of several numbers is that of all. Raises :class:`~contactstudy.InvalidInput` for what is none of these.
    """
    parts = [part.strip() for part in _split(field, text)]
    if not all(parts) or not parts:
        raise InvalidInput(f"{field} is {text!r}, which lacks a value: {FORMS}.")
    values = [value for part in parts for value in _expanded(field, part, whole)]
    return _with_shared_unit(field, text, values)


def _split(field: str, text: str) -> Iterator[str]:
    """At the commas that are in no bracket and no quotation."""
    depth, quote, begin = 0, "", 0
    for place, letter in enumerate(text):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter in OPEN:
            depth += 1
        elif letter in CLOSED:
            depth -= 1
        elif letter == "," and depth == 0:
            yield text[begin:place]
            begin = place + 1
    if depth or quote:
        raise InvalidInput(f"{field} is {text!r}: close its brackets and quotation marks.")
    yield text[begin:]


def _expanded(field: str, part: str, whole: bool) -> list[object]:  # noqa: FBT001 (passed on)
    if part[0] in OPEN + "\"'":
        try:
            return [tomllib.loads(f"value = {part}")["value"]]
        except tomllib.TOMLDecodeError as error:
            raise InvalidInput(f"{field} is {part!r}, which is not valid TOML: {error}.") from None
    found = RANGE.fullmatch(part)
    if found is None:
        return [_plain(part)]
    first, first_unit, last, last_unit, count, log, unit = (
        (one or "").strip() for one in found.groups()
    )
    units = {one for one in (first_unit, last_unit, unit) if one}
    if len(units) > 1:
        raise InvalidInput(
            f"{field} is {part!r}, which has the units {sorted(units)}: write both ends in one unit."
        )
    if whole:
        return list(_whole_range(field, part, first, last, count))
    if not count or int(count) < 2:
        raise InvalidInput(
            f"{field} is {part!r}: give the number of values, 2 or more, as in {first}:{last}:8."
        )
    ends = float(first), float(last)
    if log and min(ends) <= 0:
        raise InvalidInput(
            f"{field} is {part!r}: give ends above 0 for a range in equal ratios, or leave out log."
        )
    check_count(field, int(count), "values", MOST)
    spaced = np.geomspace(*ends, int(count)) if log else np.linspace(*ends, int(count))
    suffix = f" {units.pop()}" if units else ""
    # to twelve digits, so that the number that was meant comes out: 3e-07 and not 3.0000000000000004e-07
    return [f"{value:.12g}{suffix}" if suffix else float(f"{value:.12g}") for value in spaced]


def _whole_range(field: str, part: str, first: str, last: str, step: str) -> range:
    try:
        bounds = range(int(first), int(last) + 1, int(step or 1))
    except ValueError:
        bounds = range(0)
    if not bounds:
        raise InvalidInput(
            f"{field} is {part!r}: give a rising range of whole numbers, such as 0:10, or 0:10:2 for "
            "every second."
        )
    check_count(field, len(bounds), "values", MOST)
    return bounds


def _plain(part: str) -> object:
    if part in ("true", "false"):
        return part == "true"
    for kind in (int, float):
        try:
            return kind(part)
        except ValueError:
            continue
    return part


def _with_shared_unit(field: str, text: str, values: list[object]) -> list[object]:
    """The unit of the last number for those before it, where it alone has one."""
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

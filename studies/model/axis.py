"""Axes of a study: their values, and the notation of values in text: numbers with units, ranges, lists and tables."""

import math
import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.validation import suggestion
from studies.model.plain_text import is_storable, name_problem, shortened

if TYPE_CHECKING:
    import xarray as xr

Value = str | int | float
# What to give for values of each type.
FORMS = {
    int: "give whole numbers such as 0,1,6, a range such as 0:10, or n values of a range such as 32:1024:6:log",
    float: "give numbers such as 0.6,2.4, or n values of a range such as 0.6:2.4:4 or 1:100:3:log",
    str: "give names separated by commas",
}
MAX_VALUES = 1_000_000  # of an axis, and points of a study above which a user must confirm
# A number; a number with a unit; a range such as "50:400:8:log N/mm", with its unit behind any of the numbers.
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
QUANTITY = re.compile(rf"({NUMBER})\s*(.*)")
RANGE = re.compile(
    rf"({NUMBER})\s*([^:,\d]*):\s*({NUMBER})\s*([^:,\d][^:,]*)?(?::\s*(\d+)\s*(?::\s*(log))?\s*([^:]*))?"
)
# What to give for a text that lacks a value.
EXAMPLES = (
    "give values separated by commas, such as 50 N/mm,100 N/mm, or a range with its number of values, such "
    "as 50:400:8 N/mm or, in equal ratios, 50:400:8:log N/mm"
)
OPEN, CLOSED = "[{", "]}"  # brackets, in which a comma divides no values


def one_of(field: str, value: object, names: Iterable[str]) -> str:
    """Return `value` if it is one of the `names`.

    Raises
    ------
    InvalidInput
        For any other value, with the field `field` and the nearest name.
    """
    choices = list(names)
    if value not in choices:
        raise InvalidInput(f"{field} is {value!r}: {suggestion(str(value), choices)}.")
    return str(value)


@dataclass(frozen=True)
class Axis:
    """Values of one parameter, all of one type, with the labels of a Dataset's coordinate.

    Parameters
    ----------
    name
        Name of the coordinate.
    values
        Names, or numbers.
    long_name
        Description for people.
    units
        Unit of the numbers.

    Raises
    ------
    InvalidInput
        For a name or text that netCDF cannot hold, values of several types, or one that is not finite or stands twice.
    """

    name: str
    values: tuple[Value, ...]
    long_name: str
    units: str = "1"

    def __post_init__(self) -> None:
        if problem := name_problem(self.name):
            raise InvalidInput(f"Axis name {shortened(self.name)}: {problem}.")
        for part in ("long_name", "units"):
            text = getattr(self, part)
            if not isinstance(text, str) or not is_storable(text):
                raise self._invalid(f"the {part} {shortened(text)}: give text without control characters")
        raw: object = self.values
        if isinstance(raw, str) or not isinstance(raw, Iterable):
            raise self._invalid(f"values {shortened(raw)}: give a tuple of them")
        # numpy's scalars become Python's, and one number with a fraction makes all of them such
        values = tuple(value.item() if isinstance(value, np.generic) else value for value in self.values)
        kinds = {type(value) for value in values}
        if not (kinds == {str} or (kinds and kinds <= {int, float})):
            raise self._invalid(f"values {shortened(values)}: give names, or numbers, and not both")
        for value in values:
            if isinstance(value, str) and not is_storable(value):
                raise self._invalid(f"the value {value!a}: give plain text")
            if isinstance(value, int) and abs(value) > 2**53:
                raise self._invalid(f"the value {shortened(value)}: give whole numbers up to 2^53")
            if isinstance(value, float) and not math.isfinite(value):
                raise self._invalid(f"the value {value}: give finite numbers")
        if len(set(values)) < len(values):
            twice = next(value for value in values if values.count(value) > 1)
            raise self._invalid(f"the value {twice!r} twice: give it once")
        object.__setattr__(self, "values", tuple(map(float, values)) if float in kinds else values)

    def _invalid(self, what: str) -> InvalidInput:
        """Return the error of what the axis has."""
        return InvalidInput(f"Axis {self.name!r} has {what}.")

    @property
    def coordinate(self) -> "xr.Variable":
        """Values with long name and units, as a Dataset has them; names have no units."""
        import xarray as xr  # not where studies are only listed

        units = {} if self.kind is str else {"units": self.units}
        return xr.Variable((self.name,), list(self.values), {"long_name": self.long_name} | units)

    @property
    def kind(self) -> type:
        """Type of the values, int, float or str."""
        return type(self.values[0])

    def override(self, values: str | Iterable[Value]) -> "Axis":
        """Return this axis with other values.

        Parameters
        ----------
        values
            Text such as ``"0:10"`` or ``"0.6,2.4"``, or numbers or names.

        Raises
        ------
        InvalidInput
            For values that are not of the axis's type, and for too many.
        """
        raw: Iterable[Any] = values
        if isinstance(values, str):
            is_named = self.kind is str
            raw = map(str.strip, values.split(",")) if is_named else parse_values(self.name, values, self.kind)
        parsed = dict.fromkeys(map(self._convert, raw))
        check_count(self.name, len(parsed), "values")
        if self.kind is not str:  # figures and findings read from the least to the largest
            parsed = dict.fromkeys(sorted(parsed))
        if not parsed:
            raise InvalidInput(f"{self.name} is {shortened(values)}: {FORMS[self.kind]}.")
        return Axis(self.name, tuple(parsed), self.long_name, self.units)

    def _convert(self, value: Any) -> Value:
        """Return a value as the type of this axis."""
        try:
            if isinstance(value, bool) or (self.kind is str and not isinstance(value, str)):
                raise TypeError
            converted = self.kind(value)
            exact = self.kind is not int or float(value) == converted
        except (TypeError, ValueError, OverflowError):
            exact = False
        if not exact or (self.kind is float and not math.isfinite(converted)):
            raise InvalidInput(f"{self.name} is {shortened(value)}: {FORMS[self.kind]}.")
        return converted  # type: ignore[no-any-return]


def parse_values(field: str, text: str, number_type: type) -> list[object]:
    """Return the values in a text as a scene file could hold them: numbers, texts, lists, tables.

    ``50:400:8 N/mm`` is eight values from 50 to 400 N/mm, ``50:400:8:log N/mm`` in equal ratios, and for a field of
    whole numbers ``0:10`` all from 0 to 10. A unit after the last of several numbers applies to all of them.
    Raises :class:`~contactstudy.InvalidInput` for a text that is none of these.
    """
    parts = [part.strip() for part in _split(field, text)]
    if not all(parts) or not parts:
        raise InvalidInput(f"{field} is {text!r}, which lacks a value: {EXAMPLES}.")
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

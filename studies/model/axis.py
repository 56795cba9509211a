"""Axes of a study: their values, and the notation of values in text."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence, Sized
from dataclasses import dataclass, field
from itertools import chain, islice
from typing import TYPE_CHECKING

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.checks import suggestion
from contactstudy.domain.device import available_bytes
from studies.model.plain_text import is_storable, name_problem, shortened

if TYPE_CHECKING:
    import xarray as xr

Value = str | int | float
# largest difference of two equal numbers, relative to the axis' span and to the larger of them
EQUAL_WITHIN = 1e-12
MAX_POINTS = 1_000_000  # points of a study above which a user must confirm
CONFIRM = "give fewer, or run it from Python with RunOptions(max_points=None)"
POINT_BYTES = 500  # memory that a point takes at least, its key and its place in the table

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
# first:last, first:last:count or first:last:count:log
RANGE = re.compile(rf"({NUMBER})\s*:\s*({NUMBER})(?:\s*:\s*(\d+)(?:\s*:\s*(log))?)?")

FORMS = {
    int: "give whole numbers such as 0,1,6, a range such as 0:10, or n values of a range such as 32:1024:6:log",
    float: "give numbers such as 0.6,2.4, or n values of a range such as 0.6:2.4:4 or 1:100:3:log",
    str: "give names separated by commas",
}


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

    Numbers that differ by rounding alone, by less than 1e-12 of the axis' span and of themselves, count as one value,
    such as 0.3 and 3 * 0.1.

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

    Attributes
    ----------
    merged
        Number of values that were merged into another one.

    Raises
    ------
    InvalidInput
        For a name or text that netCDF cannot hold, values of several types, or one that is not finite or stands twice.
    """

    name: str
    values: tuple[Value, ...]
    long_name: str
    units: str = "1"
    merged: int = field(init=False, compare=False)

    def __post_init__(self) -> None:
        if problem := name_problem(self.name):
            raise InvalidInput(f"Axis name {shortened(self.name)}: {problem}.")
        for part, text in (("long_name", self.long_name), ("units", self.units)):
            if not isinstance(text, str) or not is_storable(text):
                raise InvalidInput(
                    f"Axis {self.name!r} has the {part} {shortened(text)}: give text without control characters."
                )
        raw: object = self.values
        if isinstance(raw, str) or not isinstance(raw, Iterable):
            raise InvalidInput(
                f"Axis {self.name!r} has values {shortened(self.values)}: give a tuple of them."
            )
        # numpy's scalars become Python's, and one number with a fraction makes all of them such
        values = tuple(
            value.item() if isinstance(value, np.generic) else value for value in self.values
        )
        kinds = {type(value) for value in values}
        if not (kinds == {str} or (kinds and kinds <= {int, float})):
            raise InvalidInput(
                f"Axis {self.name!r} has values {shortened(values)}: give names, or numbers, and not both."
            )
        if float in kinds:
            values = tuple(self._finite(value) for value in values)
        for value in values:
            if isinstance(value, str) and not is_storable(value):
                raise InvalidInput(f"Axis {self.name!r} has the value {value!a}: give plain text.")
            if isinstance(value, int) and abs(value) > 2**53:
                raise InvalidInput(
                    f"Axis {self.name!r} has the value {shortened(value)}: give whole numbers up to 2^53."
                )
        if len(set(values)) < len(values):
            twice = next(value for value in values if values.count(value) > 1)
            raise InvalidInput(f"Axis {self.name!r} has the value {twice!r} twice: give it once.")
        distinct = tuple(dict.fromkeys(_without_rounding(values) if float in kinds else values))
        object.__setattr__(self, "values", distinct)
        object.__setattr__(self, "merged", len(values) - len(distinct))

    def _finite(self, value: Value) -> float:
        """Return `value` as a finite float."""
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise InvalidInput(
                f"Axis {self.name!r} has the value {shortened(value)}: give finite numbers."
            )
        return number

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

    def override(
        self, values: str | Iterable[Value], *, max_count: int | None = MAX_POINTS
    ) -> "Axis":
        """Return this axis with other values.

        Parameters
        ----------
        values
            Text such as ``"0:10"`` or ``"0.6,2.4"``, or numbers or names.
        max_count
            Largest number of values, which are counted before they are made; None allows any.

        Raises
        ------
        InvalidInput
            For values that are not of the axis's type, and for too many.
        """
        parts = list(_split(values, self.kind)) if isinstance(values, str) else [values]
        count = sum(len(part) if isinstance(part, Sized) else 0 for part in parts)
        check_count(self.name, count, "values", max_count, CONFIRM)
        raw = islice(chain.from_iterable(parts), None if max_count is None else max_count + 1)
        parsed = dict.fromkeys(self._convert(value) for value in raw)
        check_count(self.name, len(parsed), "values", max_count, CONFIRM)
        if self.kind is not str:  # figures and findings read from the least to the largest
            parsed = dict.fromkeys(sorted(parsed))
        if not parsed:
            raise InvalidInput(f"{self.name} is {shortened(values)}: {FORMS[self.kind]}.")
        return Axis(self.name, tuple(parsed), self.long_name, self.units)

    def _convert(self, value: Value) -> Value:
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


def is_geometric(values: np.ndarray) -> bool:
    """Return whether three positive numbers or more follow each other in equal ratios, to a thousandth."""
    if values.size < 3 or not (values > 0).all():
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.allclose(ratios, ratios[0], rtol=1e-3) and abs(ratios[0] - 1) > 1e-3)


def check_count(
    name: str, count: int, what: str, max_count: int | None, remedy: str = "give fewer"
) -> None:
    """Raise InvalidInput for more than `max_count` values, or more than this machine's memory can hold."""
    if max_count is not None and count > max_count:
        raise InvalidInput(f"{name} has {count} {what}, more than {max_count}: {remedy}.")
    if count * POINT_BYTES > available_bytes():
        raise InvalidInput(
            f"{name} has {count} {what}, which take some {count * POINT_BYTES / 1e9:.3g} GB of memory, and "
            f"there are {available_bytes() / 1e9:.3g} GB: give fewer."
        )


def _without_rounding(values: Sequence[Value]) -> list[Value]:
    """Return, for each number, the first in `values` that is equal to it up to rounding."""
    numbers = [float(value) for value in values]
    span = max(numbers) - min(numbers)
    groups: list[list[int]] = []
    for position in sorted(range(len(numbers)), key=numbers.__getitem__):
        last = groups[-1][-1] if groups else position
        size = max(abs(numbers[position]), abs(numbers[last]))
        if groups and numbers[position] - numbers[last] <= EQUAL_WITHIN * min(span, size):
            groups[-1].append(position)
        else:
            groups.append([position])
    first = {position: min(group) for group in groups for position in group}
    return [values[first[position]] for position in range(len(values))]


def _split(text: str, kind: type) -> Iterator[Sequence[str] | Sequence[float]]:
    """Yield the values of each part between commas; a part that is not a range stays as text."""
    for part in text.split(","):
        match = RANGE.fullmatch(part.strip()) if kind is not str else None
        values = None if match is None else values_between(*match.groups(""), kind=kind)
        yield (part.strip(),) if values is None else values


def values_between(
    first: str, last: str, count: str, spacing: str, *, kind: type
) -> Sequence[float] | None:
    """Return the values of a range, of type `kind`, both ends included; None for text that is not a range.

    Without a `count` they are all whole numbers between the ends. A range rises and has at least two values. With the
    `spacing` "log" it has equal ratios and begins above 0; one of whole numbers has whole ends.
    """
    low, high, is_integer = float(first), float(last), kind is int
    if is_integer and not (low.is_integer() and high.is_integer()):
        return None
    if not count:
        rises = is_integer and low <= high and high - low < 2**53
        return range(int(low), int(high) + 1) if rises else None
    number, is_range = int(count), low < high and not (spacing and low <= 0)
    if number < 2 or not is_range or number * POINT_BYTES > available_bytes():
        return None
    spaced = np.geomspace(low, high, number) if spacing else np.linspace(low, high, number)
    if is_integer:
        rounded = np.round(spaced).astype(int)
        if not spacing and np.abs(spaced - rounded).max() > 1e-9 * max(-low, high):
            return None
        return [int(value) for value in np.unique(rounded)]
    # rounded to twelve digits, so that 3e-07 is not 3.0000000000000004e-07
    return [float(f"{value:.12g}") for value in spaced]

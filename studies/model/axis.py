"""The axes of a study: their values, and how a person writes them."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence, Sized
from dataclasses import dataclass, field
from itertools import chain, islice

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.checks import suggestion
from contactstudy.domain.memory import available_bytes
from studies.model.plain_text import is_storable, name_problem, one_line

Value = str | int | float
ROUNDING = 1e-12  # of the span of an axis and of a number: less is no other number
MOST_POINTS = 1_000_000  # of a study, for which nobody is asked
POINT_BYTES = 500  # of memory for a point, at the least

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
# first:last, first:last:count or first:last:count:log
RANGE = re.compile(rf"({NUMBER})\s*:\s*({NUMBER})(?:\s*:\s*(\d+)(?:\s*:\s*(log))?)?")

FORMS = {
    int: "give whole numbers such as 0,1,6, all of a range such as 0:10, or so many such as 32:1024:6:log",
    float: "give numbers such as 0.6,2.4, or so many of a range such as 0.6:2.4:4 or 1:100:3:log",
    str: "give names separated by commas",
}


def one_of(field: str, value: object, known: Iterable[str]) -> str:
    """``value``, if it is one of the names ``known``; else :class:`~contactstudy.InvalidInput`."""
    choices = list(known)
    if value not in choices:
        raise InvalidInput(f"{field} is {value!r}: {suggestion(str(value), choices)}.")
    return str(value)


@dataclass(frozen=True)
class Axis:
    """Values of one parameter, all of one type, and what labels them in a Dataset.

    Of numbers that differ by less than 1e-12 of the axis' span and of themselves, as 0.3 and 3 * 0.1 do beside 1, the
    first stands for the others; ``merged`` counts those. Any other difference makes another value.
    """

    name: str
    values: tuple[Value, ...]
    long_name: str
    units: str = "1"
    merged: int = field(default=0, init=False, compare=False)

    def __post_init__(self) -> None:
        if problem := name_problem(self.name):
            raise InvalidInput(f"Axis name {one_line(repr(self.name), 60)}: {problem}.")
        for part, text in (("long_name", self.long_name), ("units", self.units)):
            if not isinstance(text, str) or not is_storable(text):
                raise InvalidInput(
                    f"Axis {self.name!r} has the {part} {one_line(repr(text), 60)}: give text without control "
                    "characters."
                )
        given: object = self.values
        if isinstance(given, str) or not isinstance(given, Iterable):
            raise InvalidInput(
                f"Axis {self.name!r} has values {one_line(repr(self.values), 60)}: give a tuple of them."
            )
        # numpy's scalars become Python's, and one number with a fraction makes all of them such
        values = tuple(v.item() if isinstance(v, np.generic) else v for v in self.values)
        kinds = {type(value) for value in values}
        if not (kinds == {str} or (kinds and kinds <= {int, float})):
            raise InvalidInput(
                f"Axis {self.name!r} has values {one_line(repr(values), 60)}: give names, or numbers, and not "
                "both."
            )
        if float in kinds:
            values = tuple(self._finite(value) for value in values)
        for value in values:
            if isinstance(value, str) and not is_storable(value):
                raise InvalidInput(f"Axis {self.name!r} has the value {value!a}: give plain text.")
            if isinstance(value, int) and abs(value) > 2**53:
                raise InvalidInput(
                    f"Axis {self.name!r} has the value {_shortened(value)}: give whole numbers up to 2^53."
                )
        if len(set(values)) < len(values):
            twice = next(value for value in values if values.count(value) > 1)
            raise InvalidInput(f"Axis {self.name!r} has the value {twice!r} twice: give it once.")
        distinct = tuple(dict.fromkeys(_without_rounding(values) if float in kinds else values))
        object.__setattr__(self, "values", distinct)
        object.__setattr__(self, "merged", len(values) - len(distinct))

    def _finite(self, value: Value) -> float:
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise InvalidInput(
                f"Axis {self.name!r} has the value {_shortened(value)}: give finite numbers."
            )
        return number

    @property
    def kind(self) -> type:
        """int, float or str, by the first value."""
        return type(self.values[0])

    def override(self, values: str | Iterable[Value], *, most: int | None = MOST_POINTS) -> "Axis":
        """This axis with other values, as text (``"0:10"``, ``"0.6,2.4"``) or as numbers or names.

        Raises :class:`~contactstudy.InvalidInput` for what is not of the axis's kind, and for more than
        ``most`` values, which are counted before they are made.
        """
        parts = list(_split(values, self.kind)) if isinstance(values, str) else [values]
        count = sum(len(part) if isinstance(part, Sized) else 0 for part in parts)
        check_count(self.name, count, "values", most)
        raw = islice(chain.from_iterable(parts), None if most is None else most + 1)
        parsed = dict.fromkeys(self._convert(value) for value in raw)
        check_count(self.name, len(parsed), "values", most)
        if self.kind is not str:  # figures and findings read from the least to the largest
            parsed = dict.fromkeys(sorted(parsed))
        if not parsed:
            raise InvalidInput(f"{self.name} is {_shortened(values)}: {FORMS[self.kind]}.")
        return Axis(self.name, tuple(parsed), self.long_name, self.units)

    def beside(self, stored: Iterable[Value]) -> "Axis":
        """Return this axis with ``stored`` values in place of those that differ from one by rounding alone."""
        if self.kind is not float:
            return self
        first = [value for value in stored if isinstance(value, float)]
        values = _without_rounding([*first, *self.values])[len(first) :]
        changed = sum(old != new for old, new in zip(self.values, values, strict=True))
        axis = Axis(self.name, tuple(dict.fromkeys(values)), self.long_name, self.units)
        object.__setattr__(axis, "merged", self.merged + changed)
        return axis

    def _convert(self, value: Value) -> Value:
        try:
            if isinstance(value, bool) or (self.kind is str and not isinstance(value, str)):
                raise TypeError
            converted = self.kind(value)
            exact = self.kind is not int or float(value) == converted
        except (TypeError, ValueError, OverflowError):
            exact = False
        if not exact or (self.kind is float and not math.isfinite(converted)):
            raise InvalidInput(f"{self.name} is {_shortened(value)}: {FORMS[self.kind]}.")
        return converted  # type: ignore[no-any-return]


def check_count(name: str, count: int, what: str, most: int | None) -> None:
    """Refuses more than ``most``, and what no memory of this machine could hold."""
    if most is not None and count > most:
        raise InvalidInput(
            f"{name} has {count} {what}, more than {most}: give fewer, or --yes if you mean it."
        )
    if count * POINT_BYTES > available_bytes():
        raise InvalidInput(
            f"{name} has {count} {what}, which take some {count * POINT_BYTES / 1e9:.3g} GB of memory, and "
            f"there are {available_bytes() / 1e9:.3g} GB: give fewer."
        )


def _shortened(value: object) -> str:
    try:
        return one_line(repr(value), 60)
    except ValueError:  # a whole number too long to be written
        return "a number of thousands of digits"


def _without_rounding(values: Sequence[Value]) -> list[Value]:
    """Return, for each number, the first in ``values`` that differs from it by rounding alone."""
    numbers = [float(value) for value in values]
    span = max(numbers) - min(numbers)
    groups: list[list[int]] = []
    for place in sorted(range(len(numbers)), key=numbers.__getitem__):
        last = groups[-1][-1] if groups else place
        size = max(abs(numbers[place]), abs(numbers[last]))
        if groups and numbers[place] - numbers[last] <= ROUNDING * min(span, size):
            groups[-1].append(place)
        else:
            groups.append([place])
    first = {place: min(group) for group in groups for place in group}
    return [values[first[place]] for place in range(len(values))]


def _split(text: str, kind: type) -> Iterator[Sequence[str] | Sequence[float]]:
    """Yield the values of each part between commas; a part that is no range stays as it is."""
    for part in text.split(","):
        found = RANGE.fullmatch(part.strip()) if kind is not str else None
        values = None if found is None else values_between(*found.groups(""), whole=kind is int)
        yield (part.strip(),) if values is None else values


def values_between(
    first: str, last: str, count: str, spacing: str, *, whole: bool
) -> Sequence[float] | None:
    """Return the values of a range that a person writes as ``first:last:count`` or ``first:last:count:log``.

    Both ends belong to it. Without a count they are all whole numbers between them. Returns None for what is no
    range: one that does not rise, has fewer than two values, a logarithmic one from zero, or one of whole numbers
    between numbers with a fraction.
    """
    low, high = float(first), float(last)
    if whole and not (low.is_integer() and high.is_integer()):
        return None
    if not count:
        rises = whole and low <= high and high - low < 2**53
        return range(int(low), int(high) + 1) if rises else None
    if (
        int(count) < 2
        or low >= high
        or (spacing and low <= 0)
        or int(count) * POINT_BYTES > available_bytes()
    ):
        return None
    spaced = np.geomspace(low, high, int(count)) if spacing else np.linspace(low, high, int(count))
    if whole:
        rounded = np.round(spaced).astype(int)
        if not spacing and np.abs(spaced - rounded).max() > 1e-9 * high:
            return None
        return [int(value) for value in np.unique(rounded)]
    # to twelve digits, so that the number that was meant comes out: 3e-07 and not 3.0000000000000004e-07
    return [float(f"{value:.12g}") for value in spaced]

"""The axes of a study: their values, and how a person writes them."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.checks import suggestion

Value = str | int | float

FORMS = {
    int: "give whole numbers such as 0,1,6 or a range with both its ends such as 0:10 or 0:10:2",
    float: "give numbers such as 0.6,2.4",
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
    """Values of one parameter, all of one type, and what labels them in a Dataset."""

    name: str
    values: tuple[Value, ...]
    long_name: str
    units: str = "1"

    def __post_init__(self) -> None:
        # numpy's scalars become Python's, and one number with a fraction makes all of them such
        values = tuple(v.item() if isinstance(v, np.generic) else v for v in self.values)
        if (
            not values
            or isinstance(values[0], bool)
            or not isinstance(values[0], str | int | float)
        ):
            raise InvalidInput(
                f"Axis {self.name!r} has values {self.values!r}: give names or numbers."
            )
        if any(isinstance(value, float) for value in values):
            values = tuple(_snapped(float(value)) for value in values)
        object.__setattr__(self, "values", values)

    @property
    def kind(self) -> type:
        """int, float or str, by the first value."""
        return type(self.values[0])

    def override(self, values: str | Iterable[Value]) -> "Axis":
        """This axis with other values, as text (``"0:10"``, ``"0.6,2.4"``) or as numbers or names.

        Raises :class:`~contactstudy.InvalidInput` for what is not of the axis's kind.
        """
        raw = list(_split(values, self.kind)) if isinstance(values, str) else list(values)
        parsed = dict.fromkeys(self._convert(value) for value in raw)
        if self.kind is not str:  # figures and findings read from the least to the largest
            parsed = dict.fromkeys(sorted(parsed))
        if not parsed:
            raise InvalidInput(f"{self.name} is {values!r}: {FORMS[self.kind]}.")
        return Axis(self.name, tuple(parsed), self.long_name, self.units)

    def _convert(self, value: Value) -> Value:
        try:
            if isinstance(value, bool) or (self.kind is str and not isinstance(value, str)):
                raise TypeError
            converted = self.kind(value)
            exact = self.kind is not int or float(value) == converted
        except (TypeError, ValueError, OverflowError):
            exact = False
        if not exact or (self.kind is float and not math.isfinite(converted)):
            raise InvalidInput(f"{self.name} is {value!r}: {FORMS[self.kind]}.")
        return _snapped(converted) if self.kind is float else converted


def _snapped(value: float) -> float:
    """The shortest number with fifteen digits: 3 * 0.1 is 0.3."""
    return float(f"{value:.15g}")


def _split(text: str, kind: type) -> Iterator[str | int]:
    for part in text.split(","):
        part = part.strip()
        bounds = part.split(":")
        if kind is int and len(bounds) in (2, 3) and all(_is_whole(bound) for bound in bounds):
            first, last, *step = (int(bound) for bound in bounds)
            # an empty or endless range is no range: it is refused as the text it is
            if first <= last and all(s > 0 for s in step):
                yield from range(first, last + 1, *step)
                continue
        yield part


def _is_whole(text: str) -> bool:
    try:
        int(text)
    except ValueError:
        return False
    return True

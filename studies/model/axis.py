"""Axes of a study: their values, and the notation of values in text."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.checks import suggestion
from studies.model.plain_text import is_storable, name_problem, shortened
from studies.model.values import check_count, parse_values

if TYPE_CHECKING:
    import xarray as xr

Value = str | int | float
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
        for part, text in (("long_name", self.long_name), ("units", self.units)):
            if not isinstance(text, str) or not is_storable(text):
                raise InvalidInput(
                    f"Axis {self.name!r} has the {part} {shortened(text)}: give text without control characters."
                )
        raw: object = self.values
        if isinstance(raw, str) or not isinstance(raw, Iterable):
            raise InvalidInput(f"Axis {self.name!r} has values {shortened(self.values)}: give a tuple of them.")
        # numpy's scalars become Python's, and one number with a fraction makes all of them such
        values = tuple(value.item() if isinstance(value, np.generic) else value for value in self.values)
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
        object.__setattr__(self, "values", values)

    def _finite(self, value: Value) -> float:
        """Return `value` as a finite float."""
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise InvalidInput(f"Axis {self.name!r} has the value {shortened(value)}: give finite numbers.")
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
